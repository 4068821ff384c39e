// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/math/box.hpp"

namespace volute {

Interval Box3::intersect(const Vec3& origin, const Vec3& direction) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Interval interval{-kInfinity, kInfinity};
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin[axis] < min[axis] || origin[axis] > max[axis])
        return {0, 0};
      continue;
    }
    const double a = (min[axis] - origin[axis]) / direction[axis];
    const double b = (max[axis] - origin[axis]) / direction[axis];
    interval = interval.intersect({std::min(a, b), std::max(a, b)});
  }
  return interval.empty() ? Interval{} : interval;
}

}  // namespace volute
