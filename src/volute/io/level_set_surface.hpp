// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// The surface on which distances are 0, interpolated trilinearly between voxel centres. Rays meet
/// it where the cubic that the distance is along them in a cell of eight voxels is 0; its normals
/// are interpolated from central differences at the voxels. Cells that reach out of the leaves,
/// where a narrow band has no surface, are passed over.
class LevelSetSurface final : public CurvedSurface {
 public:
  /// @param distances  one channel, negative inside; sorted
  /// @param info  where its voxels are
  /// @param place  from the space of info's bounds to the world; nothing: that is the world
  /// kTooLarge where flat pieces of it need more than `maxMemory` bytes.
  [[nodiscard]] static Result<std::shared_ptr<const LevelSetSurface>> make(
      Bricks distances, const VolumeInfo& info, const std::optional<GridMatrix>& place,
      std::uint64_t maxMemory);

  std::optional<double> nearest(const Segment& segment) const override;
  Vec3 outward(const Segment& segment, double distance) const override;

  double roughness() const override { return roughness_; }

  const Box3& bounds() const override { return bounds_; }

  /// One corner in each cell, on the surface, and two triangles around each edge that the surface
  /// crosses, so that they leave no gap. Where several sheets go through a cell they meet there.
  void addTriangles(std::uint32_t material, std::vector<Triangle>& to) const override;
  std::shared_ptr<const CurvedSurface> moved(const Mat4& transform) const override;

 private:
  struct Field;

  LevelSetSurface(std::shared_ptr<const Field> field, const Mat3& linear, const Vec3& offset);

  Segment amongVoxels(const Segment& segment) const;

  std::shared_ptr<const Field> field_;
  Mat3 linear_;  ///< from places among voxels, 0 at the centre of the first, to the world
  Vec3 offset_;
  Mat3 inverse_;
  Box3 bounds_;
  double roughness_ = 0;
};

}  // namespace volute
