// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_places.hpp"
#include "volute/lighting/lamp.hpp"

namespace volute {

/// How much of lamps' light arrives at the voxel centres of a volume over the trilinear basis.
///
/// Not one ray for each centre: rays go from the lamp through all of the volume, no farther apart
/// than voxels, and know their optical depth on each plane of centres that they cross. It is exact
/// there, and between rays of one plane it is interpolated by cubics. A volume of n^3 voxels takes
/// some n^2 rays instead of n^3; of a sun's rays, work is done where bricks are.
class LightFan {
 public:
  /// @param slice  must outlive it; channel 0 is the extinction
  /// @param places  voxels, of the volume or around it, whose centres are the points; must outlive
  /// it
  LightFan(const BrickSlice& slice, const VoxelPlaces& places);

  /// Of the light of a lamp at each point, 0..1. False where one ray for each point costs less, or
  /// the basis is another: nothing is done then.
  /// @param beyond  of a sun: the same of one that shines from the other side; may be empty
  bool transmittances(const Lamp& lamp, std::span<float> out, std::span<float> beyond = {}) const;

 private:
  using Place = std::array<std::int32_t, 3>;

  /// Voxels on an axis.
  struct Span {
    int least = 0, most = 0;

    void add(int at) { least = std::min(least, at), most = std::max(most, at); }
  };

  /// Points by the plane in which they are.
  struct Planes {
    int first = 0;
    std::vector<std::uint32_t> begin;  ///< of each plane
    std::vector<std::int32_t> points;

    std::span<const std::int32_t> at(int plane) const {
      if (plane < first || plane - first + 1 >= static_cast<int>(begin.size()))
        return {};
      const std::uint32_t* from = &begin[static_cast<std::size_t>(plane - first)];
      return std::span(points).subspan(from[0], from[1] - from[0]);
    }
  };

  /// Entries of the slice by layers across an axis: even rows of bricks, and odd ones.
  struct Rows {
    using Layer = std::array<std::vector<std::span<const std::uint32_t>>, 2>;
    std::vector<std::uint32_t> entries;
    std::vector<Layer> layers;

    const Layer& at(int layer) const {
      static const Layer kNone;
      return layer < 0 || layer >= static_cast<int>(layers.size())
                 ? kNone
                 : layers[static_cast<std::size_t>(layer)];
    }
  };

  struct SunRays;

  /// All points, or those that which(i) is, across an axis.
  Planes planesOf(std::size_t axis) const;
  template <class Which>
  Planes planesOf(std::size_t axis, std::size_t count, Which&& which) const;
  Rows rowsOf(std::size_t axis) const;
  void fromSun(const SunRays& rays, std::span<float> out, std::span<float> beyond) const;
  void fromPoint(const Vec3& lamp, std::span<float> out) const;
  /// The points of one of the six pyramids around a lamp.
  void inPyramid(const Vec3& lamp, std::size_t axis, int sign, std::span<const std::int32_t> which,
                 std::span<float> out) const;

  const BrickSlice& slice_;
  Vec3 voxel_;
  std::array<int, 3> size_;
  std::array<Span, 3> bricks_, reach_;  ///< of bricks; of points, and the volume with its border
  VoxelPlaces places_;
};

}  // namespace volute
