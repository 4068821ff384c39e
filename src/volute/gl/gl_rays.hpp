// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"

namespace volute {

/// Textures of a ray for each pixel, as ray.glsl reads them; 0: none.
struct GlRays {
  GLuint opaque = 0;   ///< R32F: where each ends [m]; none: nowhere
  GLuint lens = 0;     ///< RGBA32F: directions, and 0 where there is no ray; none: the camera's
  GLuint origins = 0;  ///< RGBA32F, with `lens`: from the eye [m]; none: the camera's
};

/// The step from one row of pixels to the next, at distance 1 or (orthographic) in the world [m];
/// skew turns it.
Vec3 rowStep(const Camera& camera);

/// Sets the uniforms of ray.glsl.
void bindRays(const GlProgram& program, const Camera& camera, const GlRays& rays);

/// The directions of a camera's rays.
GlTexture lensDirections(const Camera& camera);

/// Runs the program in groups of 8 x 8 for each pixel, and makes what it wrote visible.
void runOver(const GlProgram& program, int width, int height);

}  // namespace volute
