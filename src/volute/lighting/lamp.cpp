// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp.hpp"

#include <limits>

namespace volute {

Rgb Lamp::irradiance(const Vec3& point) const {
  if (kind == Kind::kSun)
    return intensity;
  const Vec3 away = point - position;
  const double distance = away.norm();
  if (distance > 0 && away.dot(direction) < coneCosine * distance)
    return Rgb::Zero();
  const double reach = std::max(distance, radius);
  return intensity / (reach * reach);
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
  hash.add(kind == Kind::kSun ? 1.0 : 0.0);
  hash.add(std::span<const double>(position.data(), 3));
  hash.add(std::span<const double>(direction.data(), 3));
  hash.add(coneCosine);
}

}  // namespace volute
