// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// How fog thins with height: g in K(x, y, z) = rho(x, y) g(z). Heights are in metres above the
/// origin of the map. (The paper fades vertically with the distance from the viewer, so its fog
/// moves with the eye; this one stands still.)
class FogProfile {
 public:
  /// [m] "Without an end" ends here, above and below: far beyond any scene, and every integral is
  /// finite.
  static constexpr double kFarthest = 1e7;

  /// g(z) = (value + slope * (z - reference)) * exp(-decay * (z - reference)) for bottom <= z <
  /// top; at most one of slope and decay is not zero.
  struct Zone {
    double bottom = -kFarthest;
    double top = kFarthest;
    double reference = 0;
    double value = 1;
    double slope = 0;  ///< [1/m]
    double decay = 0;  ///< [1/m]

    double operator()(double z) const;
  };

  struct Knot {
    double height = 0, value = 0;
  };

  struct Layer {
    double bottom = 0, top = 0, share = 1;
  };

  /// Above so many scale heights an exponential profile is cut off: 1e-26 of it is left.
  static constexpr double kScaleHeights = 60;

  /// g = 1 at every height.
  FogProfile() : zones_(1) {}

  /// 1 between two heights, 0 outside.
  [[nodiscard]] static Result<FogProfile> slab(double bottom, double top);

  /// Linear between knots, 0 outside of them. At least two, heights not falling (two at the same
  /// height are a jump), values from 0 to 1.
  [[nodiscard]] static Result<FogProfile> linear(std::span<const Knot> knots);

  /// exp(-(z - bottom) / scaleHeight) above `bottom`, 1 below it, without a lower end.
  [[nodiscard]] static Result<FogProfile> exponential(double bottom, double scaleHeight);

  /// The sum of slabs with a share each; they may overlap.
  [[nodiscard]] static Result<FogProfile> layers(std::span<const Layer> layers);

  double operator()(double z) const;

  /// Bottom to top, without overlap; gaps are zero.
  std::span<const Zone> zones() const { return zones_; }

  /// From the bottom of the lowest zone to the top of the highest.
  Interval heights() const;

  /// The same without what fades away, and of an exponential profile without what is even below it:
  /// .7 % is left where it ends.
  Interval seenHeights() const;

 private:
  explicit FogProfile(std::vector<Zone> zones) : zones_(std::move(zones)) {}

  std::vector<Zone> zones_;
};

}  // namespace volute
