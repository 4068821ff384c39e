// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string_view>

namespace volute {

/// What makes a number of one unit a number of another.
struct UnitChange {
  double factor = 1;
  double offset = 0;

  double operator()(double value) const { return factor * value + offset; }
};

/// From one unit to another; nothing where one of them is not known or they measure different
/// things. Units are products of names with SI prefixes and exponents, as in "kW/m2", "mg m^-3" or
/// "m³"; min, h, %, ppm, degrees C, F, and feet are known too, and so are the words that people
/// write ("seconds", "metres"). A fraction without a unit, in % or ppm may be of amount (mol/mol)
/// or of mass (kg/kg), whichever the other unit says.
std::optional<UnitChange> unitChange(std::string_view from, std::string_view to);

/// Whether a unit of that name is known.
bool isUnit(std::string_view text);

}  // namespace volute
