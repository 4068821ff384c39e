// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/texel.hpp"

namespace volute {

/// Opaque triangles on the device, in a tree of boxes, as triangles.glsl reads them.
struct GlTriangles {
  /// Which triangles stop a ray: all, or those whose front or whose back it comes to.
  enum class Sides { kBoth = 0, kFront = 1, kBack = -1 };

  Vec3 middle = Vec3::Zero();  ///< of their bounds [m]
  Box3 bounds{};               ///< [m]
  double reach = 0;            ///< [m] from the middle to the farthest corner
  GlBuffer nodes, corners;
  GlBuffer normals;     ///< three a triangle, w the surface's roughness; 0 of flat ones
  bool smooth = false;  ///< there are such normals

  /// kTooLarge where they do not fit into one of the device's buffers.
  [[nodiscard]] static Result<GlTriangles> make(std::span<const Triangle> triangles);
  /// All triangles of a scene.
  [[nodiscard]] static Result<GlTriangles> make(const TriangleScene& scene);

  /// For rays whose places are relative to `origin`.
  void bind(const GlProgram& program, const Vec3& origin, Sides sides = Sides::kBoth) const;

 private:
  [[nodiscard]] static Result<GlTriangles> make(std::span<const Triangle> triangles,
                                                std::span<const Texel> normals);
};

}  // namespace volute
