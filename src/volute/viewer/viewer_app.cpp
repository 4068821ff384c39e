// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_app.hpp"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/plain_number.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/base/thread_priority.hpp"
#include "volute/scene/scene.hpp"
#include "volute/viewer/error_text.hpp"
#include "volute/viewer/panels.hpp"
#include "volute/viewer/view_report.hpp"

namespace volute {
namespace {

constexpr double kRest = 0.25;         ///< [s] until surfaces are drawn exactly
constexpr double kQuickPicture = 0.1;  ///< [s] that the CPU's first picture may take
constexpr int kLively = 6;             ///< frames in which panels answer an event
constexpr double kAround = 10;         ///< [s] of a film around what moves for less than that
constexpr double kUnseen = 0.1;        ///< [s] after which panels are drawn again while it plays

}  // namespace

ViewerApp::ViewerApp(OpenDocument open, const ViewerOptions& options, ViewPicture picture)
    : options_(options),
      document_(open, options),
      playback_(document_),
      view_(settings_, document_, playback_, std::move(picture)),
      tools_{{settings_, document_}, {view_, document_}},
      report_(document_, view_, playback_),
      leaving_(leaveActions()),
      comparison_(std::move(open)),
      recovery_(options.recent.empty() ? options.recent : options.recent.parent_path() / "unsaved"),
      language_(options.recent.empty() ? options.recent
                                       : options.recent.parent_path() / "language") {
  lowerWorkerPriority();
  if (options_.renderer)
    settings_.look.renderer = static_cast<int>(*options_.renderer);
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.UserData = &language_;
  useFont(fontScale_);
  styleControls();
  window_.clipboard().serve();
  document_.loader().setOpenGl(
      view_.picture().mayUseGl(static_cast<ViewRenderer>(settings_.look.renderer)));
  ImGui_ImplOpenGL3_Init("#version 450");
}

ViewerApp::~ViewerApp() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

Result<std::unique_ptr<ViewerApp>> ViewerApp::create(OpenDocument open,
                                                     const ViewerOptions& options) {
  VOLUTE_ASSIGN(auto device, currentGlDevice());
  VOLUTE_ASSIGN(auto picture,
                ViewPicture::create(
                    {.hardware = device.hardware,
                     .device = device.renderer,
                     .cpu = options.cpu,
                     .rasteriser = options.rasteriser || options.renderer == ViewRenderer::kGl}));
  return std::unique_ptr<ViewerApp>(new ViewerApp(std::move(open), options, std::move(picture)));
}

LeaveQuestion::Actions ViewerApp::leaveActions() {
  using What = LeaveQuestion::What;
  return {.unsaved =
              [this](What what, std::size_t passed) {
                const DocumentInfo* info = document_.info();
                return what == What::kMap ? tools_.painting.chooseUnsaved(passed)
                                          : info && info->changed;
              },
          .save =
              [this](What what) {
                const bool map = what == What::kMap;
                document_.files().allow(map ? settings_.mapName : settings_.sceneName);
                map ? tools_.painting.save() : saveScene();
              },
          .open = [this](const std::string& path) { open(path); }};
}

std::string titleOf(ViewerApp& app) {
  const DocumentInfo* info = app.document().info();
  if (!info)
    return "Volute";
  const bool unsaved = app.tools().painting.unsaved() || info->changed;
  const bool restored = Recovery::nameOf(info->path).has_value();
  return (unsaved ? "* " : "") +
         std::filesystem::path(restored ? info->sceneName : info->path).filename().string() +
         (restored ? fmt::format(" ({})", tr("restored")) : "") + " - Volute";
}

void ViewerApp::takeDocument(const DocumentNews& news, const ViewerInput& input) {
  const DocumentInfo& info = *document_.info();
  if (news.another)
    view_.picture().forgetCosts();
  if (news.begun) {  // nothing stays of the file before
    timeAsked_ = news.begun->has_value();
    view_.forget();
    tools_.painting.drop();
    tools_.pointer.place("");
    playback_.begin(news.begun->value_or(info.firstTime));
    if (!Recovery::nameOf(info.path))
      document_.files().recent().add(info.path);
    comparison_.end();
    if (!other_.empty()) {
      const Status begun = comparison_.begin(std::exchange(other_, {}), view_.picture().makers());
      if (!begun)
        document_.say(viewerText(begun.error()));
    }
    recovery_.adopt(info.path);
  }
  tools_.painting.take(info, news.another);
  view_.cameraPath().take(info);
  if (news.another || news.otherTimes)
    playback_.setFrames(info, news.another);
  if (const auto key = view_.cameraPath().takeSeek())
    playback_.timeline().seek(*key);
  if (!news.another)
    return;
  settings_.sceneName = info.sceneName;
  const bool begins = view_.begin(input.width, input.height);
  if (begins && rest_)
    view_.camera() = *std::exchange(rest_, std::nullopt);
  if (!begins || !info.look)
    return;
  if (options_.renderer)
    settings_.look.renderer = static_cast<int>(*options_.renderer);
  Timeline& timeline = playback_.timeline();
  timeline.setSpeed(info.look->speed);
  const auto loop = info.look->loop.value_or(std::array{0.0, 0.0});
  timeline.setLoop(loop[0], loop[1]);
  if (!timeAsked_ && info.look->time)
    timeline.seek(*info.look->time);
}

void ViewerApp::takeLoaded(const ViewerInput& input) {
  const Stopwatch watch(window_.costs().loaded);
  auto news = document_.take();
  if (!news)
    return;  // then in the next frame
  if (news->changed)
    takeDocument(*news, input);
  if (news->scene && document_.scene()->scene.get() != view_.picture().scene())
    document_.loader().discard(view_.picture().setScene(document_.scene()->scene));
  if (news->frozen)
    playback_.takeFilmScene(std::move(*news->frozen));
  if (!news->idle)
    return;
  tools_.painting.endSaving();
  leaving_.goOn();
}

/// To the scene that is open; without one, and for another scene, opens it.
void ViewerApp::addFile(const std::string& path) {
  const bool adds = document_.info() && document_.info()->editable && !isScenePath(path);
  adds ? document_.add(path) : leaving_.leaveFor(path);
}

void ViewerApp::takeFile(const std::string& path) {
  using enum DocumentFiles::Purpose;
  if (document_.files().purpose() == kOpen)
    return leaving_.leaveFor(path);
  if (document_.files().purpose() == kAdd)
    return addFile(path);
  if (const auto sought = document_.files().takeSought()) {
    const auto scene = withFileAt(*sought, path);
    if (!scene)
      return document_.say(viewerText(scene.error()));
    return leaving_.leaveFor(recovery_.keepMended(*scene, sought->scene));
  }
  if (const Status begun = comparison_.begin(path, view_.picture().makers()); !begun)
    document_.say(viewerText(begun.error()));
}

ViewerRest ViewerApp::rest() const {
  const DocumentInfo* info = document_.info();
  if (!info)
    return {};
  return {
      info->unsaved.empty() ? info->path : recovery_.keepMended(info->unsaved, settings_.sceneName),
      playback_.timeline().time(), view_.camera()};
}

void ViewerApp::open(const ViewerRest& rest, std::string other) {
  rest_ = rest.camera;
  if (!rest.path.empty())
    open(rest.path, rest.time, std::move(other));
}

void ViewerApp::saveScene() {
  const std::string target = settings_.sceneName;
  if (!document_.info() || !document_.files().mayWrite(target, [this] { saveScene(); }))
    return;
  document_.loader().change(
      "save scene",
      [target, view = view_.camera().view(), look = view_.look()](
          Document& document, Progress&) -> Result<std::string> {
        VOLUTE_TRY(document.save(target, view, look));
        const std::string maps = unsavedMaps(document.info().canvases);
        return target + " is written" +
               (maps.empty() ? "" : "; the fog painted on " + maps + " is not saved yet");
      });
}

void ViewerApp::beginFilm(const ViewerInput& input) {
  if (!document_.files().mayWrite(settings_.filmName, [this, input] { beginFilm(input); }))
    return;
  constexpr int kSizes[][2] = {{640, 360}, {1280, 720}, {1920, 1080}};
  const Timeline& timeline = playback_.timeline();
  FilmOrder order;
  order.target = settings_.filmName;
  order.width = input.pixelsAcross(), order.height = input.pixelsDown();
  if (settings_.filmSize < 3)
    order.width = kSizes[settings_.filmSize][0], order.height = kSizes[settings_.filmSize][1];
  order.begin = timeline.loopBegin(), order.end = timeline.loopEnd();
  order.speed = timeline.speed();
  if (settings_.follows && view_.cameraPath().leads())
    order.keys = view_.cameraPath().keys();
  order.turns = settings_.filmTurns && order.keys.empty();
  constexpr double kBrief = 2;  // [s]: too fast for a turn, or but one picture
  if (order.turns && (order.end - order.begin) / order.speed < kBrief)
    order.length = kAround;
  order.camera = view_.camera();
  order.renderer = static_cast<ViewRenderer>(settings_.look.renderer);
  order.surfaces = settings_.look.surfaces;
  order.look = view_.display();
  if (const DocumentInfo* info = document_.info())
    order.content = info->path + info->unsaved + info->files;
  if (!options_.recent.empty())
    order.folder = options_.recent.parent_path() / "films";
  playback_.beginFilm(order, view_.picture().makers());
}

WorkNotes::Seen ViewerApp::seenWork() const {
  const ViewPicture& picture = view_.picture();
  const LoadedScene* scene = document_.scene();
  WorkNotes::Seen seen;
  seen.loads = document_.loading().busy && !playback_.timeline().playing();
  seen.stage = document_.loading().stage;
  seen.loaded = document_.loading().share;
  seen.drawn = picture.progress();
  seen.draws = seen.drawn.busy && !moving_ && !picture.stopped();
  if (const ReportJob* job = report_.job())
    seen.report = job->share(), seen.reportLeft = job->secondsLeft();
  seen.shown = picture.shown();
  const double wanted = playback_.timeline().snapshotTime();
  const bool failed = scene && document_.idle() && std::abs(scene->time - wanted) > 1e-9;
  seen.late =
      !moving_ && scene && picture.shown() &&
      (failed || picture.state().stale || std::abs(picture.state().time - scene->time) > 1e-9);
  if (failed && !document_.error().empty())
    seen.lack =
        fmt::format(fmt::runtime(tr("the picture is of {} s")), plainNumber(scene->time, 4));
  return seen;
}

PictureRequest ViewerApp::request(const ViewerInput& input) const {
  const bool changes = document_.changing() || playback_.film();
  return {.camera = view_.camera(),
          .width = input.pixelsAcross(),
          .height = input.pixelsDown(),
          .quality = static_cast<Quality>(settings_.look.quality),
          .renderer = static_cast<ViewRenderer>(settings_.look.renderer),
          .surfaces = settings_.look.surfaces,
          .moving = moving_,
          .budget = playback_.budget(kQuickPicture),
          .exactAfter = changes ? std::numeric_limits<double>::infinity() : kRest};
}

void ViewerApp::usePanels(const ViewerInput& input) {
  const Stopwatch watch(window_.costs().panels);
  if (std::exchange(fontScale_, input.scale) != input.scale) {
    useFont(fontScale_);
#if IMGUI_VERSION_NUM < 19200  // later ones follow the font by themselves
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
#endif
  }
  feed(input);
  useKeyboard(input);
  window_.forgetControls();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  moving_ = playback_.timeline().playing();
  keys(input);
  control(input);
  playback_.timeline().advance(input.seconds);
  if (settings_.follows && !pointer_.drags) {
    if (const auto there = view_.cameraPath().follow(view_.camera(), playback_.timeline().time()))
      view_.camera() = *there, moving_ = true;
  }
  drawPanels(*this, input);
  focusPanel();
  ImGui::Render();
  playback_.goOnWithFilm(view_.picture());
  playback_.request();
}

void ViewerApp::show(const DisplayLook& look, bool panels) {
  const Stopwatch watch(window_.costs().shown);
  ViewPicture& picture = view_.picture();
  if (!picture.shown() && document_.opening())
    picture.prepareShow();
  const int width = seen_.pixelsAcross(), height = seen_.pixelsDown();
  glViewport(0, 0, width, height);
  glClearColor(0.05F, 0.05F, 0.06F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (picture.shown()) {
    picture.show(look, width, height);
    comparison_.show(look, width, height);
  }
  if (panels)
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

Result<bool> ViewerApp::frame(const ViewerInput& input) {
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  seen_ = input;
  lively_ = std::max(lively_ - 1, 0);
  window_.costs() = {};
  tools_.pointer.setSize(input.width, input.height);
  if (!input.dropped.empty())
    addFile(input.dropped);
  if (input.closes)
    leaving_.leaveFor("");
  if (const auto chosen = document_.files().takeChosen())
    takeFile(*chosen);
  takeLoaded(input);
  if (document_.info() && !recovery_.keep(document_.info()->unsaved, settings_.sceneName)) {
    document_.say(
        fmt::format(fmt::runtime(tr("{} cannot be written: unsaved changes are lost if the viewer "
                                    "ends without asking")),
                    recovery_.folder().string()),
        true);
  }
  report_.update();
  window_.notes().update(seenWork(), document_.message());
  usePanels(input);
  {
    const Stopwatch watch(window_.costs().picture);
    view_.draw(request(input));
    if (comparison_.active())
      comparison_.update(request(input), playback_.timeline().snapshotTime(), document_.info());
  }
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
  unseen_ += input.seconds;
  playback_.noteShown(input.seconds, view_.picture().state().time);
  const int version = view_.picture().state().version;
  if (std::exchange(steps_, false) && version == shownVersion_ && unseen_ <= kUnseen)
    return false;
  unseen_ = 0;
  shownVersion_ = version;
  shownLook_ = view_.display();
  comparison_.addTo(shownLook_);
  show(shownLook_);
  return true;
}

/// Else the last frame may stay: what it took is better spent on pictures. While it plays, a frame
/// that only asks for the next picture need not be drawn either.
bool ViewerApp::due(const ViewerInput& input) {
  const Timeline& timeline = playback_.timeline();
  Timeline then = timeline;
  then.advance(input.seconds);
  const bool acts = !input.pressed.empty() || !input.typed.empty() || !input.dropped.empty() ||
                    !input.held.empty() || input.closes || input.wheel != 0 ||
                    input.mouseX != seen_.mouseX || input.mouseY != seen_.mouseY ||
                    input.pixelsAcross() != seen_.pixelsAcross() ||
                    input.pixelsDown() != seen_.pixelsDown() || input.scale != seen_.scale ||
                    std::ranges::count(input.buttons, true) > 0 ||
                    !std::ranges::equal(input.buttons, seen_.buttons);
  if (acts || playback_.film() || report_.job() || view_.picture().refining() || leaving_.asked())
    lively_ = kLively;
  const bool writes = ImGui::GetIO().WantTextInput && input.seconds > 0.25;  // the cursor blinks
  const bool shows = lively_ > 0 || writes || view_.picture().hasNews() || input.seconds > 0.5;
  if (comparison_.active() && !comparison_.settled(request(input)))
    lively_ = kLively;
  const bool steps = document_.hasNews() || then.snapshotTime() != timeline.snapshotTime();
  steps_ = !shows && steps && timeline.playing();
  return shows || steps;
}

double ViewerApp::patience() const {
  constexpr double kMoves = 1.0 / 60, kWaits = 1.0 / 30, kRests = 0.25;
  if (moving_ || playback_.film() || view_.picture().refining())
    return kMoves;
  return settled() ? kRests : kWaits;
}

bool ViewerApp::settled() const {
  const PictureRequest requested = request(seen_);
  const ViewPicture& picture = view_.picture();
  const bool there = document_.info() && document_.scene();
  return document_.idle() && !playback_.film() && !report_.job() && picture.settled(requested) &&
         picture.exact(requested) && (!comparison_.active() || comparison_.settled(requested)) &&
         (there || !document_.error().empty());
}

}  // namespace volute
