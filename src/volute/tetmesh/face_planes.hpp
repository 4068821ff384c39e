// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// The plane of a face: normal . x = offset, the normal of length 1, away from the face's first
/// tet.
struct FacePlane {
  Vec3 normal;
  double offset = 0;
};

/// All faces of a mesh as planes.
struct FacePlanes {
  explicit FacePlanes(const TetMesh& mesh);

  std::vector<FacePlane> planes;  ///< of each face
  /// Of each tet, across from each of its vertices: 2 * plane, + 1 where the tet is its second.
  std::vector<std::array<std::int32_t, 4>> sides;
};

/// A way of looking: from an eye, or along a direction.
struct ViewOrigin {
  Vec3 eye = Vec3::Zero(), forward = Vec3::UnitX();
  bool orthographic = false;

  bool operator==(const ViewOrigin&) const = default;
};

/// All tets from front to back: each after those before it whose faces it shares. Where a mesh is
/// not convex, and where tets lie around each other in a circle, no such order need be right for
/// all rays: the nearest are first. Staubli et al. 2005, section 4.1, by buckets of distance.
std::vector<std::int32_t> visibilityOrder(const TetMesh& mesh, const FacePlanes& faces,
                                          const ViewOrigin& view);

}  // namespace volute
