// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/quantiser.hpp"

#include <bit>
#include <cmath>

namespace volute {
namespace {

constexpr int kBinShift = 17;  // the exponent and the first 6 bits of the mantissa: 64 bins an octave
constexpr std::size_t kBins = std::size_t{0x7F800000} >> kBinShift;

}  // namespace

QuantisationModel::QuantisationModel() : bins_(kBins) {}

void QuantisationModel::add(float coefficient) {
  const float magnitude = std::fabs(coefficient);
  if (magnitude == 0) return;
  Bin& bin = bins_[std::min<std::size_t>(std::bit_cast<std::uint32_t>(magnitude) >> kBinShift, kBins - 1)];
  bin.count += 1;
  bin.sum += magnitude;
  bin.squares += static_cast<double>(magnitude) * magnitude;
}

void QuantisationModel::merge(const QuantisationModel& other) {
  for (std::size_t i = 0; i < kBins; ++i) {
    bins_[i].count += other.bins_[i].count;
    bins_[i].sum += other.bins_[i].sum;
    bins_[i].squares += other.bins_[i].squares;
  }
}

double QuantisationModel::squaredError(double step) const {
  // Errors within a step are spread evenly over [-0.4, 0.6) steps once a bin of the histogram is wide against it.
  constexpr double kOffset = kRoundingOffset;
  constexpr double kEvenSpread = (kOffset * kOffset * kOffset + (1 - kOffset) * (1 - kOffset) * (1 - kOffset)) / 3;
  constexpr double kNarrow = 24;
  double error = 0;
  for (const Bin& bin : bins_) {
    if (bin.count == 0) continue;
    const double steps = bin.sum / bin.count / step;
    if (steps > kNarrow) {
      error += bin.count * kEvenSpread * step * step;
    } else {
      const double value = std::floor(steps + kOffset) * step;
      error += bin.squares - 2 * value * bin.sum + bin.count * value * value;
    }
  }
  return error;
}

double QuantisationModel::stepFor(double target) const {
  double low = 0, high = 0;
  for (std::size_t i = kBins; i-- > 0;) {
    if (bins_[i].count == 0) continue;
    high = 4 * bins_[i].sum / bins_[i].count;  // beyond it every coefficient is dropped
    break;
  }
  if (high == 0 || squaredError(high) <= target) return high;
  low = high * 0x1p-40;
  for (int i = 0; i < 60 && high / low > 1.0001; ++i) {
    const double middle = std::sqrt(low * high);
    (squaredError(middle) <= target ? low : high) = middle;
  }
  return low;
}

}  // namespace volute
