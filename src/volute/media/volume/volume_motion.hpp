// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// How each voxel's place at an instant between two frames was reached: where in the frame before
/// it what is there came from, and where in the one after it it goes [voxels].
struct VoxelPaths {
  using Step = std::array<float, 3>;

  std::vector<BrickPlace> places;  ///< bricks in which something moves
  BrickTable table;                ///< their numbers
  std::vector<Step> from, to;      ///< 512 a brick, to be added to a voxel's place
};

/// Velocities in a frame: one slice of three channels, or three of one; null: 0 everywhere.
using Velocities = std::vector<std::shared_ptr<const BrickSlice>>;

/// The paths along a velocity that is known in both frames: straight ones, found by iterating
///   from = -share step v_before(x + from),  to = (1 - share) step v_after(x + to),
/// with v interpolated between voxels and 0 outside.
/// @param step  [voxels] from a velocity to its way between the frames
/// @param share  of the time between the frames that has gone by, 0..1
VoxelPaths pathsBetween(const VolumeInfo& info, const Velocities& before, const Velocities& after,
                        const Mat3& step, double share);

/// What is between two frames: (1 - share) of the one before and share of the one after it, each
/// along the paths, or in place where there are none.
BrickSlice blendFrames(const VolumeInfo& info, const BrickSlice& before, const BrickSlice& after,
                       double share, const VoxelPaths* paths);

/// All places of bricks of some slices, in the order of isBefore(); null ones have none.
std::vector<BrickPlace> placesOf(std::span<const std::shared_ptr<const BrickSlice>> slices);

}  // namespace volute
