// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/shaded_voxels.hpp"
#include "volute/medium/affine_medium.hpp"

namespace volute {

/// From where a volume is seen.
struct VolumeView {
  bool parallel = false;
  Vec3 at = Vec3::Zero();  ///< the eye, or the way that all rays go
};

/// Light points of a volume that are hidden behind surfaces. Light is interpolated between points,
/// and no surface is: what a picture shows before a wall must not have the light of points in the
/// wall or behind it. So these points take the share of a lamp's light that those before it have.
///
/// What is seen on both sides of a thin surface, past its edge, still shares a cell's light.
class LightAtSurfaces {
 public:
  using Place = std::array<std::int32_t, 3>;

  /// A light point of the volume.
  struct Point {
    std::int32_t number = 0;
    Place place{};
  };

  /// One that is seen, beside a hidden one.
  struct Seen {
    std::int32_t number = 0;
    float weight = 0;
  };

  /// A hidden one, and the nearest of those before the surface. Weights sum to 1.
  struct Hidden {
    Point point;
    std::vector<Seen> seen;
  };

  /// Finds the points that have a surface beside them.
  /// @param place  of the volume, whose points are in a space of its own; surfaces in the world
  LightAtSurfaces(const ShadedVoxels& volume, const AffineMap& place, TriangleScene surfaces);

  /// There are none.
  bool empty() const { return points_.empty(); }

  /// By a ray from the eye to each, and from each that it does not see to those beside.
  std::vector<Hidden> hiddenFrom(const VolumeView& view) const;

 private:
  struct Marks;

  void mark(Marks& cells, const std::array<Vec3, 3>& corners) const;
  std::int32_t numberAt(const Place& place) const;

  TriangleScene surfaces_;
  std::array<int, 3> size_{};  ///< of the volume, in voxels
  int reach_ = 1;  ///< voxels: how far away the points are that a cell takes its light of
  std::vector<Point> points_;
  std::vector<Vec3> positions_;  ///< of these, in the world [m]
  BrickTable bricks_;            ///< of points, from the place before the first
  std::vector<std::array<std::int32_t, BrickSlice::kVoxels>> numbers_;  ///< in points_; -1: none
};

}  // namespace volute
