// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/synth/hall_files.hpp"

namespace volute {

/// The hall and its fire as an FDS case with the files that FDS would write: the index, the input
/// file with the burner, 3D slices of soot, temperature, CO, CO2 and O2, and the heat release.
/// It burns on a stack of goods. Temperature and gases follow from the soot by the yields of
/// hallCaseAir().
/// @param target  ends in .smv
[[nodiscard]] Status writeHallCase(const HallFiles& files, const std::filesystem::path& target,
                                   Progress& progress);

/// What people breathe and stand in where there is soot.
struct HallAir {
  double celsius = 0;                            ///< [degrees C]
  double monoxide = 0, dioxide = 0, oxygen = 0;  ///< [mol/mol]
};

/// Of a fuel of 25 kJ/g, of which 0.65 heats the gas, with yields of 0.05 soot, 0.04 CO and 2.0
/// CO2, that takes 2.2 of oxygen, all in g/g, into air of 1200 g/m3.
/// @param soot  [g/m3]
[[nodiscard]] HallAir hallCaseAir(double soot);

}  // namespace volute
