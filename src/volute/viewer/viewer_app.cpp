// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_app.hpp"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/stopwatch.hpp"
#include "volute/base/thread_priority.hpp"
#include "volute/image/picture_style.hpp"
#include "volute/image/srgb.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr double kHeldTime = 1e-9;
constexpr double kRest = 0.25;         ///< [s] until surfaces are drawn exactly
constexpr double kQuickPicture = 0.1;  ///< [s] that the CPU's first picture may take
constexpr int kAhead = 64;             ///< snapshots that are loaded ahead, memory permitting
constexpr int kLively = 6;             ///< frames in which panels answer an event
constexpr double kUnseen = 0.1;        ///< [s] after which panels are drawn again while it plays

/// Keys that ImGui edits text with.
constexpr std::pair<Key, ImGuiKey_> kTextKeys[] = {{Key::kLeft, ImGuiKey_LeftArrow},
                                                   {Key::kRight, ImGuiKey_RightArrow},
                                                   {Key::kHome, ImGuiKey_Home},
                                                   {Key::kEnd, ImGuiKey_End},
                                                   {Key::kDelete, ImGuiKey_Delete},
                                                   {Key::kBackspace, ImGuiKey_Backspace},
                                                   {Key::kEnter, ImGuiKey_Enter},
                                                   {Key::kEscape, ImGuiKey_Escape},
                                                   {Key::kA, ImGuiKey_A},
                                                   {Key::kC, ImGuiKey_C},
                                                   {Key::kV, ImGuiKey_V},
                                                   {Key::kX, ImGuiKey_X}};

}  // namespace

ViewerApp::ViewerApp(OpenDocument open, const ViewerOptions& options, GlDevice device,
                     ViewPicture picture)
    : options_(options),
      device_(std::move(device)),
      picture_(std::move(picture)),
      loader_(std::move(open)),
      files_(options.recent) {
  lowerWorkerPriority();
  if (options_.renderer)
    settings_.look.renderer = static_cast<int>(*options_.renderer);
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  for (const auto& [key, theirs] : kTextKeys) io.KeyMap[theirs] = static_cast<int>(key);
  useFont(fontScale_);
  styleControls();
  clipboard_.serve(io);
  loader_.setOpenGl(picture_.mayUseGl(static_cast<ViewRenderer>(settings_.look.renderer)));
  ImGui_ImplOpenGL3_Init("#version 450");
}

ViewerApp::~ViewerApp() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

Result<std::unique_ptr<ViewerApp>> ViewerApp::create(OpenDocument open,
                                                     const ViewerOptions& options) {
  VOLUTE_ASSIGN(auto device, currentGlDevice());
  VOLUTE_ASSIGN(auto picture, ViewPicture::create({device.hardware, options.cpu}));
  return std::unique_ptr<ViewerApp>(
      new ViewerApp(std::move(open), options, std::move(device), std::move(picture)));
}

/// Until the file is open, what is shown stays as it is.
void ViewerApp::open(const std::string& path, std::optional<double> time) {
  opening_.emplace(time);
  message_.clear();
  loader_.open(path, time);
}

void ViewerApp::leaveFor(const std::string& path) {
  using What = Leaving::What;
  if (unsavedMap())
    leaving_ = Leaving{path, What::kMap};
  else if (unsavedScene())
    leaving_ = Leaving{path, What::kScene};
  else
    leaveTo(path);
}

void ViewerApp::leaveTo(const std::string& path) {
  if (path.empty())
    ends_ = true;
  else
    open(path);
}

void ViewerApp::leaveAndSave() {
  leaving_->saving = true;
  files_.allow(leaving_->what == Leaving::What::kMap ? settings_.mapName : settings_.sceneName);
  leaving_->what == Leaving::What::kMap ? saveMap() : saveScene();
}

/// What is in no file besides is asked about next.
void ViewerApp::leaveAndDiscard() {
  const Leaving left = *std::exchange(leaving_, std::nullopt);
  if (left.what == Leaving::What::kMap && unsavedScene())
    leaving_ = Leaving{left.path, Leaving::What::kScene};
  else
    leaveTo(left.path);
}

/// Once it is written; an error of that is shown, and nothing is left.
void ViewerApp::goOnLeaving(bool idle) {
  if (!leaving_ || !leaving_->saving || !idle)
    return;
  leaving_->saving = false;
  const bool map = leaving_->what == Leaving::What::kMap;
  if (map ? !unsavedMap() : !unsavedScene())
    leaveAndDiscard();
}

