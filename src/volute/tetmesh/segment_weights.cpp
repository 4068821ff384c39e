// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/segment_weights.hpp"

#include <algorithm>
#include <cmath>

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

constexpr double kDark = 40;  // optical depths beyond which nothing passes: e^-40

/// Depth from the near end to the share s of the length.
double depthTo(double d0, double d1, double s) {
  return s * (d0 + 0.5 * s * (d1 - d0));
}

/// Where depthTo is kDark, or 1.
double darkAt(double d0, double d1) {
  const double root = d0 * d0 + 2 * kDark * (d1 - d0);
  return root < 0 ? 1 : std::min(1.0, 2 * kDark / (d0 + std::sqrt(root)));
}

}  // namespace

SegmentWeights segmentWeights(double d0, double d1) {
  // w0 = integral of 1 - T, w1 = integral of T - T(1), over the length as 1: by parts from
  // equation 7.
  const double whole = 0.5 * (d0 + d1);
  const double dark = darkAt(d0, d1);
  SegmentWeights weights{1 - dark, 0, std::exp(-whole)};
  constexpr int kPanels = 16;
  for (int i = 0; i < kPanels; ++i) {
    const double from = dark * i / kPanels, to = dark * (i + 1) / kPanels;
    weights.w0 +=
        gaussIntegral(8, from, to, [&](double s) { return -std::expm1(-depthTo(d0, d1, s)); });
    weights.w1 += gaussIntegral(8, from, to, [&](double s) {
      const double after = whole - depthTo(d0, d1, s);
      return after < 1 ? weights.transmittance * std::expm1(after)
                       : std::exp(-depthTo(d0, d1, s)) - weights.transmittance;
    });
  }
  return weights;
}

}  // namespace volute
