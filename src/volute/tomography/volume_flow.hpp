// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// Displacements of voxels, one vector for each axis, shape (z, y, x), x fastest.
struct VoxelFlow {
  std::array<int, 3> size{};                  ///< voxels on x, y, z
  std::array<std::vector<float>, 3> along{};  ///< [voxels] on x, y, z
};

struct FlowOptions {
  double smoothness = 0.05;  ///< of squared second differences of displacements, where a
                             ///< displacement one voxel off costs up to 1
  double divergence = 0;     ///< what a change of size costs, times smoothness
  int warps = 4;             ///< linearisations at each level
};

/// The motion between two volumes, half-way in time between them: u such that
/// before(x - u/2) = after(x + u/2). Where nothing shows motion it continues what is around it as
/// smoothly as it can. Horn and Schunck 1981 in three dimensions, symmetric in time, with the
/// constraint normalised by the gradient (Zimmer, Bruhn and Weickert 2011), second differences of
/// the displacements instead of first ones, so that turning costs nothing, and coarse to fine with
/// warping. The same result for any number of threads; exchanging the volumes gives -u.
/// @param before, after  one value a voxel, finite, 0 where there is nothing; 0 outside.
/// Errors: kInvalidArgument for options or sizes that make no sense, kCancelled.
[[nodiscard]] Result<VoxelFlow> flowBetween(std::span<const float> before,
                                            std::span<const float> after,
                                            const std::array<int, 3>& size,
                                            const FlowOptions& options, Progress& progress);

/// The mean of the channels, shape (z, y, x), of a volume of shape (z, y, x, 3).
std::vector<float> greyVolume(std::span<const float> colour);

/// Where the medium of a frame is one frame later if its motion goes on: values(x - u), u read half
/// a displacement before x, where `flow` was at the middle of the last interval.
/// @param values  shape (z, y, x, channels).
std::vector<float> carriedOn(std::span<const float> values, int channels, const VoxelFlow& flow);

/// The displacements at a frame, from those at the middles of the intervals before and after it:
/// those along the way of what is at the voxel, interpolated to its time; one alone where the other
/// is missing.
/// @param before, after  of one interval each; not both null.
/// @param ratio  how many times as long the interval after the frame is.
/// @return for the length of the interval after the frame, or of the last.
VoxelFlow flowAtFrame(const VoxelFlow* before, const VoxelFlow* after, double ratio);

}  // namespace volute
