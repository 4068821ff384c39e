// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// How each voxel's place at a time between two frames was reached: where in the frame before
/// it what is there came from, and where in the one after it it goes [voxels].
struct VoxelPaths {
  using Step = std::array<float, 3>;

  std::vector<BrickPlace> places;  ///< bricks in which something moves
  BrickTable table;                ///< their numbers
  std::vector<Step> from, to;      ///< 512 a brick, to be added to a voxel's place
};

/// Velocities in a frame: one slice of three channels, or three of one; null: 0 everywhere.
using Velocities = std::vector<std::shared_ptr<const BrickSlice>>;

/// An affine map of places among voxels; 0 is the centre of the first.
struct VoxelMap {
  Mat3 linear = Mat3::Identity();
  Vec3 offset = Vec3::Zero();

  bool isIdentity() const { return linear == Mat3::Identity() && offset == Vec3::Zero(); }

  VoxelMap inverse() const {
    const Mat3 back = linear.inverse();
    return {back, -(back * offset)};
  }
};

/// A time between two frames, whose grids may lie elsewhere in the world than the
/// grid at that time.
struct BetweenFrames {
  double share = 0;            ///< of the time between the frames that has gone by, 0..1
  VoxelMap before{}, after{};  ///< from a voxel at that time to the same place in either frame
};

/// The paths along a velocity that is known in both frames: straight ones, found by iterating
///   from = -share before v_before(x + from),  to = (1 - share) after v_after(x + to),
/// with v interpolated between voxels and 0 outside, and x where it is in either frame. The first
/// v is the faster of both frames' there, and where neither has one that of what comes by.
/// @param early, late  [voxels] from a velocity in either frame to its way between the frames
VoxelPaths pathsBetween(const VolumeInfo& info, const Velocities& before, const Velocities& after,
                        const Mat3& early, const Mat3& late, const BetweenFrames& between);

/// What is between two frames: (1 - share) of the one before and share of the one after it, each
/// along the paths, or, where there are none, at the same place in the world.
BrickSlice blendFrames(const VolumeInfo& info, const BrickSlice& before, const BrickSlice& after,
                       const BetweenFrames& between, const VoxelPaths* paths);

/// How badly two frames fit together where each of their voxels goes along its own velocity to the
/// other frame, which should have the same there: the root mean square of what differs, relative to
/// that of the values; 0: they fit, 0 too where both are empty. Some bricks stand for all where
/// there are many.
/// @param early, late  as pathsBetween(); zero: nothing moves
double misfit(const BrickSlice& before, const BrickSlice& after, const Velocities& vBefore,
              const Velocities& vAfter, const Mat3& early, const Mat3& late,
              const BetweenFrames& between);

/// All places of bricks of some slices, in the order of isBefore(); null ones have none.
std::vector<BrickPlace> placesOf(std::span<const std::shared_ptr<const BrickSlice>> slices);

}  // namespace volute
