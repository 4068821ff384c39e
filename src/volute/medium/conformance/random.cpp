// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance/random.hpp"

namespace volute::conformance {

Vec3 Random::pointIn(const Box3& box) {
  Vec3 point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = uniform(box.min[axis], box.max[axis]);
  return point;
}

Vec3 Random::direction() {
  Vec3 v;
  do {
    for (int axis = 0; axis < 3; ++axis) v[axis] = uniform(-1, 1);
  } while (v.squaredNorm() > 1 || v.squaredNorm() < 0.01);
  return v.normalized();
}

std::vector<double> Random::numbers(std::size_t count, double from, double to) {
  std::vector<double> values(count);
  for (double& value : values) value = uniform(from, to);
  return values;
}

}  // namespace volute::conformance
