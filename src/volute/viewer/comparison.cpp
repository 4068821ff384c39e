// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/comparison.hpp"

#include <cmath>

namespace volute {

Status Comparison::begin(const std::string& path, const PictureMakers& makers) {
  VOLUTE_ASSIGN(auto picture, ViewPicture::create(makers));
  other_.reset(new Other{{open_, {}}, std::move(picture)});
  path_ = path;
  other_->document.open(path, std::nullopt);
  return {};
}

void Comparison::end() {
  other_.reset();
}

void Comparison::update(const PictureRequest& request, double time) {
  ViewerDocument& document = other_->document;
  ViewPicture& picture = other_->picture;
  if (const auto news = document.take()) {
    if (news->scene && document.scene()->scene.get() != picture.scene())
      document.loader().discard(picture.setScene(document.scene()->scene));
  }
  if (!document.info())
    return;
  if (!document.opening() && std::exchange(other_->requested, time) != time)
    document.loader().request(time);
  document.loader().setOpenGl(picture.mayUseGl(request.renderer));
  if (const Status drawn = picture.update(request); !drawn)
    document.refuseScene(drawn.error());
}

bool Comparison::settled(const PictureRequest& request) const {
  const ViewerDocument& document = other_->document;
  return document.idle() &&
         (!document.error().empty() ||
          (document.scene() && other_->picture.settled(request) && other_->picture.exact(request)));
}

void Comparison::addTo(DisplayLook& look) const {
  if (mode != Mode::kDifference || !other_ || !other_->picture.shown())
    return;
  look.other = other_->picture.shownLight();
  look.other.span = span;
  look.map = ColorMap::kViridis;
}

void Comparison::show(const DisplayLook& look, int width, int height) {
  if (mode != Mode::kWiper || !other_ || !other_->picture.shown())
    return;
  if (width != width_ || height != height_) {
    width_ = width, height_ = height;
    colors_ = makeTexture2d(GL_RGBA8, width, height);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    frame_ = GlFramebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors_.name(), 0);
  }
  GLint target = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.name());
  other_->picture.show(look, width, height);
  const int begin = static_cast<int>(std::lround(border * width));
  glBlitNamedFramebuffer(frame_.name(), static_cast<GLuint>(target), begin, 0, width, height, begin,
                         0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
}

}  // namespace volute
