// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// Where the voxels of OpenVDB's grids are.
#include <openvdb/openvdb.h>

#include <optional>
#include <string>

#include "volute/grid/resample.hpp"
#include "volute/io/lattice.hpp"

namespace volute {

bool isFrustum(const openvdb::GridBase& grid);

/// Fills voxelSize and origin, and the matrix where voxels do not lie along the axes.
Status readTransform(const openvdb::GridBase& grid, const std::string& where, LatticeFrame& frame);

IndexBox toIndexBox(const openvdb::CoordBBox& box);

/// From the indices of a lattice to those of a grid with a frustum.
class FrustumLattices final : public LatticeMap {
 public:
  FrustumLattices(const openvdb::math::Transform& transform, const GridMatrix& indexToWorld)
      : transform_(transform),
        linear_(linearOf(indexToWorld)),
        offset_(offsetOf(indexToWorld)),
        back_(linear_.inverse()) {}

  Vec3 toOld(const Vec3& index) const override {
    const Vec3 world = linear_ * index + offset_;
    const auto at = transform_.worldToIndex(openvdb::Vec3d(world.x(), world.y(), world.z()));
    return {at.x(), at.y(), at.z()};
  }

  Vec3 toNew(const Vec3& index) const override {
    const auto at = transform_.indexToWorld(openvdb::Vec3d(index.x(), index.y(), index.z()));
    return back_ * (Vec3(at.x(), at.y(), at.z()) - offset_);
  }

  /// Around a box of the grid's voxels.
  IndexBox around(const openvdb::CoordBBox& box) const {
    IndexBox all;
    if (box.empty())
      return all;
    Box3 bounds;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 at;
      for (int axis = 0; axis < 3; ++axis)
        at[axis] = corner >> axis & 1 ? box.max()[axis] + 1 : box.min()[axis] - 1;
      bounds.extend(toNew(at));
    }
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kFarthest = 1e9;
      const auto a = static_cast<std::size_t>(axis);
      all.begin[a] = std::llround(std::clamp(std::floor(bounds.min[axis]), -kFarthest, kFarthest));
      all.end[a] = std::llround(std::clamp(std::ceil(bounds.max[axis]), -kFarthest, kFarthest)) + 1;
    }
    return all;
  }

 private:
  const openvdb::math::Transform& transform_;
  Mat3 linear_;
  Vec3 offset_;
  Mat3 back_;
};

/// As readTransform(), of a grid with a frustum that is sampled; cubes as small as its voxels in
/// the middle where the lattice is not said.
Status readSampledPlace(const openvdb::GridBase& grid, const openvdb::GridBase& topology,
                        const FrustumSampling& how, const std::string& where, LatticeFrame& frame);

/// The box of active voxels as the writer noted it. Believed when it can hold the noted number of
/// voxels; whatever lies outside it is found when the values are read.
std::optional<IndexBox> notedBox(const openvdb::GridBase& grid);

}  // namespace volute