/// The document's own files may be written without a question.
bool ViewerApp::mayWrite(const std::string& target, std::function<void()> then) {
  if ((document_ && target == document_->path) || (paint_.has() && target == paint_.canvas().file))
    files_.allow(target);
  return files_.mayWrite(target, std::move(then));
}

/// Another file is open: nothing stays of the one before.
void ViewerApp::beginWith(std::optional<double> asked) {
  const double time = asked.value_or(document_->firstTime);
  opening_.reset();
  timeAsked_ = asked.has_value();
  viewSet_ = exposure_.found = exposure_.tried = false;
  settings_.look.exposure.reset();
  paint_.drop();
  savedVersion_.reset();
  placing_.clear();
  settings_.painting = false;
  timeline_.setTimes({time});
  timeline_.seek(time);
  requested_ = time;
}

void ViewerApp::lookFrom(const StartView& view) {
  camera_.set(view);
}

void ViewerApp::resetView(int width, int height) {
  if (!document_)
    return;
  const auto& start = document_->startView;
  if (!start) {
    wholeView(width, height);
    return;
  }
  camera_.set(*start);
  if (start->moves)
    camera_.fit(document_->content, width, height, insets(width, height));
  if (start->walks)
    camera_.setMode(ViewCamera::Mode::kWalk);
}

void ViewerApp::wholeView(int width, int height) {
  if (!document_)
    return;
  camera_.setMode(ViewCamera::Mode::kOrbit);
  camera_.frame(document_->content, width, height, insets(width, height));
}

void ViewerApp::takeDocument(DocumentInfo opened, const ViewerInput& input) {
  const bool another = !document_ || document_->opened != opened.opened;
  const bool otherTimes = document_ && document_->times != opened.times;
  document_ = std::move(opened);
  timeline_.setInterpolates(document_->interpolates);
  if (another) {
    picture_.forgetCosts();
    scene_.reset();  // it is the last document's
    if (opening_) {
      beginWith(std::optional<double>(*opening_));
      files_.recent().add(document_->path);
    }
  }
  for (Parameter& parameter : document_->parameters) {
    if (const auto waiting = pending_.find(parameter.path); waiting != pending_.end())
      parameter.value = waiting->second;
  }
  if (document_->canvases.empty()) {
    paint_.drop();
    settings_.painting = false;
  } else {
    const std::size_t number = std::min(paint_.number(), document_->canvases.size() - 1);
    paint_.take(document_->canvases[number], number, document_->opened);
    if (savedVersion_ && !document_->canvases[number].unsaved)
      paint_.painter().markSaved(*std::exchange(savedVersion_, std::nullopt));
    plan_.invalidate();
    if (settings_.mapName.empty() || another)
      settings_.mapName = paint_.canvas().file;
    if (paint_.takeUnsent())
      sendMap();
  }
  if (!another) {
    if (otherTimes)
      timeline_.setTimes(document_->times);
    return;
  }
  const double time = timeline_.time();
  timeline_.setTimes(document_->times);
  timeline_.seek(std::max(time, requested_));
  settings_.sceneName = document_->sceneName;
  if (viewSet_)
    return;
  camera_.setMode(ViewCamera::Mode::kOrbit);
  resetView(input.width, input.height);
  viewSet_ = true;
  if (!document_->look)
    return;
  settings_.look = *document_->look;
  if (options_.renderer)
    settings_.look.renderer = static_cast<int>(*options_.renderer);
  if (settings_.look.exposure) {
    exposure_.value = *settings_.look.exposure;
    exposure_.found = true;
  }
  camera_.setMode(settings_.look.walks ? ViewCamera::Mode::kWalk : ViewCamera::Mode::kOrbit);
  timeline_.setSpeed(settings_.look.speed);
  if (!timeAsked_ && settings_.look.time)
    timeline_.seek(*settings_.look.time);
}

void ViewerApp::takeLoaded(const ViewerInput& input) {
  const Stopwatch watch(costs_.loaded);
  const int changes = loader_.changes();
  auto news = loader_.news();
  if (!news)
    return;  // then in the next frame
  loaderChanges_ = changes;
  loading_ = std::move(news->state);
  error_ = loading_.error.empty() ? pictureError_ : loading_.error;
  if (loading_.message != lastMessage_)
    message_ = lastMessage_ = loading_.message;
  const bool idle = news->idle;
  if (idle)
    pending_.clear();
  if (news->opened)
    takeDocument(std::move(*news->opened), input);
  if (idle)
    opening_.reset();  // it cannot be opened
  if (news->loaded) {
    const bool another = !picture_.scene() || news->loaded->scene.get() != picture_.scene();
    if (scene_)
      loader_.discard(std::move(scene_->scene));
    scene_ = std::move(*news->loaded);
    pictureError_.clear();
    if (another)
      loader_.discard(picture_.setScene(scene_->scene));
  }
  if (idle)
    savedVersion_.reset();  // it could not be saved
  if (news->frozen && film_)
    filmScene_ = std::move(news->frozen);
  goOnLeaving(idle);
}

