// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// TetSplat's twin: optical depths of smoke without sorting, tet by tet, summed by blending into
/// 32-bit floats. Nothing is computed for an eye but on the device. Needs the same current context
/// all its life.
class DepthSplat {
 public:
  /// kTooLarge where the device's buffers cannot hold the mesh.
  [[nodiscard]] static Result<DepthSplat> create(std::shared_ptr<const TetMesh> mesh);

  /// [1/m], one for each vertex.
  void setExtinction(std::span<const float> extinction);

  /// Whether this was set last.
  bool holds(std::span<const float> extinction) const {
    return std::ranges::equal(extinction_, extinction);
  }

  /// Adds the depths to the fourth channel of an RGBA32F texture of the camera's size, up to the
  /// distances along the rays [m] in the texture `opaque`, R32F, where it is not 0. kUnsupported
  /// for cameras with a lens.
  [[nodiscard]] Status add(const Camera& camera, GLuint opaque, GLuint picture);

 private:
  DepthSplat(std::shared_ptr<const TetMesh> mesh, GlProgram program);

  std::shared_ptr<const TetMesh> mesh_;
  GlProgram program_;
  Vec3 middle_ = Vec3::Zero();
  float negligible_ = 0;
  float grazing_ = 0;  ///< [m]
  std::vector<float> extinction_;
  GlBuffer places_, tets_, planes_, tetFaces_, extinctions_;
  GlFramebuffer framebuffer_;
  GlVertexArray arrays_;
};

}  // namespace volute
