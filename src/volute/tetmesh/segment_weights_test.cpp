// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/segment_weights.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

constexpr double kDepths[] = {0, 1e-9, 1e-4, 0.01, 0.3, 1, 2.5, 7, 20, 80, 1e3, 1e6};

/// Equation 7 as it stands.
double byDefinition(double d0, double d1, bool second) {
  const double dark = std::min(1.0, 60 / std::max(d0, std::sqrt(d1)) + 1e-12);
  return adaptiveIntegral(
      [&](double s) {
        const double tau = (1 - s) * d0 + s * d1;
        return tau * std::exp(-s * (d0 + 0.5 * s * (d1 - d0))) * (second ? s : 1 - s);
      },
      0, dark, 1e-12, 40);
}

TEST(SegmentWeights, SolveEquation7) {
  for (const double d0 : kDepths) {
    for (const double d1 : kDepths) {
      const SegmentWeights weights = segmentWeights(d0, d1);
      EXPECT_NEAR(weights.w0, byDefinition(d0, d1, false), 1e-9) << d0 << " " << d1;
      EXPECT_NEAR(weights.w1, byDefinition(d0, d1, true), 1e-9) << d0 << " " << d1;
      EXPECT_NEAR(weights.w0 + weights.w1 + weights.transmittance, 1, 1e-12) << d0 << " " << d1;
    }
  }
}

TEST(SegmentWeights, LeaveTheTransmittanceThatThePaperMisprints) {
  const SegmentWeights weights = segmentWeights(1, 3);
  EXPECT_NEAR(weights.transmittance, 0.13534, 5e-6);
  EXPECT_NEAR(1 - weights.w0 - weights.w1, 0.13534, 5e-6);
  EXPECT_NEAR(1 - weights.w0 + weights.w1, 0.8788, 5e-5);
}

}  // namespace
}  // namespace volute
