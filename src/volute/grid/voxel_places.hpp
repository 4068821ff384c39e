// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// Some of the corners of a brick of cells, 9 a side, x fastest: one bit for each.
class CornerSet {
 public:
  static constexpr int kSide = BrickSlice::kSide + 1;
  static constexpr int kCorners = kSide * kSide * kSide;

  bool has(int corner) const {
    return (words_[static_cast<std::size_t>(corner) / 64] >> corner % 64 & 1) != 0;
  }

  void add(int corner) {
    words_[static_cast<std::size_t>(corner) / 64] |= std::uint64_t{1} << corner % 64;
  }

  /// Calls visit(corner) for each, in ascending order.
  template <class Visit>
  void each(Visit&& visit) const {
    for (std::size_t word = 0; word < words_.size(); ++word) {
      for (std::uint64_t rest = words_[word]; rest != 0; rest &= rest - 1)
        visit(static_cast<int>(64 * word) + std::countr_zero(rest));
    }
  }

  /// How many there are before `corner`; before kCorners: all.
  int before(int corner) const {
    const auto last = static_cast<std::size_t>(corner) / 64;
    int count = std::popcount(words_[last] & ((std::uint64_t{1} << corner % 64) - 1));
    for (std::size_t word = 0; word < last; ++word) count += std::popcount(words_[word]);
    return count;
  }

 private:
  std::array<std::uint64_t, kCorners / 64 + 1> words_{};
};

/// The corners of a brick of cells that are in a list of voxels.
struct BrickCorners {
  CornerSet needed;         ///< all that are
  CornerSet own;            ///< those of them that no brick before has
  std::uint32_t first = 0;  ///< the place of its first own one; the others follow
};

/// A list of voxels; of those that are corners of bricks of cells in a bit each. A view.
class VoxelPlaces {
 public:
  using Place = std::array<std::int32_t, 3>;

  VoxelPlaces() = default;

  VoxelPlaces(const std::vector<Place>& places) : places_(places) {}

  /// @param corners  of the bricks; a cell's first corner is the voxel before it
  /// @param places  those behind them
  VoxelPlaces(std::span<const BrickCorners> corners, std::span<const BrickSlice::Entry> bricks,
              std::span<const Place> places)
      : corners_(corners), bricks_(bricks), places_(places) {
    if (!corners.empty())
      ofBricks_ = corners.back().first +
                  static_cast<std::size_t>(corners.back().own.before(CornerSet::kCorners));
  }

  std::size_t size() const { return ofBricks_ + places_.size(); }

  static Place cornerOf(const BrickPlace& brick, int corner) {
    constexpr int kSide = CornerSet::kSide;
    return {BrickSlice::kSide * brick[0] + corner % kSide - 1,
            BrickSlice::kSide * brick[1] + corner / kSide % kSide - 1,
            BrickSlice::kSide * brick[2] + corner / kSide / kSide - 1};
  }

  /// Looks up places, most of which are in the same brick as the one before.
  class Reader {
   public:
    explicit Reader(const VoxelPlaces& of) : of_(of) {}

    Place operator[](std::size_t i) {
      if (i >= of_.ofBricks_)
        return of_.places_[i - of_.ofBricks_];
      if (i < first_ || i - first_ >= count_)
        enter(i);
      return cornerOf(brick_, corners_[i - first_]);
    }

   private:
    void enter(std::size_t i) {
      const auto after = std::ranges::upper_bound(of_.corners_, i, {}, &BrickCorners::first);
      const auto found = std::prev(after);
      brick_ = of_.bricks_[static_cast<std::size_t>(found - of_.corners_.begin())].place;
      first_ = found->first, count_ = 0;
      found->own.each([&](int corner) { corners_[count_++] = static_cast<std::int16_t>(corner); });
    }

    const VoxelPlaces& of_;
    BrickPlace brick_{};
    std::size_t first_ = 0, count_ = 0;
    std::array<std::int16_t, CornerSet::kCorners> corners_;
  };

 private:
  std::span<const BrickCorners> corners_;
  std::span<const BrickSlice::Entry> bricks_;
  std::span<const Place> places_;
  std::size_t ofBricks_ = 0;
};

}  // namespace volute
