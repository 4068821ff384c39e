// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "volute/grid/index_box.hpp"
#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// An affine map of points: three rows of four numbers.
using GridMatrix = std::array<double, 12>;

Mat3 linearOf(const GridMatrix& matrix);
Vec3 offsetOf(const GridMatrix& matrix);
GridMatrix gridMatrix(const Mat3& linear, const Vec3& offset);

/// The matrix from index to world of voxels along the axes.
/// @param origin  centre of the voxel with index 0
GridMatrix alongAxes(const std::array<double, 3>& voxelSize, const std::array<double, 3>& origin);

/// A map of indices as voxels along the axes of a space of their own, and how that space lies in
/// the world: it keeps lengths along the grid's axes, and its origin is the world's.
struct GridSpace {
  std::array<double, 3> voxelSize{};
  std::array<double, 3> origin{};
};

GridSpace spaceOf(const GridMatrix& indexToWorld);

/// From such a space to the world, for a grid with these indices.
GridMatrix placeIn(const GridMatrix& indexToWorld, const GridSpace& space);

/// Whether it is finite, and no direction of the grid vanishes in the world.
bool isSound(const GridMatrix& matrix);

/// Around `box` in all places.
Box3 aroundPlaces(const Box3& box, std::span<const GridMatrix> places);

/// Whether points within `box` come to lie together, to a thousandth of a `voxel`.
bool samePlaces(std::span<const GridMatrix> a, std::span<const GridMatrix> b, const Box3& box,
                double voxel);

/// Frames with a placement of each by the source, beyond VolumeInfo::bounds.
class PlacedFrames {
 public:
  virtual ~PlacedFrames() = default;

  /// From the space of VolumeInfo::bounds to the world, in each frame; empty: that is the world.
  virtual const std::vector<GridMatrix>& places() const = 0;

  /// The file of a frame, and the index that the volume's first voxel has there.
  virtual std::pair<std::string, VoxelIndex> fileOf(int frame) const = 0;
};

}  // namespace volute
