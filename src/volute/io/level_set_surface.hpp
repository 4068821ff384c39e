// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// Appends the surface on which distances are 0, interpolated trilinearly between voxel centres:
/// flat pieces whose corners lie exactly on it, and which leave no gap. Each cell of eight voxels
/// is cut into six tetrahedra, which find every sheet that crosses an edge of theirs. Cells that
/// reach out of the leaves, where a narrow band has no surface, are passed over.
/// @param distances  one channel, negative inside
/// @param info  where its voxels are
/// @param place  from the space of info's bounds to the world; nothing: that is the world
/// kTooLarge where the triangles need more than `maxMemory` bytes.
[[nodiscard]] Status addLevelSet(const Bricks& distances, const VolumeInfo& info,
                                 const std::optional<GridMatrix>& place, std::uint32_t material,
                                 std::uint64_t maxMemory, std::vector<Triangle>& triangles);

}  // namespace volute
