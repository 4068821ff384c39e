// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Where rays come from: a point, or all places in one direction.
struct TetEye {
  Vec3 point = Vec3::Zero();     ///< [m]; any point of an orthographic camera
  Vec3 forward = Vec3::UnitX();  ///< of an orthographic camera, unit length
  bool orthographic = false;

  static TetEye of(const Camera& camera) {
    const bool orthographic = camera.isOrthographic();
    return {camera.eye(), orthographic ? camera.forward() : Vec3(Vec3::UnitX()), orthographic};
  }

  bool operator==(const TetEye&) const = default;
};

/// The tets of a mesh from the farthest to the nearest.
struct TetOrder {
  std::vector<std::int32_t> tets;
  /// Tets that were taken although one behind them was left: each breaks a cycle of tets, all of
  /// which hide the next one.
  std::int64_t cycles = 0;
  /// Parts of the mesh that share no face. Between them, and across the gaps of a mesh that is not
  /// convex, nothing but the distance of their tets' centroids decides.
  std::int32_t parts = 0;
};

/// Visibility order as Staubli et al. 2005, section 4.1: of two neighbours, the one on the eye's
/// side of their common face hides the other (XMPVO's relations); a topological sort of these
/// relations, in which ties are decided by the centroids' distance, the farther first. The order of
/// any two tets that share a face is right, but for those that break a cycle. It serves as long as
/// the eye stays where it is, whatever it looks at.
TetOrder sortTets(const TetMesh& mesh, const TetEye& eye);

}  // namespace volute
