// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// A camera for OpenGL's rasteriser: its pixels' centres are the camera's rays. Row 0 of the target
/// is the picture's top.
struct RasterView {
  Mat3 toView = Mat3::Identity();   ///< right, down and forward in rows
  Mat3 toImage = Mat3::Identity();  ///< from there to pixels, homogeneous where it is a pinhole
  double width = 1, height = 1;     ///< [pixels]
  bool orthographic = false;
  double nearest = 1;   ///< [m]; a pinhole's depths are nearest / w
  double farthest = 1;  ///< [m]; an orthographic camera's are 1/2 - z / (4 farthest)
  /// The ray of image point (0, 0), and one pixel further: its direction, one metre along the view,
  /// or (orthographic) its origin from the eye [m].
  Vec3 rayCorner = Vec3::Zero(), rayRight = Vec3::Zero(), rayDown = Vec3::Zero();

  /// kUnsupported for cameras with a lens, whose straight lines are bent.
  [[nodiscard]] static Result<RasterView> of(const Camera& camera, const Box3& bounds);

  void bind(const GlProgram& program) const;
};

/// While it lives, drawing goes to a framebuffer, unclipped in depth, nearer where greater; then
/// OpenGL's state is as it was at first.
class RasterScope {
 public:
  RasterScope(const GlFramebuffer& framebuffer, int width, int height);
  ~RasterScope();
  RasterScope(const RasterScope&) = delete;
  RasterScope& operator=(const RasterScope&) = delete;

 private:
  GLint framebuffer_ = 0, viewport_[4] = {};
  GLint origin_ = 0, depthMode_ = 0, depthFunc_ = 0;
  GLboolean blend_ = GL_FALSE, depthTest_ = GL_FALSE, cull_ = GL_FALSE, scissor_ = GL_FALSE;
};

}  // namespace volute
