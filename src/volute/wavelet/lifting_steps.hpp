// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>

#include "volute/wavelet/lifting.hpp"

namespace volute {

inline constexpr double kRootTwo = 1.41421356237309504880;

/// Steps alternate between the odd and the even samples, odd ones first: x[i] += factor (x[i-1] +
/// x[i+1]). Then low *= scale and high /= scale. Daubechies and Sweldens 1998, section 7. Haar has
/// no steps of this kind.
struct LiftingSteps {
  int count = 0;
  double factor[4]{};
  double scale = kRootTwo;
};

constexpr LiftingSteps liftingSteps(Wavelet wavelet) {
  switch (wavelet) {
    case Wavelet::kCdf53:
      return {2, {-0.5, 0.25}, kRootTwo};
    case Wavelet::kCdf97:
      return {4,
              {-1.586134342059924, -0.052980118572961, 0.882911075530934, 0.443506852043971},
              1.149604398860241};
    default:
      return {};
  }
}

/// Lines to lift side by side: row i holds sample i of each, `stride` numbers after row i - 1.
struct LiftingRows {
  float* samples = nullptr;
  const float* support = nullptr;  ///< 1 or 0, of the same shape; null for all
  std::size_t count = 0;           ///< samples of a line
  std::size_t lines = 0;
  std::size_t stride = 0;
};

}  // namespace volute
