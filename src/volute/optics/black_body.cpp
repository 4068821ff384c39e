// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/optics/black_body.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

/// A bell with different widths on its two sides.
double bell(double x, double peak, double below, double above) {
  const double t = (x - peak) / (x < peak ? below : above);
  return std::exp(-0.5 * t * t);
}

/// The CIE 1931 observer as Wyman, Sloan and Shirley 2013 fit it; wavelength in nm.
std::array<double, 3> observer(double nm) {
  return {1.056 * bell(nm, 599.8, 37.9, 31.0) + 0.362 * bell(nm, 442.0, 16.0, 26.7) -
              0.065 * bell(nm, 501.1, 20.4, 26.2),
          0.821 * bell(nm, 568.8, 46.9, 40.5) + 0.286 * bell(nm, 530.9, 16.3, 31.1),
          1.217 * bell(nm, 437.0, 11.8, 36.0) + 0.681 * bell(nm, 459.0, 26.0, 13.8)};
}

}  // namespace

std::array<double, 3> blackBodyColour(double temperature) {
  constexpr double kSecond = 1.438776877e7;  // second radiation constant [nm K]
  std::array<double, 3> xyz{};
  for (double nm = 360; nm <= 830; nm += 1) {
    // Wien's factor of 560 nm is taken out: a common one, and small numbers stay away.
    const double radiance = std::pow(560 / nm, 5) * std::exp(kSecond / (560 * temperature)) /
                            std::expm1(kSecond / (nm * temperature));
    const auto weights = observer(nm);
    for (std::size_t i = 0; i < 3; ++i) xyz[i] += radiance * weights[i];
  }
  const auto& [x, y, z] = xyz;
  // IEC 61966-2-1.
  std::array<double, 3> rgb{3.2406 * x - 1.5372 * y - 0.4986 * z,
                            -0.9689 * x + 1.8758 * y + 0.0415 * z,
                            0.0557 * x - 0.2040 * y + 1.0570 * z};
  for (double& channel : rgb) channel = std::max(0.0, channel);
  const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  for (double& channel : rgb) channel /= luminance;
  return rgb;
}

}  // namespace volute
