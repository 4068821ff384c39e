// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "volute/gl/gl_device.hpp"
#include "volute/viewer/viewer_app.hpp"

namespace volute {

/// The viewer without a display: its frames go to a framebuffer of their own, those that nobody
/// looks at into one of a single pixel. To fill a window takes longer than all else where the CPU
/// fills it.
class HeadlessViewer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<HeadlessViewer>> create(
      OpenDocument open, const ViewerOptions& options = {});

  ViewerApp& app() { return *app_; }

  [[nodiscard]] Status frame(const ViewerInput& input);

  /// Frames of this input until all is loaded and drawn; kCancelled when `progress` says so,
  /// kInvalidArgument while the timeline plays: then nothing ever comes to rest.
  [[nodiscard]] Status settle(ViewerInput input, Progress& progress);

  /// Whether the last frame drew anything.
  bool drew() const { return drew_; }

  /// What the last frame showed.
  Image picture();

  /// The same without panels, as F12 writes it.
  Image screenshot();

  /// Every frame is drawn into all pixels, as a window's is: what it takes is measured.
  void drawWholeFrames() { whole_ = true; }

 private:
  explicit HeadlessViewer(HeadlessGl gl) : gl_(std::move(gl)) {}

  struct Target {
    Target() = default;
    Target(int wide, int high);

    int width = 0, height = 0;
    GlTexture colors;
    GlFramebuffer framebuffer;
  };

  void resize(int width, int height);

  HeadlessGl gl_;  // first, so that it ends last
  Target frame_, pixel_;
  bool whole_ = false, drawn_ = false, drew_ = false;
  std::pair<int, int> size_{1, 1};  ///< of the last frame [pixels]
  std::unique_ptr<ViewerApp> app_;
};

/// What `volute view --screenshot` does: the viewer's frame once all is loaded, as a picture.
[[nodiscard]] Result<Image> viewerScreenshot(OpenDocument open, const ViewerStart& start,
                                             bool panels, Progress& progress);

}  // namespace volute
