// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <numbers>

namespace volute {

/// The phase function of Henyey and Greenstein [1/sr]; its integral over the sphere is 1. `cosine`
/// is between the directions in which the light travels before and after; -1 < asymmetry < 1.
inline double henyeyGreenstein(double asymmetry, double cosine) {
  const double g = asymmetry;
  const double base = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * std::numbers::pi * base * std::sqrt(base));
}

}  // namespace volute
