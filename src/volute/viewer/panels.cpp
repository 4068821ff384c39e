// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/panels.hpp"

#include <imgui.h>

#include <algorithm>

namespace volute {
namespace {

constexpr float kWidth = 300;
constexpr float kLabels = 96;  ///< [pixels] that are left for names

void documentPart(const ViewerApp& app) {
  if (const DocumentInfo* document = app.document())
    wrappedText(document->title);
  else if (!app.loading().busy)
    wrappedText("Drop a file here to open it.", true);
  if (app.loading().busy) {
    const double share = app.loading().share;
    ImGui::ProgressBar(share < 0 ? 0.0F : static_cast<float>(share), {-1, 0},
                       app.loading().stage.c_str());
  }
  if (!app.error().empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, {1, 0.5F, 0.4F, 1});
    wrappedText(app.error());
    ImGui::PopStyleColor();
  }
  if (!app.message().empty())
    wrappedText(app.message());
  if (!app.picture().remark().empty())
    wrappedText(app.picture().remark(), true);
  if (const DocumentInfo* document = app.document()) {
    for (const std::string& remark : document->remarks) wrappedText(remark, true);
  }
}

void combo(ViewerApp& app, const char* name, int& value,
           std::initializer_list<std::string> choices) {
  choiceBox(app, name, name, std::span(choices.begin(), choices.size()), value);
}

/// How much of the scene is seen: an angle, or a parallel camera's height.
void viewSlider(ViewerApp& app) {
  ViewCamera& camera = app.camera();
  double seen = camera.parallel() ? camera.ortho() : camera.fov();
  if (camera.parallel()) {
    const double size = app.document() ? app.document()->bounds.size().norm() : 1;
    if (sliderDouble("view", seen, 0.01 * size, 3 * size, "%.3g m high", true))
      camera.setOrtho(seen);
    hint("the scene's camera is parallel");
  } else if (sliderDouble("view", seen, 10, 120, "%.0f degrees")) {
    camera.setFov(seen);
  }
  app.mark("view");
}

void picturePart(ViewerApp& app, const ViewerInput& input) {
  ViewLook& look = app.settings().look;
  sliderDouble("exposure", look.stops, -8, 8, "%+.1f stops");
  app.mark("exposure");
  if (app.document() && app.document()->grey)
    combo(app, "colours", look.colors, {"grey", "viridis", "inferno"});
  combo(app, "quality", look.quality, {"automatic", "full", "half", "quarter"});
  combo(app, "renderer", look.renderer, {"automatic", "OpenGL", "processor"});
  viewSlider(app);
  if (app.picture().scene() && app.picture().scene()->bare) {
    ImGui::Checkbox("surfaces", &look.surfaces);
    app.mark("surfaces");
    hint("walls, ground and whatever else is opaque, signs apart");
  }
  int mode = static_cast<int>(app.camera().mode());
  combo(app, "camera", mode, {"orbit", "walk"});
  app.camera().setMode(static_cast<ViewCamera::Mode>(mode));
  if (ImGui::Button("Whole view"))
    app.wholeView(input.width, input.height);
  app.mark("Whole view");
  hint("all that there is, from outside");
  ImGui::SameLine();
  if (ImGui::Button("Screenshot"))
    app.wishScreenshot();
  app.mark("Screenshot");
  ImGui::SameLine();
  if (ImGui::Button("Help"))
    app.settings().help = !app.settings().help;
  app.mark("Help");
  if (!app.document() || !app.document()->startView)
    return;
  if (ImGui::Button("Scene's view"))
    app.resetView(input.width, input.height);
  app.mark("Scene's view");
  hint("from where the scene's file looks");
}

/// The cameras of a capture.
void stationPart(ViewerApp& app) {
  if (!app.document() || app.document()->stations.empty())
    return;
  ImGui::Separator();
  ImGui::TextUnformatted("look from");
  const float right = ImGui::GetContentRegionMax().x;
  for (const ViewStation& station : app.document()->stations) {
    if (ImGui::Button(station.name.c_str()))
      app.lookFrom(station.view);
    app.mark("look from " + station.name);
    const bool last = &station == &app.document()->stations.back();
    ImGui::SameLine();
    if (last || ImGui::GetCursorPosX() + 60 > right)
      ImGui::NewLine();
  }
}

void savePart(ViewerApp& app) {
  if (!app.document() || app.document()->sceneName.empty())
    return;
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1);  // names are long
  nameBox("##scene", app.settings().sceneName);
  hint(app.settings().sceneName);
  app.mark("scene");
  if (ImGui::Button("Save scene"))
    app.saveScene();
  app.mark("Save scene");
}

/// As `--stats` of `volute render` lists it.
void whoDraws(ViewerApp& app) {
  const FrameTimes& times = app.times();
  if (times.processor) {
    wrappedText("by the processor: " + times.why, true);
    app.mark("who draws");
    return;
  }
  wrappedText("by " + app.device().renderer, true);
  app.mark("who draws");
  const ViewScene* scene = app.picture().scene();
  if (scene && ((scene->surfaces && app.settings().look.surfaces) || !scene->quads.empty()))
    wrappedText("opaque things: rasterised", true);
  for (const GlPassTime& pass : times.passes) {
    wrappedText(fmt::format("{} {}: {:.1f} ms", pass.name, pass.media, pass.milliseconds), true);
  }
}

