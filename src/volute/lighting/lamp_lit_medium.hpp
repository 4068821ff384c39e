// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// What a medium does with the light of lamps, and what is in the light's way.
struct LampScattering {
  Rgb albedo = Rgb::Ones();  ///< share of the extinguished light that is scattered
  double asymmetry = 0;      ///< g of Henyey and Greenstein's phase function, -1 < g < 1
  std::span<const AnyMedium> between{};  ///< media that take from the light besides itself
  Blocks blocks{};                       ///< opaque things that do; may be empty
};

/// Any medium that scatters the light of lamps once, besides what it sends anyway:
///   emission = that of the medium + K albedo sum over lamps of E exp(-t) V phase
/// with K its extinction, E a lamp's irradiance, t the optical depth and V the sight from the lamp.
/// t and V are found once, along 512 ways from each lamp and at 32 distances that grow, and
/// interpolated: shadows in the medium have soft edges of some 11 degrees.
///
/// A Medium and FastMedium. emission() at a point, which knows no direction, has the mean of the
/// phase function. Cheap to copy: what it holds is shared and const.
class LampLitMedium {
 public:
  /// @param medium  what is drawn; its own emission stays
  /// @param density  has the same extinction and is cheap to walk: the medium itself, or what it
  /// was made of
  /// @param lamps  spots that shine everywhere; suns are left out, and of more than three the
  /// closest ones are taken together
  LampLitMedium(AnyMedium medium, AnyMedium density, std::span<const Lamp> lamps,
                const LampScattering& scattering);

  Box3 bounds() const { return medium_.bounds(); }

  double extinction(const Vec3& point) const { return medium_.extinction(point); }

  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(segments, depths);
  }

  /// Those of the medium, cut until a parabola through the light at begin, middle and end of each
  /// is within 1e-3 of it halfway between, or they were cut twelve times.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// The medium's own fast path, and the light of each lamp by Gauss points at even angles from it
  /// (Kulla and Fajardo 2012), 8 on each side of the nearest point; from afar all lamps are one.
  /// Within some 2e-2 of what the lamps add to the pieces' light.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

 private:
  struct Light;

  /// What a unit of extinction sends along a direction; null: evenly.
  Rgb source(const Vec3& point, const Vec3* direction) const;
  void cut(const Segment& segment, const Piece& piece, std::vector<Piece>& out) const;
  Rgb scattered(const Segment& segment, std::span<const Piece> density) const;

  AnyMedium medium_, density_;
  Rgb albedo_;
  double asymmetry_;
  std::shared_ptr<const std::vector<Light>> lights_;
  std::shared_ptr<const Light> afar_;  ///< all of them as one
  double spread_ = 0;                  ///< [m], around afar_
};

}  // namespace volute
