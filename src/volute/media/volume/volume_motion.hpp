// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/grid/volume_info.hpp"

namespace volute {

/// How each voxel's place at an instant between two frames was reached: where in the frame before
/// it what is there came from, and where in the one after it it goes [voxels].
struct VoxelPaths {
  std::vector<std::array<float, 3>> from, to;  ///< (z, y, x), to be added to a voxel's place
};

/// The paths along a velocity that is known in both frames: straight ones, found by iterating
///   from = -share step v_before(x + from),  to = (1 - share) step v_after(x + to),
/// with v interpolated between voxels and 0 outside.
/// @param before, after  velocities, shape (z, y, x, 3)
/// @param step  [voxels] along each axis, between the frames, of a velocity of 1
/// @param share  of the time between the frames that has gone by, 0..1
VoxelPaths pathsBetween(const VolumeInfo& info, std::span<const float> before,
                        std::span<const float> after, const Vec3& step, double share);

/// What is between two frames, shape (z, y, x, c): (1 - share) of the one before and share of the
/// one after it, each along the paths, or in place where there are none.
void blendFrames(const VolumeInfo& info, std::span<const float> before,
                 std::span<const float> after, double share, const VoxelPaths* paths,
                 std::span<float> out);

}  // namespace volute
