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

}  // namespace volute
