// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/codec/block_grid.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

/// The frames of one row of blocks (16 frames), or some layers of blocks of them, read from a
/// source and cut into blocks.
class BlockRow {
 public:
  explicit BlockRow(FrameSource& source);

  /// What load() holds at most, for so many layers of blocks [bytes].
  static std::uint64_t bytesNeeded(const VolumeInfo& info, int layers);
  static std::uint64_t bytesNeeded(const VolumeInfo& info);

  int rows() const { return grid_.counts()[0]; }

  const BlockGrid& grid() const { return grid_; }

  /// Reads row `row`. NaN and infinities are refused: the message names grid, frame, voxel and
  /// channel.
  [[nodiscard]] Status load(int row) { return load(row, 0, grid_.counts()[1]); }

  /// Of it the layers firstLayer <= z < endLayer, counted in blocks. What is loaded already is not
  /// read again.
  [[nodiscard]] Status load(int row, int firstLayer, int endLayer);

  /// Smallest and greatest value of all rows loaded so far.
  float minimum() const { return minimum_; }

  float maximum() const { return maximum_; }

  /// roundingOf() the source, of all that was loaded.
  double rounding() const { return roundingOf(source_); }

  /// Block `block` of what is loaded, shape extents x channels; `values` has room for
  /// exactly that. Thread-safe.
  void cut(std::size_t block, std::span<float> values) const;

 private:
  [[nodiscard]] Status scan(int firstFrame);

  FrameSource& source_;
  BlockGrid grid_;
  std::vector<float> values_;                     // (t, z, y, x, c), of the layers that are loaded
  int row_ = -1, firstLayer_ = 0, endLayer_ = 0;  // that are loaded
  float minimum_, maximum_;
};

}  // namespace volute
