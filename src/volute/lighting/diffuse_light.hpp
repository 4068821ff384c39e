// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// What a medium does with light that comes from outside of it.
struct Scattering {
  Rgb albedo = Rgb::Ones();  ///< share of the extinguished light that is scattered
  double asymmetry = 0;      ///< g of the phase function, -1 < g < 1; 0.6 to 0.9 for droplets

  /// The share of what is scattered that goes on as if it had not been: g^2, of a forward peak.
  double forward() const;

  /// What went on so on the way to a place which a lamp's light reaches with this share: its next
  /// scattering has the mean cosine g^2.
  double goesOn(double share) const;
};

/// Light in a medium that was scattered at least once, by flux-limited diffusion on at most 32^3
/// cells: an approximation that is good where a medium is thick, and in the mean over a picture.
/// Lamps' light is followed through the cells along rays, and what it loses there is what diffuses:
/// no light is lost. What is farther than the box neither gets nor sends diffused light.
///
/// With the delta-Eddington phase function: of what is scattered, the share g^2 goes on with the
/// lamp's light, the rest has the mean cosine g / (1 + g). The flux is
///   F = -D (grad phi - 3 Q1),   D = ((3 K (1 - albedo g))^2 + (2 |grad phi| / phi)^2)^(-1/2)
/// which is Larsen's limiter, so that light streams out of what is thin.
class DiffuseLight {
 public:
  struct Request {
    AnyMedium medium;  ///< that scatters
    Box3 box;          ///< around it; finite
    Scattering scattering{};
    std::span<const Lamp> lamps;
    std::span<const AnyMedium> between{};  ///< others, which scatter alike
    Blocks blocks{};                       ///< surfaces, which are black to it; may be empty
    double density = 1;                    ///< the medium is so many times as thick
  };

  explicit DiffuseLight(const Request& request);

  /// What is scattered again from a point, divided by extinction and albedo: the mean over all
  /// ways.
  Rgb at(const Vec3& point) const;

  /// The same in a direction of unit length.
  Rgb towards(const Vec3& point, const Vec3& direction) const;

  /// What at() and towards() are trilinear between, for a shader (gl/glsl/light_again.glsl).
  struct Cells {
    Vec3 low = Vec3::Zero(), perMetre = Vec3::Ones();
    std::array<int, 3> count{};   ///< along each axis; 0: there is no such light
    std::vector<float> values{};  ///< of a cell for each channel: radiance, its change on x, y, z
  };

  Cells cells() const;

 private:
  class Solver;

  /// Radiance, and its change along each axis.
  using Cell = std::array<std::array<float, 4>, 3>;

  Cell between(const Vec3& point) const;

  Vec3 low_ = Vec3::Zero(), perMetre_ = Vec3::Ones();
  std::array<int, 3> cells_{1, 1, 1};
  std::vector<Cell> light_;
};

}  // namespace volute
