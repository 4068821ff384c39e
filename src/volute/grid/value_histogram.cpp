// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/value_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace volute {

std::uint32_t ValueHistogram::binOf(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return ((bits >> 31) != 0 ? ~bits : bits | 0x80000000u) >> kShift;
}

float ValueHistogram::leastOf(std::uint32_t bin) {
  const std::uint32_t bits = bin << kShift;
  return std::bit_cast<float>((bits >> 31) != 0 ? bits & 0x7FFFFFFFu : ~bits);
}

/// The bin of the value that so many others are below.
std::uint32_t ValueHistogram::binAt(std::uint64_t rank) const {
  std::uint32_t bin = 0;
  while (bin + 1 < counts_.size() && rank >= counts_[bin]) rank -= counts_[bin++];
  return bin;
}

/// How many of the greatest values (`step` -1), or of the least (1), are far from the rest, of
/// which `others` at the other end are left out.
std::uint64_t ValueHistogram::farValues(std::uint64_t count, int step, std::uint64_t others) const {
  constexpr double kGap = 8;
  const auto edge = [](std::int64_t bin) {
    return static_cast<double>(leastOf(static_cast<std::uint32_t>(bin)));
  };
  const auto countAt = [&](std::int64_t bin) { return counts_[static_cast<std::size_t>(bin)]; };
  const std::int64_t first = binAt(step > 0 ? 0 : count - 1);
  const std::int64_t last = binAt(step > 0 ? count - 1 - others : others);
  std::uint64_t far = 0, beyond = 0;
  for (std::int64_t bin = first; step * bin < step * last;) {
    beyond += countAt(bin);
    if (beyond > count / 100)
      break;
    std::int64_t next = bin + step;
    while (countAt(next) == 0) next += step;  // `last` is not empty
    const double gap = edge(std::max(bin, next)) - edge(std::min(bin, next) + 1);
    if (gap > kGap * (edge(std::max(next, last) + 1) - edge(std::min(next, last))))
      far = beyond;
    bin = next;
  }
  return far;
}

std::optional<std::pair<double, double>> ValueHistogram::robustRange(double least,
                                                                     double most) const {
  constexpr double kTail = 1e-4;
  constexpr std::uint64_t kFewValues = 1000;
  const auto count = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  if (count == 0)
    return std::nullopt;
  // One value at least, so that a single one does not rule a small grid either.
  const auto quantile =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(kTail * static_cast<double>(count)));
  const std::uint64_t tail = count < kFewValues ? 0 : quantile;
  const std::uint64_t above = std::max(tail, farValues(count, -1, tail));
  const std::uint64_t low = std::max(tail, farValues(count, 1, above));
  const std::uint64_t high = std::max(tail, farValues(count, -1, low));
  if (low + high == 0)
    return std::nullopt;
  const std::uint32_t lowBin = binAt(low), highBin = binAt(count - 1 - high);
  const double from = std::max<double>(leastOf(lowBin), least);
  const double to = std::min<double>(leastOf(highBin + 1), most);
  // Where nearly all are 0, the others are what there is.
  const bool zeros = lowBin == binOf(0) && highBin == binOf(0);
  if (zeros || !std::isfinite(to) || !(to > from) || 2 * (to - from) >= most - least)
    return std::nullopt;
  return std::pair(from, to);
}

}  // namespace volute
