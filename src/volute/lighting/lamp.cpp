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

double Lamp::coneShare(const Vec3& point) const {
  const Vec3 away = point - position;
  const double distance = away.norm();
  if (kind == Kind::kSun || !(distance > 0) || coneCosine <= -1)  // all around has no rim
    return 1;
  const double cosine = away.dot(direction) / distance;
  if (cosine < coneCosine)
    return 0;
  if (!(edge > 0))
    return 1;
  const double rim = std::acos(coneCosine), angle = std::acos(std::min(cosine, 1.0));
  return smoothStep((rim - angle) / (edge * rim));
}

Rgb Lamp::irradiance(const Vec3& point) const {
  if (kind == Kind::kSun)
    return intensity;
  const double reach = std::max((point - position).norm(), radius);
  return coneShare(point) / (reach * reach) * intensity;
}

Segment Lamp::towards(const Vec3& point) const {
  if (kind == Kind::kSun)
    return {point, -direction, 0, std::numeric_limits<double>::infinity()};
  const Vec3 way = position - point;
  const double distance = way.norm();
  if (!(distance > 0))
    return {point, Vec3::UnitX(), 0, 0};
  return {point, way / distance, 0, distance};
}

void Lamp::addTo(ContentHash& hash) const {
  const bool sun = kind == Kind::kSun;
  hash.add(sun ? 1.0 : 0.0);
  hash.add(std::span<const double>(sun ? direction.data() : position.data(), 3));
}

}  // namespace volute
