// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tenability/exposure.hpp"

#include <string>
#include <vector>

#include "volute/base/suggest.hpp"

namespace volute {

std::span<const AirQuantity, kAirQuantities> airQuantities() {
  static constexpr std::array<AirQuantity, kAirQuantities> quantities{{
      {Air::kTemperature, "temperature", "degrees C", 20},
      {Air::kRadiantFlux, "radiant-flux", "kW/m2"},
      {Air::kCarbonMonoxide, "carbon-monoxide", "mol/mol"},
      {Air::kCarbonDioxide, "carbon-dioxide", "mol/mol"},
      {Air::kOxygen, "oxygen", "mol/mol", 0.209},
      {Air::kHydrogenCyanide, "hydrogen-cyanide", "mol/mol"},
      {Air::kNitricOxide, "nitric-oxide", "mol/mol"},
      {Air::kNitrogenDioxide, "nitrogen-dioxide", "mol/mol"},
      {Air::kHydrogenChloride, "hydrogen-chloride", "mol/mol"},
      {Air::kHydrogenBromide, "hydrogen-bromide", "mol/mol"},
      {Air::kHydrogenFluoride, "hydrogen-fluoride", "mol/mol"},
      {Air::kSulfurDioxide, "sulfur-dioxide", "mol/mol"},
      {Air::kAcrolein, "acrolein", "mol/mol"},
      {Air::kFormaldehyde, "formaldehyde", "mol/mol"},
      {Air::kExtinction, "extinction", "1/m"},
  }};
  return quantities;
}

const AirQuantity& quantityOf(Air air) {
  return airQuantities()[static_cast<std::size_t>(air)];
}

Result<Air> airQuantity(std::string_view name) {
  std::vector<std::string_view> names;
  for (const AirQuantity& one : airQuantities()) {
    if (one.name == name)
      return one.quantity;
    names.push_back(one.name);
  }
  const auto near = nearest(name, names);
  return fail(ErrorCode::kInvalidArgument, "quantity '{}' is unknown{}", name,
              near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
}

Exposure::Exposure() {
  for (const AirQuantity& one : airQuantities()) (*this)[one.quantity] = one.clean;
}

}  // namespace volute
