// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

namespace volute {

/// CIE 1931 x and y of a black body: Planck's law seen by the tabulated observer for 2 degrees.
/// @param temperature  [K], 500 to 20000.
std::array<double, 2> blackBodyChromaticity(double temperature);

/// The luminance of a black body, times that of one of temperature `against` [K].
double blackBodyLuminance(double temperature, double against);

/// The colour of a black body: Planck's law seen by the CIE 1931 observer, in linear sRGB with
/// luminance 1. What lies outside of sRGB (flames are redder than it can be) is cut off at 0 before
/// the luminance is set.
/// @param temperature  [K], 500 to 20000.
std::array<double, 3> blackBodyColour(double temperature);

}  // namespace volute