void ViewerApp::setParameter(const Parameter& parameter, const std::vector<double>& value) {
  pending_[parameter.path] = value;
  for (Parameter& held : document_->parameters) {
    if (held.path == parameter.path)
      held.value = value;
  }
  loader_.change("set " + parameter.path,
                 [path = parameter.path, value](Document& document,
                                                Progress& progress) -> Result<std::string> {
                   VOLUTE_TRY(document.set(path, value, progress));
                   return "";
                 });
}

void ViewerApp::edit(const SceneEdit& edit) {
  pending_.clear();  // their paths may be others' by then
  loader_.change(fmt::format("edit {}", ++edits_), [edit](Document& document, Progress& progress) {
    return document.edit(edit, progress);
  });
}

WallPlace ViewerApp::placeAlong(const Segment& ray) const {
  if (scene_) {
    if (const auto wall = pickWall(*scene_->scene, ray))
      return *wall;
  }
  return {ray.at(camera_.distance()), -ray.direction};
}

void ViewerApp::add(SceneEdit::Kind kind) {
  const Camera camera = camera_.camera(seen_.width, seen_.height);
  const WallPlace place = placeAlong(camera.ray(0.5 * seen_.width, 0.5 * seen_.height));
  edit({.kind = kind,
        .position = place.position,
        .normal = place.normal,
        .reach = 0.25 * document_->bounds.size().norm()});
}

void ViewerApp::undoChange() {
  pending_.clear();
  loader_.change(fmt::format("edit {}", ++edits_),
                 [](Document& document, Progress& progress) -> Result<std::string> {
                   VOLUTE_TRY(document.undo(progress));
                   return "";
                 });
}

void ViewerApp::redoChange() {
  pending_.clear();
  loader_.change(fmt::format("edit {}", ++edits_),
                 [](Document& document, Progress& progress) -> Result<std::string> {
                   VOLUTE_TRY(document.redo(progress));
                   return "";
                 });
}

StartView ViewerApp::startView() const {
  return camera_.view();
}

void ViewerApp::saveScene() {
  if (!document_ || !mayWrite(settings_.sceneName, [this] { saveScene(); }))
    return;
  ViewLook look = settings_.look;
  look.speed = timeline_.speed();
  look.walks = camera_.mode() == ViewCamera::Mode::kWalk;
  look.time = timeline_.time();
  if (exposure_.found)
    look.exposure = exposure_.value;
  loader_.change("save scene",
                 [target = settings_.sceneName, view = startView(), look](
                     Document& document, Progress&) -> Result<std::string> {
                   VOLUTE_TRY(document.save(target, view, look));
                   return target + " is written";
                 });
}

void ViewerApp::saveMap() {
  if (!paint_.has() || !mayWrite(settings_.mapName, [this] { saveMap(); }))
    return;
  sendMap();
  savedVersion_ = paint_.painter().version();
  paint_.savesAs(settings_.mapName);
  loader_.change(
      "save map",
      [target = settings_.mapName, number = paint_.number(), map = paint_.painter().picture()](
          Document& document, Progress&) -> Result<std::string> {
        VOLUTE_TRY(document.saveFogMap(number, target, map));
        return target + " is written";
      });
}

void ViewerApp::sendMap() {
  plan_.invalidate();
  loader_.change(
      fmt::format("map {}", paint_.number()),
      [number = paint_.number(), map = paint_.painter().coefficients().c,
       unsaved = paint_.painter().changed()](Document& document, Progress&) -> Result<std::string> {
        VOLUTE_TRY(document.setFogMap(number, map, unsaved));
        return "";
      });
}

void ViewerApp::undoPainting() {
  if (paint_.has() && paint_.painter().undo())
    sendMap();
}

void ViewerApp::redoPainting() {
  if (paint_.has() && paint_.painter().redo())
    sendMap();
}

GLuint ViewerApp::planTexture() {
  if (plan_.stale())
    plan_.draw(paint_.painter().picture());
  return plan_.texture();
}

