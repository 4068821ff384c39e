// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/sight_slopes.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

SlopedField::SlopedField(const VolumeGeometry& geometry, std::span<const float> values)
    : cell_(geometry.voxelSize()),
      origin_(geometry.bounds.min - 0.5 * cell_),
      step_(0.5 * cell_.minCoeff()) {
  const auto& n = geometry.resolution;
  for (int a = 0; a < 3; ++a) count_[a] = n[a] + 2;
  values_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2], 0);
  std::size_t i = 0;
  for (int z = 0; z < n[2]; ++z) {
    for (int y = 0; y < n[1]; ++y) {
      float* to = &values_[(static_cast<std::size_t>(z + 1) * count_[1] + y + 1) * count_[0] + 1];
      for (int x = 0; x < n[0]; ++x) to[x] = values[i++];
    }
  }
}

SightSlope SlopedField::along(const Segment& sight) const {
  SightSlope slope;
  const Vec3 last(count_[0] - 1, count_[1] - 1, count_[2] - 1);
  const Box3 box{origin_, origin_ + last.cwiseProduct(cell_)};
  const Interval inside =
      box.intersect(sight.origin, sight.direction).intersect({sight.begin, sight.end});
  if (inside.empty())
    return slope;
  const auto steps = static_cast<int>(std::ceil((inside.end - inside.begin) / step_));
  const double length = (inside.end - inside.begin) / steps;
  const Vec3 inverse = cell_.cwiseInverse();
  const std::ptrdiff_t up = count_[0];
  const std::ptrdiff_t in = up * count_[1];
  for (int k = 0; k < steps; ++k) {
    const double t = inside.begin + (k + 0.5) * length;
    const Vec3 place = (sight.at(t) - origin_).cwiseProduct(inverse);
    std::array<int, 3> low{};
    Vec3 share;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::clamp(static_cast<int>(place[a]), 0, count_[a] - 2);
      share[a] = place[a] - low[a];
    }
    const float* v = &values_[static_cast<std::size_t>(low[2] * in + low[1] * up + low[0])];
    const double all =
        v[0] + v[1] + v[up] + v[up + 1] + v[in] + v[in + 1] + v[in + up] + v[in + up + 1];
    if (all == 0)
      continue;
    const auto mix = [](double a, double b, double s) { return a + s * (b - a); };
    const double a00 = mix(v[0], v[1], share[0]), a10 = mix(v[up], v[up + 1], share[0]),
                 a01 = mix(v[in], v[in + 1], share[0]),
                 a11 = mix(v[in + up], v[in + up + 1], share[0]);
    const double b0 = mix(a00, a10, share[1]), b1 = mix(a01, a11, share[1]);
    slope.integral += mix(b0, b1, share[2]);
    const Vec3 gradient(
        mix(mix(v[1] - v[0], v[up + 1] - v[up], share[1]),
            mix(v[in + 1] - v[in], v[in + up + 1] - v[in + up], share[1]), share[2]),
        mix(a10 - a00, a11 - a01, share[2]), b1 - b0);
    slope.alongOrigin += gradient;
    slope.alongDirection += t * gradient;
  }
  slope.integral *= length;
  slope.alongOrigin = length * slope.alongOrigin.cwiseProduct(inverse);
  slope.alongDirection = length * slope.alongDirection.cwiseProduct(inverse);
  return slope;
}

}  // namespace volute
