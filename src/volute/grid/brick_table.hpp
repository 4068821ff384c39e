// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "volute/grid/traversal.hpp"

namespace volute {

/// The place of a brick among bricks: x, y, z.
using BrickPlace = std::array<int, 3>;

/// In the order of voxels: z slowest.
inline bool isBefore(const BrickPlace& a, const BrickPlace& b) {
  return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
}

/// A number for each of some bricks in a box of bricks. As large as what is in it: a table of the
/// whole box where that is small, or nearly full; else tables of 8^3 entries, below each other,
/// of which empty ones are not there.
///
/// Around the box there is a border of empty bricks.
class BrickTable {
 public:
  static constexpr std::int32_t kEmpty = -1;
  static constexpr int kNodeBits = 3;  ///< of a place on one axis that choose an entry of a node
  static constexpr int kNodeEntries = 1 << 3 * kNodeBits;

  BrickTable() = default;

  /// An empty one.
  /// @param count  bricks of the box on each axis
  /// @param bricks  that will have numbers, about
  BrickTable(const BrickPlace& count, std::size_t bricks);

  const BrickPlace& count() const { return count_; }

  /// kEmpty where none is set. From -1 to count() on each axis.
  std::int32_t at(int x, int y, int z) const {
    const int at[3] = {x + 1, y + 1, z + 1};
    int shift = kNodeBits * (levels_ - 1);
    std::int32_t entry = table_[topEntry(at, shift)];
    while (shift > 0 && entry >= 0) {
      shift -= kNodeBits;
      entry = table_[static_cast<std::size_t>(entry + nodeEntry(at, shift))];
    }
    return entry;
  }

  std::int32_t at(const BrickPlace& place) const { return at(place[0], place[1], place[2]); }

  /// @param number  or kEmpty
  void set(const BrickPlace& place, std::int32_t number);

  /// Calls visit(place, number, begin, end) for each brick with a number on a segment, front to
  /// back, until it returns false.
  /// @param bricks  the box: origin and size of its bricks
  template <class Visit>
  void walk(const CellGrid& bricks, const Segment& segment, Visit&& visit) const {
    const CellGrid shifted{bricks.origin - bricks.cell, bricks.cell, {}};
    const int shift = kNodeBits * (levels_ - 1);
    walkNode(shifted, {{0, 0, 0}, topCount_}, shift, 0, segment, visit);
  }

  /// How many tables there are above each other. One: `entries()` are of the whole box with its
  /// border, x fastest.
  int levels() const { return levels_; }

  /// Of the topmost table; those of the nodes follow. An entry is kEmpty, or a number in the lowest
  /// tables, and in those above where its node begins.
  std::span<const std::int32_t> entries() const { return table_; }

  /// For a step on each axis, in entries of the topmost table.
  const std::array<std::int32_t, 3>& topStride() const { return topStride_; }

  std::uint64_t bytes() const { return table_.size() * sizeof(std::int32_t); }

 private:
  std::size_t topEntry(const int (&at)[3], int shift) const {
    return static_cast<std::size_t>(at[2] >> shift) * static_cast<std::size_t>(topStride_[2]) +
           static_cast<std::size_t>(at[1] >> shift) * static_cast<std::size_t>(topStride_[1]) +
           static_cast<std::size_t>(at[0] >> shift);
  }

  static std::int32_t nodeEntry(const int (&at)[3], int shift) {
    constexpr int kMask = (1 << kNodeBits) - 1;
    return ((at[2] >> shift & kMask) << 2 * kNodeBits) | ((at[1] >> shift & kMask) << kNodeBits) |
           (at[0] >> shift & kMask);
  }

  /// @param first  entry of the node
  template <class Visit>
  bool walkNode(const CellGrid& bricks, const CellRange& range, int shift, std::int32_t first,
                const Segment& segment, Visit&& visit) const {
    const CellGrid cells{bricks.origin, static_cast<double>(1 << shift) * bricks.cell, range.end};
    const bool top = shift == kNodeBits * (levels_ - 1);
    bool on = true;
    traverseCells(cells, range, segment, [&](const auto& cell, double begin, double end) {
      if (!on)
        return;
      const int at[3] = {cell[0] << shift, cell[1] << shift, cell[2] << shift};
      const std::int32_t entry =
          table_[top ? topEntry(at, shift)
                     : static_cast<std::size_t>(first + nodeEntry(at, shift))];
      if (entry < 0)
        return;
      if (shift == 0) {
        on = visit(BrickPlace{cell[0] - 1, cell[1] - 1, cell[2] - 1}, entry, begin, end);
        return;
      }
      CellRange inner{.found = true};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        inner.begin[axis] = cell[axis] << kNodeBits;
        inner.end[axis] = inner.begin[axis] + (1 << kNodeBits);
      }
      on = walkNode(bricks, inner, shift - kNodeBits, entry,
                    Segment{segment.origin, segment.direction, begin, end}, visit);
    });
    return on;
  }

  BrickPlace count_{};
  int levels_ = 1;
  BrickPlace topCount_{1, 1, 1};
  std::array<std::int32_t, 3> topStride_{1, 1, 1};
  std::vector<std::int32_t> table_ = {kEmpty};
};

}  // namespace volute
