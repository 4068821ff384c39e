// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// A mesh of which each rank holds some pieces.
struct SharedMesh {
  Team& team;
  const TetLocator& own;  ///< this rank's pieces
  Box3 bounds;            ///< of all pieces
};

/// LampPaths::shares() at points of this rank's pieces. Ranks look along each other's ways to the
/// lamp, some points at a time. Collective.
/// @param extinction  of this rank's vertices
[[nodiscard]] Result<std::vector<float>> sharedLampShares(const SharedMesh& mesh,
                                                          std::span<const float> extinction,
                                                          const Lamp& lamp,
                                                          std::span<const Vec3> points);

/// Adds to sums at this rank's vertices those of other ranks at the same places. Collective.
[[nodiscard]] Status addAtSharedVertices(const SharedMesh& mesh, std::span<double> sums);

}  // namespace volute
