// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace volute {

/// The compact hexadeca-tree as arrays. A node has no position (the path implies it) and no
/// pointers of its own: nodes stand breadth-first, children of one parent side by side, and where a
/// node's coefficients begin is counted from a directory entry for every 32 nodes.
///
///   bytes   what
///   2       a node: coefficient mask; bit 0 tells that it has children
///   6       a node with children: child mask and the number of the first child
///   1 or 2  a coefficient: quantised, signed; int8 on the fine levels, int16 on levels where int8
///   is too small 8       each coefficient that does not fit (marked by the type's lowest value) 8
///   each 32 nodes: the directory
struct TreeData {
  static constexpr std::uint32_t kNoNode = 0xFFFFFFFFu;
  static constexpr int kGroup = 32;  ///< nodes a directory entry; their masks fill one cache line

  static constexpr int kPadding = 16;

  struct Group {
    std::uint32_t coefficients =
        0;  ///< before this group, counted from the begin of its level, in multiples of channels
    std::uint32_t inner = 0;  ///< nodes with children before this group, from the begin of the tree
  };

  struct Level {
    std::uint32_t firstNode =
        0;  ///< a multiple of kGroup; the gap before the next level is filled with empty nodes
    std::uint32_t nodes = 0;
    float scale = 1;    ///< of one quantisation step in mean form
    bool wide = false;  ///< int16
    std::vector<std::int8_t>
        narrow8;  ///< and kPadding zeros, so that vectors may be loaded past the end
    std::vector<std::int16_t> wide16;
    std::vector<std::uint32_t> escapeIndex;  ///< ascending: places in narrow8 or wide16
    std::vector<std::int32_t> escapeValue;
  };

  /// Where the walk begins: the node and the value of what covers a block of 2^entryLevels cells a
  /// side.
  struct Entry {
    std::uint32_t node = kNoNode;
    std::array<float, 3> value{};
  };

  std::array<int, 4> extents{};  ///< t, z, y, x
  int channels = 1;
  int entryLevels = 0;             ///< levels below an entry: 4 for blocks of 16
  float step = 0;                  ///< of the orthonormal coefficients
  float minimum = 0, maximum = 0;  ///< values are clamped to these
  std::array<float, 3> mean{};     ///< the root's scaling coefficient, as a mean

  std::vector<std::uint16_t> masks;
  std::vector<Group> groups;
  std::vector<std::uint16_t> childMasks;
  std::vector<std::uint32_t> childBases;
  std::vector<Level> levels;   ///< [0] is the finest; the last holds the root
  std::vector<Entry> entries;  ///< one a block, C order (t, z, y, x)
  std::array<int, 4> entryCounts{};

  /// One bit for each frame and brick of 8^3 voxels, C order: 0 = all its voxels are exactly zero.
  std::vector<std::uint64_t> occupied;
  std::array<int, 3> bricks{};  ///< z, y, x

  bool isOccupied(int t, int z, int y, int x) const {
    const std::size_t bit =
        ((static_cast<std::size_t>(t) * bricks[0] + (z >> 3)) * bricks[1] + (y >> 3)) * bricks[2] +
        (x >> 3);
    return occupied[bit >> 6] >> (bit & 63) & 1;
  }

  const Entry& entryAt(int t, int z, int y, int x) const {
    return entries[((static_cast<std::size_t>(t >> entryLevels) * entryCounts[1] +
                     (z >> entryLevels)) *
                        entryCounts[2] +
                    (y >> entryLevels)) *
                       entryCounts[3] +
                   (x >> entryLevels)];
  }
};

}  // namespace volute
