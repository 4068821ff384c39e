// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volute {

double angleBetween(const Camera& a, const Camera& b, const Vec3& centre) {
  auto sight = [&](const Camera& camera) -> Vec3 {
    return camera.isOrthographic() ? camera.forward() : (centre - camera.eye()).normalized();
  };
  const double cosine = std::min(std::abs(sight(a).dot(sight(b))), 1.0);
  return std::acos(cosine) * 180 / std::numbers::pi;
}

}  // namespace volute
