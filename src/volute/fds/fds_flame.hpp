// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/fds/fds_field.hpp"

namespace volute {

/// How heat that is released becomes light that is seen.
struct FlameLaw {
  double temperature = 1500;  ///< [K]: the colour is that of a black body
  /// Luminance [1/m] of what releases 1 MW/m3, in units of a white wall's under full light.
  double emission = 20;
  double cutoff = 200;  ///< [kW/m3]: where less is released there is no flame
};

/// A fire as a medium that shines and hides nothing: light in proportion to the heat that is
/// released, with the colour of a black body. Smokeview too draws what exceeds a cutoff, with a
/// colour of its own. It is a picture of where it burns, not photometry: what a flame sends as
/// light depends on its soot, which FDS does not resolve.
///
/// The cutoff is applied to the stored values, before anything is interpolated. Cheap to copy.
class FdsFlame {
 public:
  /// `heat` holds the heat release [kW/m3] in place of an extinction.
  FdsFlame(const FdsField& heat, const FlameLaw& law);

  /// Whether there is a flame anywhere.
  bool burns() const { return burns_; }

  /// Of the cells that burn; without any, of the case.
  Box3 bounds() const { return bounds_; }

  /// Heat above the cutoff [kW/m3] in place of an extinction, and the radiance per metre of 1 kW/m3.
  const FdsField& heat() const { return light_; }

  const Rgb& colour() const { return colour_; }

  double extinction(const Vec3&) const { return 0; }

  Rgb emission(const Vec3& point) const { return colour_ * light_.extinction(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

 private:
  FdsField light_;  // heat above the cutoff [kW/m3]
  Rgb colour_;      // radiance per metre of 1 kW/m3
  Box3 bounds_;
  bool burns_ = false;
};

}  // namespace volute