void ViewerApp::beginFilm(const ViewerInput& input) {
  if (!mayWrite(settings_.filmName, [this, input] { beginFilm(input); }))
    return;
  constexpr int kSizes[][2] = {{640, 360}, {1280, 720}, {1920, 1080}};
  FilmOrder order;
  order.target = settings_.filmName;
  order.width = input.pixelsAcross(), order.height = input.pixelsDown();
  if (settings_.filmSize < 3)
    order.width = kSizes[settings_.filmSize][0], order.height = kSizes[settings_.filmSize][1];
  order.begin = timeline_.first(), order.end = timeline_.last();
  order.speed = timeline_.speed();
  order.camera = camera_;
  order.renderer = static_cast<ViewRenderer>(settings_.look.renderer);
  order.surfaces = settings_.look.surfaces;
  order.look = displayLook();
  timeline_.play(false);
  auto film = FilmExport::begin(order, picture_.makers());
  if (!film) {
    message_ = film.error().message;
    return;
  }
  film_ = std::move(*film);
  loader_.freeze();
}

void ViewerApp::endFilm(std::string message) {
  message_ = std::move(message);
  film_.reset();
  filmAsked_.reset();
  if (filmScene_ && *filmScene_)
    loader_.discard(std::move((*filmScene_)->scene));
  filmScene_.reset();
  loader_.thaw();
}

/// Of the scene as it was when the film was asked for: the window's may change meanwhile.
void ViewerApp::goOnWithFilm() {
  if (!film_)
    return;
  if (film_->finished()) {
    const std::string lacked = film_->remark().empty() ? "" : "; " + film_->remark();
    return endFilm(film_->order().target + " is written" + lacked);
  }
  const auto wanted = film_->wantedTime();
  if (wanted && wanted != filmAsked_) {
    filmAsked_ = wanted;
    loader_.requestFrozen({.time = *wanted, .openGl = picture_.mayUseGl(film_->order().renderer)});
  }
  if (filmScene_ && !*filmScene_)
    return endFilm(fmt::format("{}: {}", film_->order().target, filmScene_->error().message));
  const bool there = wanted && filmScene_ && (*filmScene_)->time == *wanted;
  if (const Status done = film_->step(there ? (*filmScene_)->scene : nullptr); !done)
    endFilm(done.error().message);
}

/// [s] for a picture while it plays: its share of the time until the next one.
double ViewerApp::playingBudget() const {
  constexpr double kShare = 0.6, kMin = 0.012;
  return std::clamp(kShare * timeline_.snapshotSeconds(), kMin, kQuickPicture);
}

PictureRequest ViewerApp::request(const ViewerInput& input) const {
  const bool changes = loading_.busy || !pending_.empty() || film_;
  return {.camera = camera_,
          .width = input.pixelsAcross(),
          .height = input.pixelsDown(),
          .quality = static_cast<Quality>(settings_.look.quality),
          .renderer = static_cast<ViewRenderer>(settings_.look.renderer),
          .surfaces = settings_.look.surfaces,
          .moving = moving_,
          .budget = timeline_.playing() ? playingBudget() : kQuickPicture,
          .exactAfter = changes ? std::numeric_limits<double>::infinity() : kRest};
}

DisplayLook ViewerApp::displayLook() const {
  DisplayLook look;
  look.exposure = exposure_.value * std::exp2(settings_.look.stops);
  look.tone = !document_             ? ToneCurve::kNone
              : !document_->measured ? ToneCurve::kFilmic
              : document_->burns     ? ToneCurve::kShoulder
                                     : ToneCurve::kNone;
  look.background = document_ ? document_->background : Rgb(Rgb::Zero());
  if (document_ && document_->grey && settings_.look.colors > 0)
    look.map = settings_.look.colors == 1 ? ColorMap::kViridis : ColorMap::kInferno;
  return look;
}

Rgb ViewerApp::backgroundShown() const {
  const DisplayLook look = displayLook();
  const Rgb light = look.exposure * look.background;
  const Rgb toned = toneMapped(look.tone, light);
  return toned.unaryExpr([](double v) { return srgbEncode(std::clamp(v, 0.0, 1.0)); });
}

