// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/brick_table.hpp"

#include <limits>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Tables of so many entries are small whatever is in them.
constexpr std::uint64_t kSmallTable = 1 << 15;
/// Entries a brick in a table of the whole box: a brick itself takes 512 values.
constexpr std::uint64_t kEntriesPerBrick = 8;

}  // namespace

BrickTable::BrickTable(const BrickPlace& count, std::size_t bricks) : count_(count) {
  const std::uint64_t most = std::max<std::uint64_t>(kSmallTable, kEntriesPerBrick * bricks);
  for (levels_ = 1;; ++levels_) {
    const int shift = kNodeBits * (levels_ - 1);
    for (std::size_t axis = 0; axis < 3; ++axis) topCount_[axis] = ((count[axis] + 1) >> shift) + 1;
    const std::uint64_t rows =
        static_cast<std::uint64_t>(topCount_[1]) * static_cast<std::uint64_t>(topCount_[2]);
    if (rows <= most && rows * static_cast<std::uint64_t>(topCount_[0]) <= most)
      break;
  }
  topStride_ = {1, topCount_[0], topCount_[0] * topCount_[1]};
  table_.assign(static_cast<std::size_t>(topStride_[2]) * static_cast<std::size_t>(topCount_[2]),
                kEmpty);
}

void BrickTable::set(const BrickPlace& place, std::int32_t number) {
  const int at[3] = {place[0] + 1, place[1] + 1, place[2] + 1};
  int shift = kNodeBits * (levels_ - 1);
  std::size_t entry = topEntry(at, shift);
  while (shift > 0) {
    shift -= kNodeBits;
    if (table_[entry] < 0) {
      if (number == kEmpty)
        return;
      VOLUTE_ASSERT(table_.size() <
                    std::numeric_limits<std::int32_t>::max() - std::size_t{kNodeEntries});
      table_[entry] = static_cast<std::int32_t>(table_.size());
      table_.resize(table_.size() + kNodeEntries, kEmpty);
    }
    entry = static_cast<std::size_t>(table_[entry] + nodeEntry(at, shift));
  }
  table_[entry] = number;
}

}  // namespace volute
