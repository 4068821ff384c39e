// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_app.hpp"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr double kQuick = 0.04;        ///< [s] that a picture may take while something moves
constexpr double kCoarsest = 1.0 / 8;  ///< of the window's pixels a side
constexpr std::size_t kHistory = 90;
constexpr double kHeldTime = 1e-9;

/// Hands the input to Dear ImGui.
void feed(const ViewerInput& input) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(input.width), static_cast<float>(input.height)};
  io.DeltaTime = static_cast<float>(std::max(input.seconds, 1e-4));
  io.MousePos = {static_cast<float>(input.mouseX), static_cast<float>(input.mouseY)};
  for (int i = 0; i < 3; ++i) io.MouseDown[i] = input.buttons[i];
  io.MouseWheel = static_cast<float>(input.wheel);
  io.KeyShift = input.shift;
}

double scaleOf(Quality quality) {
  switch (quality) {
    case Quality::kHalf:
      return 0.5;
    case Quality::kQuarter:
      return 0.25;
    default:
      return 1;
  }
}

}  // namespace

ViewerApp::ViewerApp(OpenDocument open, GlDevice device, GlRenderer renderer, Display display)
    : device_(std::move(device)),
      renderer_(std::move(renderer)),
      display_(std::move(display)),
      loader_(std::move(open)) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::StyleColorsDark();
  ImGui_ImplOpenGL3_Init("#version 450");
}

ViewerApp::~ViewerApp() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

Result<std::unique_ptr<ViewerApp>> ViewerApp::create(OpenDocument open) {
  VOLUTE_ASSIGN(auto device, currentGlDevice());
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  VOLUTE_ASSIGN(auto display, Display::create());
  return std::unique_ptr<ViewerApp>(
      new ViewerApp(std::move(open), std::move(device), std::move(renderer), std::move(display)));
}

void ViewerApp::open(const std::string& path, double time) {
  viewSet_ = exposureFound_ = false;
  timeline_.setTimes({time});
  requested_ = time;
  loader_.open(path, time);
}

void ViewerApp::resetView(int width, int height) {
  if (!document_)
    return;
  if (document_->startView)
    camera_.set(*document_->startView);
  else
    camera_.frame(document_->bounds, width, height);
  changed_ = true;
}

void ViewerApp::takeLoaded(const ViewerInput& input) {
  loader_.watch();
  loading_ = loader_.state();
  error_ = loading_.error;
  if (auto opened = loader_.takeDocument()) {
    document_ = std::move(*opened);
    const double time = timeline_.time();
    timeline_.setTimes(document_->times);
    timeline_.seek(std::max(time, requested_));
    if (!viewSet_)
      resetView(input.width, input.height);
    viewSet_ = true;
  }
  if (auto loaded = loader_.takeScene()) {
    scene_ = std::move(*loaded);
    changed_ = true;
  }
}

void ViewerApp::keys(const ViewerInput& input) {
  for (const Key key : input.pressed) {
    switch (key) {
      case Key::kSpace:
        timeline_.play(!timeline_.playing());
        break;
      case Key::kLeft:
        timeline_.step(-1);
        break;
      case Key::kRight:
        timeline_.step(1);
        break;
      case Key::kHome:
        timeline_.seek(timeline_.first());
        break;
      case Key::kEnd:
        timeline_.seek(timeline_.last());
        break;
      case Key::kPlus:
        settings_.stops += 0.5;
        break;
      case Key::kMinus:
        settings_.stops -= 0.5;
        break;
      case Key::kF1:
        settings_.help = !settings_.help;
        break;
      case Key::kF12:
        screenshotWish_ = true;
        break;
      case Key::kH:
        settings_.panels = !settings_.panels;
        break;
      case Key::kF:
        resetView(input.width, input.height);
        break;
      case Key::kEscape:
        settings_.help = false;
        break;
      case Key::kM:
        camera_.setMode(camera_.mode() == ViewCamera::Mode::kOrbit ? ViewCamera::Mode::kWalk
                                                                   : ViewCamera::Mode::kOrbit);
        break;
      default:
        break;
    }
  }
}

/// The camera follows the mouse where no panel does, and the keys when it walks.
void ViewerApp::control(const ViewerInput& input) {
  const double dx = input.mouseX - lastX_, dy = input.mouseY - lastY_;
  lastX_ = input.mouseX, lastY_ = input.mouseY;
  const bool held = input.buttons[0] || input.buttons[1] || input.buttons[2];
  const bool ours = !ImGui::GetIO().WantCaptureMouse;
  if (held && dragging_ && (dx != 0 || dy != 0)) {
    if (input.buttons[0] && !input.shift)
      camera_.drag(dx, dy);
    else
      camera_.pan(dx, dy, input.height);
    changed_ = moving_ = true;
  }
  dragging_ = held && (dragging_ || ours);
  if (input.wheel != 0 && ours) {
    camera_.zoom(input.wheel);
    changed_ = moving_ = true;
  }
  if (camera_.mode() != ViewCamera::Mode::kWalk)
    return;
  const auto axis = [&](Key forth, Key back) {
    return double(input.held.count(forth)) - double(input.held.count(back));
  };
  const double pace = input.seconds * (input.shift ? 1.0 : 0.25) * camera_.distance();
  const double ahead = axis(Key::kW, Key::kS), aside = axis(Key::kD, Key::kA),
               up = axis(Key::kE, Key::kQ);
  if (ahead != 0 || aside != 0 || up != 0) {
    camera_.walk(pace * ahead, pace * aside, pace * up);
    changed_ = moving_ = true;
  }
}

