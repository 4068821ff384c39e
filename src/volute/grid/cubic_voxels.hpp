// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"

namespace volute {

struct CubicGrid;

/// One snapshot of a volume whose values are the coefficients of B-splines of degree 3 at voxel
/// centres, a tensor product of three:
///   of 1 or 3 channels: emission and extinction as VoxelMedium has them
///   of 4 channels:      extinction = K [1/m], emission = J [radiance/m], in channels K, J red, J
///                       green, J blue
/// A sum of splines stays within the range of its coefficients, and along a ray it is of degree 9
/// in each cell between eight centres. What VoxelMedium and ShadedVoxels are over Basis::kCubic; a
/// FastMedium. Cheap to copy: what it holds is shared and const.
class CubicVoxels {
 public:
  /// @param slice  over Basis::kCubic
  CubicVoxels(std::shared_ptr<const BrickSlice> slice, double emissionScale,
              double extinctionScale);

  Box3 bounds() const { return cells_.bounds(); }

  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;

  /// Exact, in double.
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;

  /// One piece for each cell that is not all zero, of degree 9.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// In float, four coefficients at a time. Five Gauss points in each cell, which are exact for the
  /// optical depth; in steps of an optical depth of at most 1.2 where emission is no multiple of
  /// extinction. Within 1e-5 of the brightest of the pieces' light. A ray that has lost all but
  /// 1e-6 of its light ends there.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  MarchCounts counts() const;

 private:
  double valueAt(const Vec3& point, int channel) const;

  std::shared_ptr<const CubicGrid> grid_;
  CellGrid cells_;
};

}  // namespace volute
