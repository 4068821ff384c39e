// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "volute/optics/extinction.hpp"

// What pictures, remarks and errors say of a smoke model.

namespace volute {

/// The unit of a field's values: "g/m3", "kg/kg", "1/m", "dB/m" or "m".
std::string unitOfField(const SmokeModel& model);

/// Whether a field tells how much mass is in a volume; the others say what becomes of light.
bool holdsMass(SmokeQuantity quantity);

/// The unit in which the concentration, mass of what the field counts per volume of gas, is shown:
/// the field's own of densities, kg/m3 of a mass fraction. Empty: the field holds no mass.
std::string unitOfConcentration(const SmokeModel& model);

/// Extinction of one such unit [1/m]; 0 where the field holds no mass.
double extinctionOfConcentration(const SmokeModel& model);

/// What the values are and how they become extinction, without what plays no part in it:
/// "soot-density [g/m3]", "scale 2", "Km = 8700 m2/kg", "ys = 0.1".
std::vector<std::string> wordsOf(const SmokeModel& model);

/// What a unit in a field's name, as in "soot [mg/m3]", says against how its values are read;
/// empty: nothing, or it names no unit.
std::string compareUnitInName(std::string_view field, const SmokeModel& model);

/// Powers of kg, m, s, K, mol, A and cd for people, "kg m^-3", or "no dimensions".
std::string textOfDimensions(const std::array<double, 7>& dimensions);

/// Compares the dimensions that a file states, powers of kg, m, s, K, mol, A and cd, with those of
/// a field's quantity. An error where they are another quantity's, half a sentence where they say
/// nothing (a number without dimensions) or the unit differs by a factor, empty where all is well.
[[nodiscard]] Result<std::string> compareDimensions(const std::array<double, 7>& stated,
                                                    const SmokeModel& model,
                                                    const std::string& where);

}  // namespace volute
