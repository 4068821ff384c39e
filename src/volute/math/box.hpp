// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <limits>

#include "volute/math/vec.hpp"

namespace volute {

/// A closed range of a ray's parameter; empty when end <= begin.
struct Interval {
  double begin = 0;
  double end = 0;

  bool empty() const { return !(begin < end); }

  double length() const { return empty() ? 0 : end - begin; }

  Interval intersect(const Interval& other) const {
    return {std::max(begin, other.begin), std::min(end, other.end)};
  }
};

/// An axis-aligned box between two corners; bounds of a volume are its outer voxel faces [m].
struct Box3 {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return !(min.array() < max.array()).all(); }

  Vec3 size() const { return max - min; }

  Vec3 centre() const { return 0.5 * (min + max); }

  void extend(const Vec3& point) { min = min.cwiseMin(point), max = max.cwiseMax(point); }

  /// @param box  not empty but for being flat
  void extend(const Box3& box) { extend(box.min), extend(box.max); }

  /// @param index  0 to 7: bit 0 is set on the side of the largest x, bit 1 of y, bit 2 of z
  Vec3 corner(int index) const {
    return {(index & 1 ? max : min).x(), (index & 2 ? max : min).y(), (index & 4 ? max : min).z()};
  }

  bool contains(const Vec3& point) const {
    return (point.array() >= min.array()).all() && (point.array() <= max.array()).all();
  }

  /// The parameters s for which origin + s * direction lies inside; empty when it misses. A
  /// direction component of zero counts as inside its slab when the origin is (faces included).
  Interval intersect(const Vec3& origin, const Vec3& direction) const;
};

}  // namespace volute
