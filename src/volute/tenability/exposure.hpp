// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "volute/base/result.hpp"

// What people are exposed to.

namespace volute {

enum class Air : unsigned char {
  kTemperature,     ///< [degrees C]
  kRadiantFlux,     ///< [kW/m2]
  kCarbonMonoxide,  ///< this and all that follow up to kFormaldehyde: [mol/mol]
  kCarbonDioxide,
  kOxygen,
  kHydrogenCyanide,
  kNitricOxide,
  kNitrogenDioxide,
  kHydrogenChloride,
  kHydrogenBromide,
  kHydrogenFluoride,
  kSulfurDioxide,
  kAcrolein,
  kFormaldehyde,
  kExtinction,  ///< of the smoke where one stands [1/m]
};

inline constexpr std::size_t kAirQuantities = 15;

/// A quantity as files and options name it.
struct AirQuantity {
  Air quantity;
  std::string_view name;  ///< "carbon-monoxide"
  std::string_view unit;  ///< "mol/mol"
  double clean = 0;       ///< in clean air
};

std::span<const AirQuantity, kAirQuantities> airQuantities();
const AirQuantity& quantityOf(Air air);

/// By its name; the error suggests the nearest.
[[nodiscard]] Result<Air> airQuantity(std::string_view name);

/// The air around somebody. NaN: not known.
class Exposure {
 public:
  /// Clean air at 20 degrees C.
  Exposure();

  double& operator[](Air air) { return values_[static_cast<std::size_t>(air)]; }

  double operator[](Air air) const { return values_[static_cast<std::size_t>(air)]; }

  double ppm(Air gas) const { return 1e6 * (*this)[gas]; }

  double percent(Air gas) const { return 100 * (*this)[gas]; }

 private:
  std::array<double, kAirQuantities> values_{};
};

}  // namespace volute
