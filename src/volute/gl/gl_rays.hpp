// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/base/progress.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// Textures of a ray for each pixel, as ray.glsl reads them; 0: none.
struct GlRays {
  GLuint opaque = 0;  ///< R32F: where each ends [m]; none: nowhere
  GLuint lens = 0;    ///< RGBA32F: directions, and 0 where there is no ray; none: the camera's
  GLuint rest = 0;    ///< RGBA32F: of a camera's lens, GlLens::rest
  GLuint origins =
      0;  ///< RGBA32F, with `lens`: where rays begin, from `from` [m]; none: the camera's
  Vec3 from = Vec3::Zero();
};

/// Directions of a camera's rays, in two floats each.
struct GlLens {
  GlTexture directions;  ///< RGBA32F; the fourth channel is 0 where there is no ray
  GlTexture rest;        ///< RGBA32F: what is left beyond float
};

/// What places are relative to in a picture of these things: among the points of their bounds that
/// are nearest to the eye the one that is least far from all of them, in sizes of each; the eye
/// where it is inside.
Vec3 pictureOrigin(const Camera& camera, std::span<const Box3> bounds);

/// The step from one row of pixels to the next, at distance 1 or (orthographic) in the world [m];
/// skew turns it.
Vec3 rowStep(const Camera& camera);

/// Sets the uniforms of ray.glsl. @param origin  of the picture
void bindRays(const GlProgram& program, const Camera& camera, const Vec3& origin,
              const GlRays& rays);

GlLens lensDirections(const Camera& camera);

/// Runs the program in groups of 8 x 8 for each pixel, and makes what it wrote visible.
void runOver(const GlProgram& program, int width, int height);

/// The same for a program with ray.glsl, so many rows after so many: kCancelled between them.
[[nodiscard]] Status runInBands(const GlProgram& program, const Camera& camera, int rowsAtOnce,
                                Progress& progress);

}  // namespace volute
