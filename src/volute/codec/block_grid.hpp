// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "volute/grid/volume_info.hpp"

namespace volute {

/// How a sequence is cut into blocks of 16 frames, or fewer, x 16^3 voxels; those at the upper
/// border are smaller. Axes are always (t, z, y, x). Blocks are numbered in C order, t slowest.
class BlockGrid {
 public:
  static constexpr int kSide = 16;
  using Index4 = std::array<int, 4>;

  BlockGrid() = default;

  /// @param frames  of a block, 1 to kSide
  explicit BlockGrid(const VolumeInfo& info, int frames = kSide)
      : extents_{info.frames, info.z, info.y, info.x},
        sides_{frames, kSide, kSide, kSide},
        channels_(info.channels) {
    for (int axis = 0; axis < 4; ++axis)
      counts_[axis] = (extents_[axis] + sides_[axis] - 1) / sides_[axis];
  }

  std::size_t count() const {
    return static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2] * counts_[3];
  }

  /// Blocks of one row: the same frames.
  std::size_t rowCount() const {
    return static_cast<std::size_t>(counts_[1]) * counts_[2] * counts_[3];
  }

  const Index4& counts() const { return counts_; }

  /// Of a block that is not cut off by the upper border.
  const Index4& sides() const { return sides_; }

  /// Frames of a row of blocks, but perhaps of the last.
  int frames() const { return sides_[0]; }

  int rowOf(int frame) const { return frame / sides_[0]; }

  /// The frame after the last one of a row.
  int endOfRow(int row) const { return std::min((row + 1) * sides_[0], extents_[0]); }

  const Index4& volumeExtents() const { return extents_; }

  int channels() const { return channels_; }

  std::size_t blockAt(const Index4& c) const {
    return ((static_cast<std::size_t>(c[0]) * counts_[1] + c[1]) * counts_[2] + c[2]) * counts_[3] +
           c[3];
  }

  Index4 coordinate(std::size_t block) const {
    Index4 c{};
    for (int axis = 4; axis-- > 0;) {
      c[axis] = static_cast<int>(block % counts_[axis]);
      block /= counts_[axis];
    }
    return c;
  }

  /// First voxel and frame of a block.
  Index4 origin(std::size_t block) const {
    Index4 c = coordinate(block);
    for (int axis = 0; axis < 4; ++axis) c[axis] *= sides_[axis];
    return c;
  }

  /// Its size: sides(), or less at the upper border.
  Index4 extents(std::size_t block) const {
    Index4 e = origin(block);
    for (int axis = 0; axis < 4; ++axis) e[axis] = std::min(sides_[axis], extents_[axis] - e[axis]);
    return e;
  }

  std::size_t values(std::size_t block) const {
    const Index4 e = extents(block);
    return static_cast<std::size_t>(e[0]) * e[1] * e[2] * e[3] * channels_;
  }

  /// Resolution levels of a block, the scaling coefficient included: 1 + ceil(log2(its longest
  /// side)).
  int levels(std::size_t block) const {
    const Index4 e = extents(block);
    int levels = 1;
    for (int side = std::max(std::max(e[0], e[1]), std::max(e[2], e[3])); side > 1;
         side = (side + 1) / 2)
      ++levels;
    return levels;
  }

 private:
  Index4 extents_{};
  Index4 sides_{kSide, kSide, kSide, kSide};
  Index4 counts_{};
  int channels_ = 1;
};

}  // namespace volute
