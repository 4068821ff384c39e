// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/quantiser.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace volute {
namespace {

// The exponent and the first 6 bits of the mantissa name a bin: 64 an octave.
constexpr int kBinShift = 17;
constexpr std::size_t kBins = std::size_t{0x7F800000} >> kBinShift;

/// The middle of a bin.
double binValue(std::size_t bin) {
  const auto bits = static_cast<std::uint32_t>(bin << kBinShift | 1u << (kBinShift - 1));
  return std::bit_cast<float>(bits);
}

}  // namespace

QuantisationModel::QuantisationModel() : counts_(kBins) {}

void QuantisationModel::add(float coefficient) {
  const float magnitude = std::fabs(coefficient);
  if (magnitude == 0)
    return;
  ++counts_[std::min<std::size_t>(std::bit_cast<std::uint32_t>(magnitude) >> kBinShift, kBins - 1)];
}

void QuantisationModel::merge(const QuantisationModel& other) {
  for (std::size_t i = 0; i < kBins; ++i) counts_[i] += other.counts_[i];
}

double QuantisationModel::squaredError(double step) const {
  // Errors within a step are spread evenly over [-0.4, 0.6) steps once a bin of the histogram is
  // wide against it.
  constexpr double kOffset = kRoundingOffset;
  constexpr double kEvenSpread =
      (kOffset * kOffset * kOffset + (1 - kOffset) * (1 - kOffset) * (1 - kOffset)) / 3;
  constexpr double kNarrow = 24;
  double error = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    if (counts_[i] == 0)
      continue;
    const double value = binValue(i);
    const double steps = value / step;
    const double e = value - std::floor(steps + kOffset) * step;
    error +=
        static_cast<double>(counts_[i]) * (steps > kNarrow ? kEvenSpread * step * step : e * e);
  }
  return error;
}

// Which coefficients are left costs their entropy; each of them its sign and its size in steps.
double QuantisationModel::bits(double step) const {
  double all = 0, left = 0, sizes = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const auto count = static_cast<double>(counts_[i]);
    const double steps = count > 0 ? binValue(i) / step : 0;
    all += count;
    if (steps < 1 - kRoundingOffset)
      continue;
    left += count;
    sizes += count * (2 + std::log2(std::max(steps, 1.0)));
  }
  const auto entropy = [](double part, double of) { return part * std::log2(of / part); };
  const double which = left > 0 && left < all ? entropy(left, all) + entropy(all - left, all) : 0;
  return 1 + which + sizes;
}

double QuantisationModel::stepFor(double target) const {
  const auto largest =
      std::find_if(counts_.rbegin(), counts_.rend(), [](std::uint64_t count) { return count > 0; });
  if (largest == counts_.rend())
    return 0;
  // Beyond four times the largest coefficient every one is dropped.
  double high = 4 * binValue(static_cast<std::size_t>(counts_.rend() - largest) - 1);
  if (squaredError(high) <= target)
    return high;
  double low = high * 0x1p-40;
  for (int i = 0; i < 60 && high / low > 1.0001; ++i) {
    const double middle = std::sqrt(low * high);
    (squaredError(middle) <= target ? low : high) = middle;
  }
  return low;
}

}  // namespace volute