void timesPart(ViewerApp& app) {
  const FrameTimes& times = app.times();
  if (times.history.empty())
    return;
  ImGui::Separator();
  const float most = *std::ranges::max_element(times.history);
  ImGui::PlotHistogram("##times", times.history.data(), static_cast<int>(times.history.size()), 0,
                       nullptr, 0, 1.1F * most, {-1, 36});
  hint("how long the last pictures took");
  wrappedText(fmt::format("{:.1f} ms for {} x {} pixels, {:.0f} ms at most", times.milliseconds,
                          times.width, times.height, most));
  whoDraws(app);
}

}  // namespace

void drawHelpPanel(ViewerApp& app, const ViewerInput& input) {
  if (!app.settings().help)
    return;
  ImGui::SetNextWindowPos(
      {0.5F * static_cast<float>(input.width), 0.45F * static_cast<float>(input.height)}, 0,
      {0.5F, 0.5F});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  ImGui::Begin("Help", &app.settings().help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  constexpr const char* kLines[][2] = {{"left mouse", "turn; paint, where fog is painted"},
                                       {"right mouse", "move across; turn, while painting"},
                                       {"middle, Shift", "move across"},
                                       {"wheel", "nearer, farther"},
                                       {"M", "orbit or walk"},
                                       {"W A S D, Q E", "walk, down and up; Shift: faster"},
                                       {"F", "see all"},
                                       {"Space", "play"},
                                       {"Left, Right", "one frame"},
                                       {"Home, End", "first, last frame"},
                                       {"+  -", "exposure"},
                                       {"Ctrl Z, Ctrl Y", "undo and redo, strokes while painting"},
                                       {"Ctrl S", "save the scene"},
                                       {"Ctrl click", "write a slider's number"},
                                       {"F12", "screenshot"},
                                       {"H", "hide the panels"},
                                       {"Escape", "no painting, no placing, no help"},
                                       {"F1", "this"},
                                       {"drop a file", "open it"}};
  for (const auto& [keys, meaning] : kLines) {
    ImGui::TextDisabled("%s", keys);
    ImGui::SameLine(150);
    ImGui::TextUnformatted(meaning);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

/// A question that has to be answered before anything else.
void drawLeavePanel(ViewerApp& app, const ViewerInput& input) {
  constexpr const char* kTitle = "Painted fog is in no file";
  constexpr float kWide = 420;
  if (app.leaving() && !ImGui::IsPopupOpen(kTitle))
    ImGui::OpenPopup(kTitle);
  ImGui::SetNextWindowPos(
      {0.5F * static_cast<float>(input.width), 0.4F * static_cast<float>(input.height)}, 0,
      {0.5F, 0.5F});
  const float width = std::min(kWide, static_cast<float>(input.width) - 2 * kPanelMargin);
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  if (!ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_AlwaysAutoResize))
    return;
  if (const ViewerApp::Leaving* leaving = app.leaving()) {
    wrappedText(leaving->path.empty() ? "Before the viewer ends, save the map as"
                                      : "Before " + leaving->path + " is opened, save the map as");
    ImGui::SetNextItemWidth(-1);
    nameBox("##map", app.settings().mapName);
    app.mark("leave map");
    if (!app.error().empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, {1, 0.5F, 0.4F, 1});
      wrappedText(app.error());
      ImGui::PopStyleColor();
    }
    const bool waits = leaving->saving;
    const bool saves = markedButton(app, waits ? "Saving" : "Save", "leave save", !waits);
    ImGui::SameLine();
    const bool discards = markedButton(app, "Discard", "leave discard", !waits);
    ImGui::SameLine();
    const bool stays = markedButton(app, "Cancel", "leave cancel");
    if (saves)
      app.leaveAndSave();
    else if (discards)
      app.leaveAndDiscard();
    else if (stays)
      app.stay();
  }
  if (!app.leaving())
    ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void drawPanels(ViewerApp& app, const ViewerInput& input) {
  drawOverlay(app, input);
  drawHelpPanel(app, input);
  drawLeavePanel(app, input);
  if (!app.settings().panels)
    return;
  ImGui::SetNextWindowPos({kPanelMargin, kPanelMargin}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSizeConstraints({kWidth, 0}, {kWidth, panelHeight(app, input)});
  ImGui::Begin("Volute", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  const float bottom = ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
  ImGui::PushItemWidth(-kLabels);
  documentPart(app);
  ImGui::Separator();
  picturePart(app, input);
  stationPart(app);
  savePart(app);
  timesPart(app);
  ImGui::PopItemWidth();
  ImGui::End();
  drawParameterPanel(app, input);
  drawPaintPanel(app, input, bottom);
  drawTimePanel(app, input);
}

}  // namespace volute
