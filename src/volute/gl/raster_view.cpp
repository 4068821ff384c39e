// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/raster_view.hpp"

namespace volute {

Result<RasterView> RasterView::of(const Camera& camera, const Box3& bounds) {
  if (!camera.distortion().none()) {
    return fail(ErrorCode::kUnsupported,
                "cells are not projected through a lens, whose lines are bent; march them");
  }
  RasterView view;
  view.toView = camera.rotation();
  view.width = camera.width(), view.height = camera.height();
  view.orthographic = camera.isOrthographic();
  const Vec3 size = bounds.size();
  view.nearest = 1e-4 * size.norm();
  view.farthest = 1.01 * (size.norm() + (bounds.centre() - camera.eye()).norm());
  if (view.orthographic) {
    view.toImage = Mat3(1 / camera.pixelWidth(), 0, camera.principalPoint().x(), 0,
                        1 / camera.pixelSize(), camera.principalPoint().y(), 0, 0, 1);
    view.rayCorner = camera.ray(0, 0).origin - camera.eye();
    view.rayRight = camera.right() * camera.pixelWidth();
    view.rayDown = camera.down() * camera.pixelSize();
    return view;
  }
  view.toImage = camera.intrinsics();
  const auto along = [&](double x, double y) {
    const Segment ray = camera.ray(x, y);
    return Vec3(ray.direction / ray.direction.dot(camera.forward()));
  };
  view.rayCorner = along(0, 0);
  view.rayRight = (along(view.width, 0) - view.rayCorner) / view.width;
  view.rayDown = (along(0, view.height) - view.rayCorner) / view.height;
  return view;
}

void RasterView::bind(const GlProgram& program) const {
  program.set("toView", toView);
  program.set("toImage", toImage);
  program.set("halfSize",
              std::array{static_cast<float>(width / 2), static_cast<float>(height / 2)});
  program.set("orthographic", orthographic ? 1 : 0);
  program.set("nearest", static_cast<float>(nearest));
  program.set("farthest", static_cast<float>(farthest));
  program.set("rayCorner", rayCorner);
  program.set("rayRight", rayRight);
  program.set("rayDown", rayDown);
}

RasterScope::RasterScope(const GlFramebuffer& framebuffer, int width, int height) {
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer_);
  glGetIntegerv(GL_VIEWPORT, viewport_);
  glGetIntegerv(GL_CLIP_ORIGIN, &origin_);
  glGetIntegerv(GL_CLIP_DEPTH_MODE, &depthMode_);
  glGetIntegerv(GL_DEPTH_FUNC, &depthFunc_);
  blend_ = glIsEnabled(GL_BLEND), depthTest_ = glIsEnabled(GL_DEPTH_TEST);
  cull_ = glIsEnabled(GL_CULL_FACE), scissor_ = glIsEnabled(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer.name());
  glViewport(0, 0, width, height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
}

RasterScope::~RasterScope() {
  const auto put = [](GLenum what, GLboolean on) { on ? glEnable(what) : glDisable(what); };
  put(GL_BLEND, blend_);
  put(GL_DEPTH_TEST, depthTest_);
  put(GL_CULL_FACE, cull_);
  put(GL_SCISSOR_TEST, scissor_);
  glDisable(GL_DEPTH_CLAMP);
  glDepthMask(GL_TRUE);
  glDepthFunc(static_cast<GLenum>(depthFunc_));
  glClipControl(static_cast<GLenum>(origin_), static_cast<GLenum>(depthMode_));
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
}

}  // namespace volute
