// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/segment_weights.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

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

constexpr int kTable = 1024;

struct WeightTable {
  std::vector<float> w0, w1;

  WeightTable() : w0(kTable * kTable), w1(kTable * kTable) {
    for (int i = 0; i < kTable; ++i) {
      for (int j = 0; j < kTable; ++j) {
        const SegmentWeights exact = segmentWeights(depth(i), depth(j));
        w0[i * kTable + j] = static_cast<float>(exact.w0);
        w1[i * kTable + j] = static_cast<float>(exact.w1);
      }
    }
  }

  /// Node i of an axis stands for e^-depth = i / (kTable - 1); the first for darkness.
  static double depth(int i) {
    return i == 0 ? 1e4 : -std::log(static_cast<double>(i) / (kTable - 1));
  }
};

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

SegmentWeights tableWeights(double d0, double d1) {
  static const WeightTable table;
  const double x = std::exp(-d0) * (kTable - 1), y = std::exp(-d1) * (kTable - 1);
  const int i = std::min(static_cast<int>(x), kTable - 2);
  const int j = std::min(static_cast<int>(y), kTable - 2);
  const double u = x - i, v = y - j;
  const auto read = [&](const std::vector<float>& values) {
    const float* at = &values[static_cast<std::size_t>(i) * kTable + j];
    return (1 - u) * ((1 - v) * at[0] + v * at[1]) +
           u * ((1 - v) * at[kTable] + v * at[kTable + 1]);
  };
  const double w0 = read(table.w0), w1 = read(table.w1);
  return {w0, w1, 1 - w0 - w1};
}

}  // namespace volute
