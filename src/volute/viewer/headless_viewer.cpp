// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/headless_viewer.hpp"

#include <chrono>
#include <thread>

#include "volute/viewer/shown_picture.hpp"

namespace volute {

Result<std::unique_ptr<HeadlessViewer>> HeadlessViewer::create(OpenDocument open,
                                                               const ViewerOptions& options) {
  VOLUTE_ASSIGN(auto gl, HeadlessGl::create());
  std::unique_ptr<HeadlessViewer> viewer(new HeadlessViewer(std::move(gl)));
  VOLUTE_ASSIGN(viewer->app_, ViewerApp::create(std::move(open), options));
  return viewer;
}

HeadlessViewer::Target::Target(int wide, int high)
    : width(wide), height(high), colors(makeTexture2d(GL_RGBA8, wide, high)) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  framebuffer = GlFramebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors.name(), 0);
}

void HeadlessViewer::resize(int width, int height) {
  if (width != frame_.width || height != frame_.height)
    frame_ = Target(width, height);
}

Status HeadlessViewer::frame(const ViewerInput& input) {
  size_ = {input.pixelsAcross(), input.pixelsDown()};
  if (whole_)
    resize(input.pixelsAcross(), input.pixelsDown());
  else if (!pixel_.colors.name())
    pixel_ = Target(1, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, (whole_ ? frame_ : pixel_).framebuffer.name());
  VOLUTE_ASSIGN(drew_, app_->frame(input));
  if (drew_)
    drawn_ = whole_;
  if (app_->window().takeReportRequest())
    app_->report().begin(screenshot());
  glFinish();  // as a window's swap does: else what is deleted stays until the queue is full
  return {};
}

Status HeadlessViewer::settle(ViewerInput input, Progress& progress) {
  constexpr int kMoreFrames = 4;  // panels find their sizes in the frames after they first appear
  for (int more = kMoreFrames; more > 0;) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped while loading");
    VOLUTE_TRY(frame(input));
    if (app_->playback().timeline().playing())
      return fail(
          ErrorCode::kInvalidArgument,
          "nothing comes to rest while time passes; stop it first (timeline().play(false))");
    input.pressed.clear();
    input.typed.clear();
    input.dropped.clear();
    input.closes = false;
    if (app_->settled()) {
      --more;
      continue;
    }
    const LoaderState& loading = app_->document().loading();
    if (app_->document().idle())
      progress.report("drawing", 0, 0);
    else if (!loading.stage.empty())
      progress.report(loading.stage, std::max(loading.share, 0.0), loading.share < 0 ? 0 : 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return {};
}

Image HeadlessViewer::picture() {
  const auto [width, height] = size_;
  resize(width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.framebuffer.name());
  if (!drawn_)
    app_->showAgain();
  drawn_ = true;
  return shownPicture(width, height);
}

Image HeadlessViewer::screenshot() {
  const auto [width, height] = size_;
  resize(width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.framebuffer.name());
  app_->showAgain(false);
  drawn_ = false;
  return shownPicture(width, height);
}

Result<Image> viewerScreenshot(OpenDocument open, const ViewerStart& start, bool panels,
                               Progress& progress) {
  VOLUTE_ASSIGN(const auto viewer, HeadlessViewer::create(std::move(open), start.options));
  ViewerApp& app = viewer->app();
  app.settings().panels = panels;
  app.open(start.path, start.time, start.other);
  ViewerInput input;
  input.scale = start.options.scale;
  input.width = static_cast<int>(start.width / input.scale);
  input.height = static_cast<int>(start.height / input.scale);
  input.columns = start.width, input.rows = start.height;
  VOLUTE_TRY(viewer->settle(input, progress));
  if (app.document().failure())
    return tl::unexpected(*app.document().failure());
  if (app.comparison().active() && !app.comparison().error().empty())
    return fail(ErrorCode::kInvalidData, "compared with: {}", app.comparison().error());
  return viewer->picture();
}

}  // namespace volute
