// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/weight_table.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {

namespace {

constexpr double kDark = 30;  // optical depth beyond which nothing passes

/// segmentWeights()'s w0, to 1e-7: the integral of 1 - T over the length as 1.
double nearWeight(double d0, double d1) {
  const double root = d0 * d0 + 2 * kDark * (d1 - d0);
  const double dark = root < 0 ? 1 : std::min(1.0, 2 * kDark / (d0 + std::sqrt(root)));
  double sum = 1 - dark;
  constexpr int kPanels = 4;
  for (int i = 0; i < kPanels; ++i) {
    sum += gaussIntegral(8, dark * i / kPanels, dark * (i + 1) / kPanels,
                         [&](double s) { return -std::expm1(-s * (d0 + 0.5 * s * (d1 - d0))); });
  }
  return sum;
}

}  // namespace

std::vector<float> weightTable(int side) {
  constexpr double kDarkest = 1e6;  // stands for infinite depth
  const auto depthAt = [&](int i) {
    const double x = static_cast<double>(i) / (side - 1);
    return i < side - 1 ? x / (1 - x) : kDarkest;
  };
  std::vector<float> texels(2 * static_cast<std::size_t>(side) * side);
  parallelFor(static_cast<std::size_t>(side), [&](std::size_t row) {
    float* texel = &texels[2 * row * side];
    for (int i = 0; i < side; ++i) {
      const double d0 = depthAt(i), d1 = depthAt(static_cast<int>(row));
      const double w0 = nearWeight(d0, d1);
      *texel++ = static_cast<float>(w0);
      *texel++ = static_cast<float>(1 - std::exp(-0.5 * (d0 + d1)) - w0);
    }
  });
  return texels;
}

}  // namespace volute
