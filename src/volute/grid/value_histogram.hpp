// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace volute {

/// Counts of values by their first 16 bits, in the order of the values: bins are 2^-7 of their
/// values wide.
class ValueHistogram {
 public:
  void add(float value, std::uint64_t count);

  /// Of a voxel that is in no tile.
  void addVoxel(float value) {
    add(value, 1);
    ++voxels_[binOf(value)];
    ++hashed_[std::bit_cast<std::uint32_t>(value) * 0x9E3779B1u >> kShift];
  }

  const std::vector<std::uint64_t>& counts() const { return counts_; }

  /// What is known of the bins; processes add theirs up.
  std::array<std::vector<std::uint64_t>*, 5> sums() {
    return {&counts_, &rests_, &squares_, &voxels_, &hashed_};
  }

  /// The least value of a bin.
  static float leastOf(std::uint32_t bin);

  /// The range of nearly all values, instead of `least` to `most`; nothing: these serve. At each
  /// end the rest are .0001 of a thousand values or more, or up to a hundredth that lies beyond a
  /// gap of more than 8 times the range of all others, or, however many, one value or two beyond
  /// such a gap, which stand for something else (-999 for no data); without them less than half of
  /// the range is left.
  std::optional<std::pair<double, double>> robustRange(double least, double most) const;

  /// How many values of voxels differ from place to place: all but those that a twentieth or more
  /// of them have each, or but those of which a tenth is within .002 of the range.
  std::uint64_t varied(double range) const;

 private:
  static constexpr unsigned kShift = 16;
  static constexpr std::size_t kBins = std::size_t{1} << (32 - kShift);

  static std::uint32_t binOf(float value);
  std::uint32_t binAt(std::uint64_t rank) const;
  std::uint64_t farValues(std::uint64_t count, int step, std::uint64_t others) const;
  std::optional<std::pair<std::uint64_t, std::uint64_t>> standIns() const;
  bool isOneValue(std::uint32_t bin) const;
  double deviationIn(std::uint32_t bin) const;

  using Bins = std::vector<std::uint64_t>;
  Bins counts_ = Bins(kBins);
  Bins rests_ = Bins(kBins), squares_ = Bins(kBins);  // of the other 16 bits, modulo 2^64
  Bins voxels_ = Bins(kBins);                         // those that are in no tile
  Bins hashed_ = Bins(kBins);                         // likewise, by a hash of all bits
};

}  // namespace volute
