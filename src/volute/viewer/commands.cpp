// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/commands.hpp"

#include <imgui.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "volute/base/lower_case.hpp"
#include "volute/viewer/error_text.hpp"
#include "volute/viewer/language.hpp"

namespace volute {
namespace {

using App = ViewerApp;
using In = ViewerInput;

/// A stroke while fog is being painted, else what was changed of the scene, else a stroke.
void undo(App& app, const In&) {
  FogPainting& painting = app.tools().painting;
  const DocumentInfo* info = app.document().info();
  const bool strokes = painting.tool().has() && painting.tool().painter().canUndo();
  const bool changes = info && info->canUndo;
  if (strokes && (app.settings().painting || !changes))
    painting.undo();
  else if (changes)
    app.document().undo();
}

void redo(App& app, const In&) {
  FogPainting& painting = app.tools().painting;
  const DocumentInfo* info = app.document().info();
  const bool strokes = painting.tool().has() && painting.tool().painter().canRedo();
  const bool changes = info && info->canRedo;
  if (strokes && (app.settings().painting || !changes))
    painting.redo();
  else if (changes)
    app.document().redo();
}

/// As a scene's "camera" is written.
void copyCamera(App& app, const In&) {
  const StartView view = app.view().camera().view();
  const auto list = [](const Vec3& v) {
    return nlohmann::ordered_json::array({v.x(), v.y(), v.z()});
  };
  nlohmann::ordered_json camera{
      {"eye", list(view.eye)}, {"target", list(view.target)}, {"up", list(view.up)}};
  if (view.ortho > 0)
    camera["ortho"] = view.ortho;
  else
    camera["fov"] = view.fov;
  ImGui::SetClipboardText(camera.dump().c_str());
  app.document().say(tr("the camera is copied, as JSON"));
}

void stop(App& app, const In&) {
  ViewerSettings& settings = app.settings();
  settings.help = settings.search = settings.painting = settings.probe = settings.measuring = false;
  app.tools().pointer.place("");
  app.tools().pointer.forgetRuler();
  app.report().stop();
}

void measure(App& app, const In&) {
  bool& on = app.settings().measuring;
  on = !on;
  app.tools().pointer.forgetRuler();
  if (on)
    app.document().say(tr("click both ends of the distance; R or Escape ends it"));
}

void compareWithSaved(App& app, const In&) {
  if (!app.document().info())
    return;
  const std::string path = app.document().info()->path;
  if (const Status begun = app.comparison().begin(path, app.view().picture().makers()); !begun)
    app.document().say(viewerText(begun.error()));
}

void filmAround(App& app, const In& input) {
  const bool before = std::exchange(app.settings().filmTurns, true);
  app.beginFilm(input);
  app.settings().filmTurns = before;
}

void walkOrOrbit(App& app, const In&) {
  using enum ViewCamera::Mode;
  ViewCamera& camera = app.view().camera();
  camera.setMode(camera.mode() == kOrbit ? kWalk : kOrbit);
}

template <int half>
void brighten(App& app, const In&) {
  app.settings().look.stops += 0.5 * half;
}

template <int frames>
void step(App& app, const In&) {
  app.playback().timeline().step(frames);
}

/// 1/8 to 8 times, by halves and doubles.
template <bool faster>
void changeSpeed(App& app, const In&) {
  Timeline& timeline = app.playback().timeline();
  const double speed = timeline.speed() * (faster ? 2 : 0.5);
  timeline.setSpeed(std::clamp(speed, Timeline::kSlowest, Timeline::kFastest));
}

template <int axis, int sign>
void lookFrom(App& app, const In&) {
  app.view().lookFrom(sign * Vec3::Unit(axis));
}

void paintFog(App& app, const In&) {
  if (!app.tools().painting.tool().has())
    return app.document().say(tr("there is no map of fog to paint on"), true);
  app.settings().panels = app.settings().painting = true;
  app.settings().layout.set(SidePanel::kPaint, true);
}

void openScene(App& app, const In&) {
  app.settings().panels = true;
  app.settings().layout.set(SidePanel::kScene, true);
}

template <SceneEdit::Kind kind>
void addToScene(App& app, const In&) {
  if (app.document().info() && app.document().info()->editable)
    app.tools().pointer.add(kind);
}

Timeline& timelineOf(App& app) {
  return app.playback().timeline();
}

}  // namespace

std::span<const ViewerCommand> viewerCommands() {
  // clang-format off: a row is read as one
  static const ViewerCommand kCommands[] = {
      {"open a file", "Ctrl O", [](App& app, const In&) { app.document().files().askToOpen(); }, Key::kO, true},
      {"add a file to what is shown", "", [](App& app, const In&) { app.document().files().askToOpen(DocumentFiles::Purpose::kAdd); }},
      {"compare with another file", "", [](App& app, const In&) { app.document().files().askToOpen(DocumentFiles::Purpose::kCompare); }},
      {"compare with the file as it is saved", "", compareWithSaved},
      {"end the comparison", "", [](App& app, const In&) { app.comparison().end(); }},
      {"save the scene", "Ctrl S", [](App& app, const In&) { app.saveScene(); }, Key::kS, true},
      {"undo a change, or a stroke while painting", "Ctrl Z", undo, Key::kZ, true},
      {"redo", "Ctrl Y, Ctrl Shift Z", redo, Key::kY, true},
      {"", "", redo, Key::kZ, true, true},
      {"play, pause", "Space", [](App& app, const In&) { timelineOf(app).play(!timelineOf(app).playing()); }, Key::kSpace},
      {"one frame back", "Left", step<-1>, Key::kLeft},
      {"one frame on", "Right", step<1>, Key::kRight},
      {"first frame", "Home", [](App& app, const In&) { timelineOf(app).seek(timelineOf(app).loopBegin()); }, Key::kHome},
      {"last frame", "End", [](App& app, const In&) { timelineOf(app).seek(timelineOf(app).loopEnd()); }, Key::kEnd},
      {"twice as fast", "Up", changeSpeed<true>, Key::kUp},
      {"half as fast", "Down", changeSpeed<false>, Key::kDown},
      {"the loop begins here", "I", [](App& app, const In&) { timelineOf(app).loopFromHere(); }, Key::kI},
      {"the loop ends here", "O", [](App& app, const In&) { timelineOf(app).loopToHere(); }, Key::kO},
      {"loop over all frames", "L", [](App& app, const In&) { timelineOf(app).setLoop(0, 0); }, Key::kL},
      {"set or remove a mark at this time", "B", [](App& app, const In&) { app.playback().toggleMark(); }, Key::kB},
      {"to the next mark", "Ctrl Right", [](App& app, const In&) { app.playback().seekMark(1); }, Key::kRight, true},
      {"to the mark before", "Ctrl Left", [](App& app, const In&) { app.playback().seekMark(-1); }, Key::kLeft, true},
      {"set a key of the camera path at this time", "K", [](App& app, const In&) { app.view().cameraPath().set(app.view().camera(), timelineOf(app).time()); }, Key::kK},
      {"remove the nearest key of the camera path", "Ctrl K", [](App& app, const In&) { app.view().cameraPath().remove(app.view().camera(), timelineOf(app).time()); }, Key::kK, true},
      {"brighter by half a stop", "+", brighten<1>, Key::kPlus},
      {"darker by half a stop", "-", brighten<-1>, Key::kMinus},
      {"the whole view, from outside", "F", [](App& app, const In& in) { app.view().whole(in.width, in.height); }, Key::kF},
      {"the first view", "", [](App& app, const In& in) { app.view().reset(in.width, in.height); }},
      {"from the front; with Ctrl from behind", "1", lookFrom<1, -1>, Key::k1},
      {"from the right; with Ctrl from the left", "3", lookFrom<0, 1>, Key::k3},
      {"from above; with Ctrl from below", "7", lookFrom<2, 1>, Key::k7},
      {"from behind", "", lookFrom<1, 1>, Key::k1, true},
      {"from the left", "", lookFrom<0, -1>, Key::k3, true},
      {"from below", "", lookFrom<2, -1>, Key::k7, true},
      {"parallel or perspective camera", "5", [](App& app, const In&) { app.view().camera().toggleParallel(); }, Key::k5},
      {"orbit (turn around things) or walk (turn the head)", "M", walkOrOrbit, Key::kM},
      {"show what is under the pointer", "P", [](App& app, const In&) { app.settings().probe = !app.settings().probe; }, Key::kP},
      {"measure a distance by two clicks", "R", measure, Key::kR},
      {"the next control of the panels; arrows, Enter and Space use it", "Tab", [](App&, const In&) {}},
      {"choose what is shown, in the panel Scene", "", openScene},
      {"hide the panels, show them again", "H", [](App& app, const In&) { app.settings().panels = !app.settings().panels; }, Key::kH},
      {"full screen", "F11", [](App& app, const In&) { app.window().requestFullScreen(); }, Key::kF11},
      {"screenshot without panels: volute_0001.png ...", "F12", [](App& app, const In&) { app.window().requestScreenshot(); }, Key::kF12},
      {"write a report of what is shown: volute_0001.html ...", "Ctrl F12", [](App& app, const In&) { app.window().requestReport(); }, Key::kF12, true},
      {"paint fog", "", paintFog},
      {"clip by a box", "", addToScene<SceneEdit::Kind::kAddClipBox>},
      {"clip by a plane", "", addToScene<SceneEdit::Kind::kAddClipPlane>},
      {"add a sign", "", addToScene<SceneEdit::Kind::kAddSign>},
      {"add a lamp", "", addToScene<SceneEdit::Kind::kAddSpot>},
      {"add a sun", "", addToScene<SceneEdit::Kind::kAddSun>},
      {"add light from everywhere", "", addToScene<SceneEdit::Kind::kAddAmbient>},
      {"make a film", "", [](App& app, const In& in) { app.beginFilm(in); }},
      {"make a film once around, of a still in 10 s", "", filmAround},
      {"copy the camera, as JSON", "Ctrl C", copyCamera, Key::kC, true},
      {"open and close this help", "F1", [](App& app, const In&) { app.settings().help = !app.settings().help; }, Key::kF1},
      {"search all commands", "F3, Ctrl Space", [](App& app, const In&) { app.settings().search = true; }, Key::kF3},
      {"", "", [](App& app, const In&) { app.settings().search = true; }, Key::kSpace, true},
      {"language: English", "", [](App& app, const In&) { app.language().choose(Language::kEnglish); }},
      {"language: German", "", [](App& app, const In&) { app.language().choose(Language::kGerman); }},
      {"stop painting or placing, close help", "Escape", stop, Key::kEscape}};
  // clang-format on
  return kCommands;
}

void runKey(ViewerApp& app, Key key, const ViewerInput& input) {
  const ViewerCommand* found = nullptr;
  for (const ViewerCommand& command : viewerCommands()) {
    if (command.key == key && command.control == input.control && (!command.shift || input.shift) &&
        (!found || command.shift))
      found = &command;
  }
  if (found)
    found->run(app, input);
}

/// Other words that people look for.
constexpr std::pair<std::string_view, std::string_view> kAlsoCalled[] = {
    {"open a file", "load import"},
    {"add a file to what is shown", "second import append merge"},
    {"compare with another file", "difference wiper side by side"},
    {"the whole view, from outside", "fit frame all zoom reset"},
    {"the first view", "reset home camera"},
    {"twice as fast", "speed"},
    {"half as fast", "speed slower"},
    {"brighter by half a stop", "exposure light"},
    {"darker by half a stop", "exposure light"},
    {"show what is under the pointer", "value probe read"},
    {"measure a distance by two clicks", "ruler length"},
    {"screenshot without panels: volute_0001.png ...", "export save image still picture"},
    {"write a report of what is shown: volute_0001.html ...",
     "export save page document files checksum"},
    {"make a film", "export save video animation movie"},
    {"make a film once around, of a still in 10 s", "export orbit turntable video"},
    {"parallel or perspective camera", "orthographic"},
    {"full screen", "fullscreen"},
    {"choose what is shown, in the panel Scene",
     "field slice isosurface particles preset basis transfer function colours colors by value"},
    {"set a key of the camera path at this time", "keyframe animation"},
    {"set or remove a mark at this time", "bookmark"},
    {"clip by a box", "cut crop section"},
    {"clip by a plane", "cut section slice"}};

bool isFound(const ViewerCommand& command, const std::string& words) {
  const auto also = std::ranges::find(kAlsoCalled, std::string_view(command.name),
                                      &std::pair<std::string_view, std::string_view>::first);
  const std::string text =
      lowerCase(fmt::format("{} {} {} {}", command.name, tr(command.name), command.keys,
                            also == std::end(kAlsoCalled) ? "" : also->second));
  std::istringstream each(lowerCase(words));
  for (std::string word; each >> word;) {
    if (text.find(word) == std::string::npos)
      return false;
  }
  return command.name[0] != 0;
}

}  // namespace volute
