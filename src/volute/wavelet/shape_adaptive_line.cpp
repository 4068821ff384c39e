// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One line, sample by sample, and the norms of its basis functions.
#include <array>

#include "volute/base/assert.hpp"
#include "volute/wavelet/lifting_steps.hpp"
#include "volute/wavelet/shape_adaptive.hpp"

namespace volute {
namespace {

class Line {
 public:
  Line(std::span<float> samples, std::span<const std::uint8_t> support)
      : x_(samples), support_(support), n_(static_cast<int>(samples.size())) {}

  void step(int first, double factor) {
    const auto f = static_cast<float>(factor);
    for (int i = first; i < n_; i += 2) {
      if (!in(i) || lone(i))
        continue;
      const float before = in(i - 1) ? x_[i - 1] : x_[i + 1];
      const float after = in(i + 1) ? x_[i + 1] : x_[i - 1];
      x_[i] += f * (before + after);
    }
  }

  void scale(double low, double high, double loneLow) {
    for (int i = 0; i < n_; ++i) {
      if (i % 2 == 0)
        x_[i] *= static_cast<float>(lone(i) ? loneLow : low);
      else if (!lone(i))
        x_[i] *= static_cast<float>(high);
    }
  }

  void haar(double alone) {
    constexpr auto kHalf = static_cast<float>(1 / kRootTwo);
    for (int i = 0; i < n_; i += 2) {
      const float a = x_[i];
      if (in(i) && in(i + 1)) {
        x_[i] = (a + x_[i + 1]) * kHalf;
        x_[i + 1] = (a - x_[i + 1]) * kHalf;
      } else {
        x_[i] = a * static_cast<float>(alone);
      }
    }
  }

 private:
  bool in(int i) const { return i >= 0 && i < n_ && (support_.empty() || support_[i] != 0); }

  bool lone(int i) const { return !in(i - 1) && !in(i + 1); }

  std::span<float> x_;
  std::span<const std::uint8_t> support_;
  int n_;
};

}  // namespace

void shapeForwardLine(std::span<float> samples, std::span<const std::uint8_t> support,
                      Wavelet wavelet) {
  Line line(samples, support);
  if (wavelet == Wavelet::kHaar)
    return line.haar(kRootTwo);
  const LiftingSteps steps = liftingSteps(wavelet);
  for (int i = 0; i < steps.count; ++i) line.step(i % 2 == 0 ? 1 : 0, steps.factor[i]);
  line.scale(steps.scale, 1 / steps.scale, kRootTwo);
}

void shapeInverseLine(std::span<float> coefficients, std::span<const std::uint8_t> support,
                      Wavelet wavelet) {
  Line line(coefficients, support);
  if (wavelet == Wavelet::kHaar)
    return line.haar(1 / kRootTwo);
  const LiftingSteps steps = liftingSteps(wavelet);
  line.scale(1 / steps.scale, steps.scale, 1 / kRootTwo);
  for (int i = steps.count; i-- > 0;) line.step(i % 2 == 0 ? 1 : 0, -steps.factor[i]);
}

double synthesisNorm(Wavelet wavelet, int levels, bool high) {
  using Norms = std::array<double, 5>;
  constexpr Norms kLow53{1, 0.866025404, 0.829156198, 0.819679816, 0.817293552};
  constexpr Norms kHigh53{1, 1.198957881, 0.960143218, 0.890487928, 0.872205359};
  constexpr Norms kLow97{1, 0.991440194, 1.015185928, 1.025715858, 1.028821294};
  constexpr Norms kHigh97{1, 1.020017629, 0.983471304, 1.019621394, 1.036880210};
  VOLUTE_ASSERT(levels >= 0 && levels <= 4);
  const auto i = static_cast<std::size_t>(levels);
  switch (wavelet) {
    case Wavelet::kCdf53:
      return high ? kHigh53[i] : kLow53[i];
    case Wavelet::kCdf97:
      return high ? kHigh97[i] : kLow97[i];
    default:
      return 1;
  }
}

}  // namespace volute
