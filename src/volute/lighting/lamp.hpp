// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <span>

#include "volute/base/content_hash.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// What lights smoke and walls: a spot lamp, or the sun.
struct Lamp {
  enum class Kind { kSpot, kSun };

  Kind kind = Kind::kSpot;
  Vec3 position = Vec3::Zero();     ///< of a spot [m]
  Vec3 direction = -Vec3::UnitZ();  ///< the way its light travels, along the cone's axis; unit
  double coneCosine = -1;           ///< of a spot: no light at a larger angle from its axis
  /// Of a spot: the share of the cone's half angle, from its rim inwards, on which the light grows
  /// smoothly from nothing to all, 0..1.
  double edge = 0;
  Rgb intensity = Rgb::Constant(1);  ///< spot: power per solid angle; sun: what arrives, per area
  /// A spot's light is nowhere stronger than at this distance [m]; lamps have a size.
  double radius = 0.05;

  /// What arrives at a point, per area that faces the lamp, if nothing is in the way.
  Rgb irradiance(const Vec3& point) const { return irradiance(towards(point)); }

  /// The same where `way`, which is towards() a point, begins.
  Rgb irradiance(const Segment& way) const {
    if (kind == Kind::kSun)
      return intensity;
    const double reach = std::max(way.end, radius);
    return coneShare(way) / (reach * reach) * intensity;
  }

  /// 0..1: how far a point is inside a spot's cone, as its edge has it.
  double coneShare(const Vec3& point) const { return coneShare(towards(point)); }

  /// The same where `way` towards the lamp begins.
  double coneShare(const Segment& way) const {
    const bool hasRim = kind != Kind::kSun && coneCosine > -1 && way.end > 0;
    return hasRim ? coneShareTowards(-way.direction) : 1;
  }

  /// From a point to the lamp; endless towards the sun. Empty at the lamp itself.
  Segment towards(const Vec3& point) const {
    if (kind == Kind::kSun)
      return {point, -direction, 0, std::numeric_limits<double>::infinity()};
    const Vec3 way = position - point;
    const double distance = way.norm();
    if (!(distance > 0))
      return {point, Vec3::UnitX(), 0, 0};
    return {point, way / distance, 0, distance};
  }

  /// Adds all that decides which ways its light takes: its colour, power and cone do not.
  void addTo(ContentHash& hash) const;

 private:
  double coneShareTowards(const Vec3& away) const;
};

/// 1 for each segment that something opaque interrupts, else 0.
using Blocks = std::function<void(std::span<const Segment>, std::span<std::uint8_t>)>;

}  // namespace volute
