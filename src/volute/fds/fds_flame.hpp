// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

#include "volute/fds/fds_field.hpp"

namespace volute {

/// How heat that is released becomes light that is seen.
struct FlameLaw {
  /// [K]: the colour is that of a black body; of a field of temperatures the least that is shown
  /// with the full luminance
  double temperature = 1500;
  /// Luminance [1/m] of what releases 1 MW/m3, or is as hot as FdsFlame::glowing() says, in units
  /// of a white wall's under full light.
  double emission = 20;
  double cutoff = 200;  ///< [kW/m3]: where less is released there is no flame
};

/// A fire as a medium that shines and hides nothing: light in proportion to the heat that is
/// released, with the colour of a black body. Smokeview too draws what exceeds a cutoff, with a
/// colour of its own. It is a picture of where it burns, not photometry: what a flame sends as
/// light depends on its soot, which FDS does not resolve.
///
/// Where FDS stores the flames' temperature instead, light is that of a black body of it, up to a
/// factor: its colour, and its luminance, which says by itself what does not glow (one of 1000 K is
/// thousands of times darker than one of 1500 K).
///
/// Cutoff and law of the black body are applied to the stored values, before anything is
/// interpolated. Cheap to copy.
class FdsFlame {
 public:
  /// A part of the flames as a lamp of one colour.
  struct Light {
    FdsField field;  ///< in place of an extinction; of heat release [kW/m3] above the cutoff
    Rgb colour;      ///< radiance per metre of a unit of it
  };

  /// `heat` holds the heat release [kW/m3] in place of an extinction.
  FdsFlame(const FdsField& heat, const FlameLaw& law);

  /// `celsius` holds temperatures [degrees C] in place of an extinction. A black body of
  /// `brightest` [K] has the luminance law.emission a metre, others the law's share of it.
  static FdsFlame glowing(const FdsField& celsius, const FlameLaw& law, double brightest);

  /// Whether there is a flame anywhere.
  bool burns() const { return burns_; }

  /// Of the cells that burn; without any, of the case.
  Box3 bounds() const { return bounds_; }

  /// How bright it is on a line of sight: the upper quartile of the luminances of lines along the
  /// axes, 32 x 32 a side of bounds(), which meet it; 0: none does. Of `smoke`, times `scale`, each
  /// line has its mean, from end to end.
  double luminance(const FdsField& smoke, double scale) const;

  /// The same where others hold more of the fire and of the smoke.
  /// @param box  bounds() of all
  /// @param addUp  adds what the others have, place by place
  double luminance(const FdsField& smoke, double scale, const Box3& box,
                   const std::function<void(std::span<double>)>& addUp) const;

  /// One of heat release; of temperatures one a channel.
  std::span<const Light> lights() const { return lights_; }

  double extinction(const Vec3&) const { return 0; }

  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

 private:
  explicit FdsFlame(std::vector<Light> lights);

  std::vector<Light> lights_;  // on the same grid, one at least
  Box3 bounds_;
  bool burns_ = false;
};

}  // namespace volute
