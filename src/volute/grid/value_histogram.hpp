// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace volute {

/// Counts of values by their first 16 bits, in the order of the values: bins are 2^-7 of their
/// values wide.
class ValueHistogram {
 public:
  void add(float value, std::uint64_t count) { counts_[binOf(value)] += count; }

  /// Counts of the bins; processes add theirs up.
  std::vector<std::uint64_t>& counts() { return counts_; }

  const std::vector<std::uint64_t>& counts() const { return counts_; }

  /// The least value of a bin.
  static float leastOf(std::uint32_t bin);

  /// The range of nearly all values, instead of `least` to `most`; nothing: these serve. At each
  /// end the rest are .0001 of a thousand values or more, or up to a hundredth that lies beyond a
  /// gap of more than 8 times the range of all others; without them less than half of the range is
  /// left.
  std::optional<std::pair<double, double>> robustRange(double least, double most) const;

 private:
  static constexpr unsigned kShift = 16;

  static std::uint32_t binOf(float value);
  std::uint32_t binAt(std::uint64_t rank) const;
  std::uint64_t farValues(std::uint64_t count, int step, std::uint64_t others) const;

  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(std::size_t{1} << (32 - kShift));
};

}  // namespace volute
