// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {

namespace {

/// From 0 to 1 and level at both ends.
double smoothStep(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

double Lamp::coneShareTowards(const Vec3& away) const {
  const double cosine = away.dot(direction);
  if (cosine < coneCosine)
    return 0;
  if (!(edge > 0))
    return 1;
  const double rim = std::acos(coneCosine), angle = std::acos(std::min(cosine, 1.0));
  return smoothStep((rim - angle) / (edge * rim));
}

void Lamp::addTo(ContentHash& hash) const {
  const bool sun = kind == Kind::kSun;
  hash.add(sun ? 1.0 : 0.0);
  hash.add(std::span<const double>(sun ? direction.data() : position.data(), 3));
}

}  // namespace volute