Status ViewerApp::drawPicture(const ViewerInput& input) {
  const Stopwatch watch(costs_.picture);
  loader_.setOpenGl(picture_.mayUseGl(request(input).renderer));
  const Status drawn = picture_.update(request(input));
  if (!drawn) {
    error_ = pictureError_ = drawn.error().message;
    scene_.reset();
  }
  // At once, and better once the picture is fine.
  const bool fine =
      !exposure_.found && scene_ && !scene_->coarse && picture_.settled(request(input));
  const bool first = !exposure_.tried && picture_.shown() && !picture_.stale();
  if (!exposure_.found && document_ && scene_ && (first || fine)) {
    exposure_.value =
        document_->measured
            ? 1
            : suggestExposure({picture_.sampledLight(document_->background)}, ToneCurve::kFilmic);
    exposure_.tried = true;
    exposure_.found = fine;
  }
  return {};
}

void ViewerApp::usePanels(const ViewerInput& input) {
  const Stopwatch watch(costs_.panels);
  if (std::exchange(fontScale_, input.scale) != input.scale) {
    useFont(fontScale_);
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }
  feed(input);
  controls_.clear();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  moving_ = timeline_.playing();
  keys(input);
  control(input);
  timeline_.advance(input.seconds);
  drawPanels(*this, input);
  ImGui::Render();
  goOnWithFilm();
  const bool plays = timeline_.playing();
  const double wanted = timeline_.snapshotTime();
  if (document_ && !opening_ && std::abs(wanted - requested_) > kHeldTime) {
    requested_ = wanted;
    loader_.request(requested_, plays ? timeline_.ahead(kAhead) : std::vector<double>());
  } else if (plays && !played_) {
    loader_.prepare(timeline_.ahead(kAhead));
  }
  played_ = plays;
}

void ViewerApp::show(const DisplayLook& look, bool panels) {
  const Stopwatch watch(costs_.shown);
  if (!picture_.shown() && opening_)
    picture_.prepareShow();
  const auto [width, height] = size();
  glViewport(0, 0, width, height);
  glClearColor(0.05F, 0.05F, 0.06F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (picture_.shown())
    picture_.show(look, width, height);
  if (panels)
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

Status ViewerApp::frame(const ViewerInput& input) {
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  seen_ = input;
  lively_ = std::max(lively_ - 1, 0);
  costs_ = {};
  if (!input.dropped.empty())
    leaveFor(input.dropped);
  if (input.closes)
    leaveFor("");
  if (const auto chosen = files_.takeChosen())
    leaveFor(*chosen);
  takeLoaded(input);
  notes_.update(seenWork(), message_);
  usePanels(input);
  VOLUTE_TRY(drawPicture(input));
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
  unseen_ += input.seconds;
  drew_ = !std::exchange(steps_, false) || picture_.version() != shownVersion_ || unseen_ > kUnseen;
  if (!drew_)
    return {};
  unseen_ = 0;
  shownVersion_ = picture_.version();
  shownLook_ = displayLook();
  show(shownLook_);
  return {};
}

/// Else the last frame may stay: what it took is better spent on pictures. While it plays, a frame
/// that only asks for the next picture need not be drawn either.
bool ViewerApp::due(const ViewerInput& input) {
  Timeline then = timeline_;
  then.advance(input.seconds);
  const bool acts = !input.pressed.empty() || !input.typed.empty() || !input.dropped.empty() ||
                    !input.held.empty() || input.closes || input.wheel != 0 ||
                    input.mouseX != seen_.mouseX || input.mouseY != seen_.mouseY ||
                    input.pixelsAcross() != seen_.pixelsAcross() ||
                    input.pixelsDown() != seen_.pixelsDown() || input.scale != seen_.scale ||
                    std::ranges::count(input.buttons, true) > 0 ||
                    !std::ranges::equal(input.buttons, seen_.buttons);
  if (acts || film_ || picture_.refining() || leaving_)
    lively_ = kLively;
  const bool writes = ImGui::GetIO().WantTextInput && input.seconds > 0.25;  // the cursor blinks
  const bool shows = lively_ > 0 || writes || picture_.hasNews() || input.seconds > 0.5;
  const bool steps =
      loader_.changes() != loaderChanges_ || then.snapshotTime() != timeline_.snapshotTime();
  steps_ = !shows && steps && timeline_.playing();
  return shows || steps;
}

double ViewerApp::patience() const {
  constexpr double kMoves = 1.0 / 60, kWaits = 1.0 / 30, kRests = 0.25;
  if (moving_ || film_ || picture_.refining())
    return kMoves;
  return settled() ? kRests : kWaits;
}

bool ViewerApp::settled() const {
  const PictureRequest requested = request(seen_);
  return idle() && !film_ && picture_.settled(requested) && picture_.exact(requested) &&
         (document_ || !error_.empty()) && (scene_ || !error_.empty());
}

}  // namespace volute
