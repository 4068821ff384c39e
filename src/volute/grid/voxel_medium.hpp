// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

struct MarchGrid;
class CubicVoxels;

/// Work done by VoxelMedium::radiance so far, summed over all calls.
struct MarchCounts {
  std::uint64_t voxels =
      0;  ///< faces between voxels (cells, when trilinear) crossed inside stored bricks
  std::uint64_t bricksVisited = 0;  ///< stored bricks entered, once per ray
  std::uint64_t bricksSkipped = 0;  ///< empty bricks skipped, once per ray
};

/// One frame of a volume as a medium:
///   emission   = emissionScale * value of each channel [radiance/m]; one channel is grey
///   extinction = extinctionScale * mean of the channels [1/m]
/// with values that are constant in each voxel (box), or interpolated between voxel centres and
/// falling to zero one voxel beyond the outer ones (trilinear; its bounds are then half a voxel
/// larger than the slice's), or that are coefficients of B-splines (cubic; see CubicVoxels).
///
/// Values should not be negative where they absorb; small negative values from lossy compression
/// are harmless. Cheap to copy: its data are shared and const.
class VoxelMedium {
 public:
  VoxelMedium(std::shared_ptr<const BrickSlice> slice, double emissionScale,
              double extinctionScale);

  /// The same of bricks that another medium marches through, too: one channel, trilinear.
  VoxelMedium(const std::shared_ptr<const MarchGrid>& march, double emissionScale,
              double extinctionScale);

  Box3 bounds() const { return cells_.bounds(); }

  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;

  /// Exact, in double.
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;

  /// One piece for each voxel (box) or for each cell between eight centres (trilinear, cubic) that
  /// is not all zero.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// The fast path, in float and SIMD. Closed forms throughout, except for absorbing RGB in the
  /// trilinear basis: there 4-point Gauss rules over steps with an optical depth of at most 1.5,
  /// whose error is below 1e-6 of the brightest channel. Rounding adds about 1e-6 of the brightest
  /// pixel. The result of a ray depends only on that ray, not on its neighbours in the batch or on
  /// the SIMD target. A ray ends where its transmittance falls below 1e-6.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// The voxel values, shape (z, y, x, c).
  std::vector<double> coefficients() const;

  /// The same volume with other values, rounded to float.
  VoxelMedium withCoefficients(std::span<const double> coefficients) const;

  const BrickSlice& slice() const { return *slice_; }

  MarchCounts counts() const;

 private:
  struct Counters;

  bool trilinear() const { return slice_->basis() == Basis::kTrilinear; }

  double weightedValue(const Vec3& point, int channel) const;

  std::shared_ptr<const BrickSlice> slice_;
  double emissionScale_;
  double extinctionScale_;
  CellGrid cells_;                            // voxels, or the cells between their centres
  CellRange occupied_;                        // the cells of all bricks that are stored
  std::shared_ptr<const MarchGrid> march_;    // null: cubic
  std::shared_ptr<const CubicVoxels> cubic_;  // null: another basis
  std::shared_ptr<Counters> counters_;
};

}  // namespace volute
