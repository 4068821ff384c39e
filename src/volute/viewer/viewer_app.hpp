// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"
#include "volute/viewer/display.hpp"
#include "volute/viewer/loader.hpp"
#include "volute/viewer/timeline.hpp"
#include "volute/viewer/view_camera.hpp"
#include "volute/viewer/viewer_input.hpp"

namespace volute {

/// How finely the picture is drawn.
enum class Quality { kAuto, kFull, kHalf, kQuarter };

/// What the panels show and change.
struct ViewerSettings {
  double stops = 0;  ///< exposure = automatic exposure * 2^stops
  int map = 0;       ///< 0 grey, 1 viridis, 2 inferno
  Quality quality = Quality::kAuto;
  bool panels = true;
  bool help = false;
};

/// What the last frames took.
struct FrameTimes {
  double milliseconds = 0;       ///< the last picture, on the device
  int width = 0, height = 0;     ///< that it had [pixels]
  std::vector<float> history{};  ///< the last pictures [ms]
};

/// The viewer without its window: given what a person did, draws a frame into the framebuffer that
/// is bound. Needs a current context of OpenGL 4.5; one at a time in a program (Dear ImGui's).
class ViewerApp {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ViewerApp>> create(OpenDocument open);
  ~ViewerApp();

  void open(const std::string& path, double time = 0);

  /// One frame. Errors of documents are shown, not returned; what is returned ends the viewer.
  [[nodiscard]] Status frame(const ViewerInput& input);

  /// Whether all is loaded and the picture is drawn as finely as it will be.
  bool settled() const;

  /// The framebuffer that is bound, as a linear picture whose bytes in a .png are those shown.
  static Image shownPicture(int width, int height);

  /// True once after a person asked for a screenshot.
  bool takeScreenshotWish() { return std::exchange(screenshotWish_, false); }

  void say(std::string message) { message_ = std::move(message); }

  ViewerSettings& settings() { return settings_; }

  Timeline& timeline() { return timeline_; }

  ViewCamera& camera() { return camera_; }

  const DocumentInfo* document() const { return document_ ? &*document_ : nullptr; }

  const std::string& error() const { return error_; }

  const FrameTimes& times() const { return times_; }

  const GlDevice& device() const { return device_; }

  const LoaderState& loading() const { return loading_; }

  const std::string& message() const { return message_; }

  void resetView(int width, int height);

 private:
  ViewerApp(OpenDocument open, GlDevice device, GlRenderer renderer, Display display);

  void takeLoaded(const ViewerInput& input);
  void control(const ViewerInput& input);
  void keys(const ViewerInput& input);
  Status drawPicture(const ViewerInput& input);
  double wantedScale(const ViewerInput& input) const;
  void findExposure();

  GlDevice device_;
  GlRenderer renderer_;
  Display display_;
  Loader loader_;
  LoaderState loading_;
  Timeline timeline_;
  ViewCamera camera_;
  ViewerSettings settings_;
  FrameTimes times_;
  std::optional<DocumentInfo> document_;
  std::optional<LoadedScene> scene_;
  std::string error_, message_;
  double requested_ = 0;  ///< the time that the loader was asked for
  double exposure_ = 1;   ///< that fits the first picture
  bool exposureFound_ = false;
  bool viewSet_ = false;
  bool changed_ = true;    ///< the picture is not that of the scene and the camera any more
  bool moving_ = false;    ///< a person is turning it, or it plays
  ViewCamera drawnFrom_;   ///< the camera of the picture that is shown
  double drawnScale_ = 0;  ///< of the picture that is shown; 0: none
  int drawnWidth_ = 0, drawnHeight_ = 0;
  double secondsAPixel_ = 2e-8;  ///< what pictures have cost
  double lastX_ = 0, lastY_ = 0;
  bool dragging_ = false;
  bool screenshotWish_ = false;
};

/// The panels of one frame, between ImGui's NewFrame and Render.
void drawPanels(ViewerApp& app, const ViewerInput& input);

}  // namespace volute
