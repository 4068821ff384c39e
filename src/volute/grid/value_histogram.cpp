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

void ValueHistogram::add(float value, std::uint64_t count) {
  const std::uint32_t bin = binOf(value);
  const std::uint64_t rest = std::bit_cast<std::uint32_t>(value) & ((1u << kShift) - 1);
  counts_[bin] += count;
  rests_[bin] += rest * count;
  squares_[bin] += rest * rest * count;
}

/// Whether all values of a bin are the same: their variance is 0.
bool ValueHistogram::isOneValue(std::uint32_t bin) const {
  return counts_[bin] > 0 && counts_[bin] * squares_[bin] == rests_[bin] * rests_[bin];
}

/// Of a bin's values, in parts of its width.
double ValueHistogram::deviationIn(std::uint32_t bin) const {
  const auto count = static_cast<double>(counts_[bin]);
  if (counts_[bin] >> 31 != 0)
    return isOneValue(bin) ? 0 : 1;  // squares may have wrapped round
  const double mean = static_cast<double>(rests_[bin]) / count;
  const double square = static_cast<double>(squares_[bin]) / count - mean * mean;
  return std::sqrt(std::max(square, 0.0)) / (1u << kShift);
}

/// How many of the least and of the greatest values are no quantity but stand for something else:
/// one value or two, far from the others, which vary.
std::optional<std::pair<std::uint64_t, std::uint64_t>> ValueHistogram::standIns() const {
  constexpr double kGap = 8;
  constexpr std::size_t kMaxEach = 2, kVaried = 16;
  std::vector<std::uint32_t> bins;
  for (std::uint32_t bin = 0; bin < kBins; ++bin) {
    if (counts_[bin] > 0)
      bins.push_back(bin);
  }
  if (bins.size() < kVaried + 1)
    return std::nullopt;
  std::size_t lowest = 0, highest = 0;  // that are of one value
  while (lowest < kMaxEach && isOneValue(bins[lowest])) ++lowest;
  while (highest < kMaxEach && isOneValue(bins[bins.size() - 1 - highest])) ++highest;
  const auto edge = [](std::uint32_t bin) { return static_cast<double>(leastOf(bin)); };
  for (std::size_t all = lowest + highest; all > 0; --all) {
    for (std::size_t low = 0; low <= std::min(all, lowest); ++low) {
      const std::size_t high = all - low;
      if (high > highest || bins.size() < low + high + kVaried)
        continue;
      const std::uint32_t first = bins[low], last = bins[bins.size() - 1 - high];
      const double gap = kGap * (edge(last + 1) - edge(first));
      if ((low > 0 && !(edge(first) - edge(bins[low - 1] + 1) > gap)) ||
          (high > 0 && !(edge(bins[bins.size() - high]) - edge(last + 1) > gap)))
        continue;
      std::pair<std::uint64_t, std::uint64_t> found;
      for (std::size_t i = 0; i < low; ++i) found.first += counts_[bins[i]];
      for (std::size_t i = 0; i < high; ++i) found.second += counts_[bins[bins.size() - 1 - i]];
      return found;
    }
  }
  return std::nullopt;
}

std::uint64_t ValueHistogram::varied(double range) const {
  constexpr std::uint64_t kOneOf = 20, kOneOfNear = 10;
  constexpr double kNear = 0.002;
  const auto all = std::accumulate(voxels_.begin(), voxels_.end(), std::uint64_t{0});
  std::uint64_t same = 0;
  for (const std::uint64_t count : hashed_) same += count * kOneOf >= all ? count : 0;
  // Of runs of bins that are as wide at most, each once.
  const auto edge = [](std::uint32_t bin) { return static_cast<double>(leastOf(bin)); };
  std::uint64_t near = 0, inRun = 0;
  std::uint32_t first = 0, counted = 0;
  for (std::uint32_t bin = 0; bin + 1 < kBins && all > 0; ++bin) {
    if (voxels_[bin] == 0)
      continue;
    if (const double width = edge(bin + 1) - edge(bin); width > kNear * range) {
      if (voxels_[bin] * kOneOfNear >= all && deviationIn(bin) * width <= 0.25 * kNear * range)
        near += voxels_[bin];
      first = bin + 1, inRun = 0;
      continue;
    }
    inRun += voxels_[bin];
    while (first < bin && !(edge(bin + 1) - edge(first) <= kNear * range))
      inRun -= voxels_[first++];
    if (inRun * kOneOfNear < all || !(edge(bin + 1) - edge(first) <= kNear * range))
      continue;
    for (counted = std::max(counted, first); counted <= bin; ++counted) near += voxels_[counted];
  }
  return all - std::max(same, near);
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
  std::uint64_t low = std::max(tail, farValues(count, 1, above));
  std::uint64_t high = std::max(tail, farValues(count, -1, low));
  if (const auto others = standIns())
    low = std::max(low, others->first), high = std::max(high, others->second);
  if (low + high == 0 || low + high >= count)
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
