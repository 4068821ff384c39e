// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "volute/base/result.hpp"

// Inside Volute smoke is one number: its extinction K [1/m], natural logarithm, I/I0 = e^(-K L).
// Everything else that a file may hold is another spelling of it.

namespace volute {

/// What a field's values are; the names are those of scene files.
enum class SmokeQuantity {
  kSootDensity,       ///< mass of soot per volume of gas: K = Km value
  kProductsDensity,   ///< mass of all that the fuel became: K = Km ys value, ys the soot yield
  kMassFraction,      ///< mass of soot per mass of gas: K = Km density value
  kExtinction,        ///< K [1/m]
  kOpticalDensity,    ///< D = K / ln 10 [1/m]
  kOpticalDensityDb,  ///< 10 D [dB/m]
  kVisibility,        ///< S = C / K [m]
};

std::string_view nameOf(SmokeQuantity quantity);
[[nodiscard]] Result<SmokeQuantity> smokeQuantity(std::string_view name);

/// Kilogrammes per cubic metre in "kg/m3", "g/m3" or "mg/m3".
[[nodiscard]] Result<double> densityUnit(std::string_view name);

/// What FDS assumes for soot unless told otherwise [m2/kg].
inline constexpr double kFdsMassExtinction = 8700;

/// How a field's values become extinction.
struct SmokeModel {
  SmokeQuantity quantity = SmokeQuantity::kSootDensity;
  double scale = 1;  ///< multiplies the values first
  double unit = 1;   ///< kg/m3 in one unit of a density; see densityUnit()
  double massExtinction = kFdsMassExtinction;  ///< Km of soot, natural logarithm [m2/kg]
  double sootYield = 0;  ///< ys, mass of soot per mass burnt, in (0, 1]; of products-density
  /// Smoke potential of what burns [dB m2/g]; takes the place of Km and ys in products-density.
  std::optional<double> smokePotential{};
  double c = 3;  ///< of visibility

  /// Says what is missing or makes no sense.
  [[nodiscard]] Status check() const;

  /// K of one value [1/m]. `gasDensity` is that of mass-fraction [kg/m3]. A visibility of 0 gives
  /// infinity.
  double extinction(double value, double gasDensity = 1) const;

  /// K of many values, rounded to float, any of the spans' sizes equal; `gasDensity` may be empty
  /// unless the quantity is mass-fraction.
  void extinction(std::span<const float> values, std::span<const float> gasDensity,
                  std::span<float> out) const;

  /// Mass of soot per volume that an extinction stands for [kg/m3]: a check on the choice of
  /// quantity, 1e-6 to 1e-3 in burning rooms.
  double sootDensity(double extinction) const { return extinction / massExtinction; }
};

// Spellings of K [1/m].
double opticalDensity(double extinction);              ///< D [1/m]
double opticalDensityDb(double extinction);            ///< 10 D [dB/m]
double obscuration(double extinction, double length);  ///< 1 - e^(-K L)
/// K of 1 kg/m3 of products of a fuel with this smoke potential [m2/kg]: P = (10 / ln 10) Km ys.
/// Staubli et al. 2005, equation 1 and table 1, call (Km / 3) ys by that name; their table carries
/// measured decibels.
double productsExtinction(double smokePotential);
double smokePotential(double massExtinction, double sootYield);  ///< [dB m2/g] of Km [m2/kg], ys

}  // namespace volute
