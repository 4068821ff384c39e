// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// LampPaths::shares() of a mesh of which each rank holds some pieces: for each vertex of this
/// rank's own. Ranks look along each other's ways to the lamp, some vertices at a time. Collective.
/// @param bounds  of all pieces
[[nodiscard]] Result<std::vector<float>> sharedLampShares(Team& team, const TetLocator& own,
                                                          std::span<const float> extinction,
                                                          const Lamp& lamp, const Box3& bounds);

}  // namespace volute
