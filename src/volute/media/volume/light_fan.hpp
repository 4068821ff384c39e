// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/lighting/lamp.hpp"

namespace volute {

/// How much of lamps' light arrives at the voxel centres of a volume over the trilinear basis.
///
/// Not one ray for each centre: rays go from the lamp through all of the volume, no farther apart
/// than voxels, and know their optical depth on each plane of centres that they cross. It is exact
/// there, and between rays of one plane it is interpolated by cubics. A volume of n^3 voxels takes
/// some n^2 rays instead of n^3.
class LightFan {
 public:
  /// @param slice  must outlive it; channel 0 is the extinction
  /// @param points  voxel centres, up to one voxel outside of the volume
  LightFan(const BrickSlice& slice, std::span<const Vec3> points);

  /// Of the light of a lamp at each point, 0..1.
  void transmittances(const Lamp& lamp, std::span<float> out) const;

 private:
  using Place = std::array<std::int32_t, 3>;

  /// Points by the plane in which they are.
  struct Planes {
    int first = 0;
    std::vector<std::vector<std::int32_t>> points;
  };

  /// Those of `which`, or of all, across an axis.
  Planes planesOf(std::size_t axis, std::span<const std::int32_t> which) const;
  void fromSun(const Vec3& towards, std::span<float> out) const;
  void fromPoint(const Vec3& lamp, std::span<float> out) const;
  /// The points of one of the six pyramids around a lamp.
  void inPyramid(const Vec3& lamp, std::size_t axis, int sign, std::span<const std::int32_t> which,
                 std::span<float> out) const;

  const BrickSlice& slice_;
  Vec3 voxel_;
  std::array<int, 3> size_;
  std::vector<Place> places_;
};

}  // namespace volute