/// While something moves, as fine as is quick; then as fine as it gets.
double ViewerApp::wantedScale(const ViewerInput& input) const {
  const double finest = scaleOf(settings_.quality);
  if (!moving_ || settings_.quality == Quality::kFull)
    return finest;
  const double pixels = static_cast<double>(input.width) * input.height;
  return std::clamp(std::sqrt(kQuick / (secondsAPixel_ * pixels)), kCoarsest, finest);
}

Status ViewerApp::drawPicture(const ViewerInput& input) {
  const double scale = wantedScale(input);
  const bool resized = input.width != drawnWidth_ || input.height != drawnHeight_;
  const bool turned = !(camera_ == drawnFrom_);
  if (!scene_ || (!changed_ && !turned && !resized && drawnScale_ == scale))
    return {};
  const int width = std::max(8, static_cast<int>(std::lround(scale * input.width)));
  const int height = std::max(8, static_cast<int>(std::lround(scale * input.height)));
  Progress quiet;
  const Status drawn =
      renderer_.draw(camera_.camera(width, height), scene_->scene, GlQuantity::kLight, quiet);
  changed_ = false;
  drawnFrom_ = camera_;
  drawnScale_ = scale;
  drawnWidth_ = input.width, drawnHeight_ = input.height;
  if (!drawn) {
    error_ = drawn.error().message;
    scene_.reset();
    return {};
  }
  for (const GlPassTime& pass : renderer_.takePasses()) {
    if (pass.name != "march")
      continue;
    times_.milliseconds = pass.milliseconds;
    secondsAPixel_ = 1e-3 * pass.milliseconds / (static_cast<double>(width) * height);
  }
  times_.width = width, times_.height = height;
  times_.history.push_back(static_cast<float>(times_.milliseconds));
  if (times_.history.size() > kHistory)
    times_.history.erase(times_.history.begin());
  if (!exposureFound_ && !scene_->coarse)
    findExposure();
  return {};
}

void ViewerApp::findExposure() {
  GLint width = 0, height = 0;
  glGetTextureLevelParameteriv(renderer_.texture(), 0, GL_TEXTURE_WIDTH, &width);
  glGetTextureLevelParameteriv(renderer_.texture(), 0, GL_TEXTURE_HEIGHT, &height);
  std::vector<float> texels(4 * static_cast<std::size_t>(width) * height);
  glGetTextureImage(renderer_.texture(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
  Image image(width, height);
  const Rgb background = document_ ? document_->background : Rgb(Rgb::Zero());
  for (std::size_t i = 0; i < texels.size() / 4; ++i) {
    for (int c = 0; c < 3; ++c)
      image.pixels[3 * i + c] =
          static_cast<float>(texels[4 * i + c] + std::exp(-texels[4 * i + 3]) * background[c]);
  }
  exposure_ = suggestExposure(image);
  exposureFound_ = true;
}

Status ViewerApp::frame(const ViewerInput& input) {
  if (!input.dropped.empty())
    open(input.dropped);
  takeLoaded(input);
  feed(input);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  moving_ = timeline_.playing();
  keys(input);
  control(input);
  timeline_.advance(input.seconds);
  drawPanels(*this, input);
  ImGui::Render();
  if (document_ && std::abs(timeline_.time() - requested_) > kHeldTime) {
    requested_ = timeline_.time();
    loader_.request(requested_);
  }
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  VOLUTE_TRY(drawPicture(input));
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
  glViewport(0, 0, input.width, input.height);
  glClearColor(0.05F, 0.05F, 0.06F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (scene_ && drawnScale_ > 0) {
    DisplayLook look;
    look.exposure = exposure_ * std::exp2(settings_.stops);
    look.background = document_ ? document_->background : Rgb(Rgb::Zero());
    if (document_ && document_->grey && settings_.map > 0)
      look.map = settings_.map == 1 ? ColorMap::kViridis : ColorMap::kInferno;
    display_.draw(renderer_.texture(), look, input.width, input.height);
  }
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  return {};
}

bool ViewerApp::settled() const {
  const bool shown = !scene_ || (!changed_ && camera_ == drawnFrom_ && !scene_->coarse &&
                                 drawnScale_ == scaleOf(settings_.quality));
  return loader_.idle() && !loading_.busy && !moving_ && shown && (document_ || !error_.empty()) &&
         (scene_ || !error_.empty());
}

Image ViewerApp::shownPicture(int width, int height) {
  std::vector<std::uint8_t> bytes(3 * static_cast<std::size_t>(width) * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = &bytes[3 * static_cast<std::size_t>(height - 1 - y) * width];
    for (int i = 0; i < 3 * width; ++i) {
      image.pixels[3 * static_cast<std::size_t>(y) * width + i] =
          static_cast<float>(srgbDecode(row[i] / 255.0));
    }
  }
  return image;
}

}  // namespace volute
