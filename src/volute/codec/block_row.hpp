// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/block_grid.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

/// What is in one frame of a row: the values of its support, which is what is active or not equal
/// to the background.
struct SupportFacts {
  float least, most;         ///< of all values; +inf and -inf where there are none
  std::uint64_t voxels = 0;  ///< of the support, those of tiles too
  std::uint64_t tiles = 0;   ///< voxels of tiles among them

  SupportFacts();
  void add(float value);
  void add(const SupportFacts& other);
};

/// The frames of one row of blocks (16 frames, or fewer), or some layers of blocks of them, read
/// from a source and cut into blocks. As large as what is in them.
class BlockRow {
 public:
  explicit BlockRow(FrameSource& source);

  /// From now on blocks have so many frames.
  void cutBy(int frames);

  /// How many blocks of fewer frames would hold something, of what is loaded.
  std::uint64_t occupiedBy(int frames) const;

  /// What load() holds at most, for so many layers of blocks of all [bytes].
  static std::uint64_t bytesNeeded(const FrameSource& source, int layers);

  int rows() const { return grid_.counts()[0]; }

  const BlockGrid& grid() const { return grid_; }

  /// Reads row `row`. NaN and infinities are refused: the message names grid, frame, voxel and
  /// channel.
  [[nodiscard]] Status load(int row) { return load(row, 0, grid_.counts()[1]); }

  /// Of it the layers firstLayer <= z < endLayer, counted in blocks. What is loaded already is not
  /// read again.
  [[nodiscard]] Status load(int row, int firstLayer, int endLayer);

  /// Numbers of the blocks that hold something beside tiles, ascending, of what is loaded.
  std::span<const std::uint64_t> occupied() const { return occupied_; }

  /// Smallest and greatest value of all rows loaded so far.
  float minimum() const { return minimum_; }

  float maximum() const { return maximum_; }

  /// Facts about the support in the loaded row, frame by frame.
  std::span<const SupportFacts> facts() const { return facts_; }

  /// roundingOf() the source, of all that was loaded.
  double rounding() const { return roundingOf(source_); }

  /// Calls visit(value, 1, false) for each value of the support of what is loaded, for tiles
  /// visit(value, number of values, true).
  template <class Visit>
  void visitValues(const Visit& visit) const;

  /// What voxels hold that are valued and not active, of what is loaded.
  struct InactiveValue {
    bool any = false;
    bool several = false;  ///< not all the same
    std::array<float, 3> value{};

    void add(const InactiveValue& other);
  };

  InactiveValue inactiveValue() const;

  /// The tiles that begin in what is loaded, of its frame `frame`.
  std::vector<Bricks::Tile> tilesOf(int frame) const;

  /// The background of what was loaded last; all frames must have the same.
  const std::array<float, 3>& background() const { return background_; }

  /// Block `block` of what is loaded, shape extents x channels; `values` has room for exactly
  /// that. Thread-safe.
  void cut(std::size_t block, std::span<float> values, BlockStates& states) const;

 private:
  /// A leaf or a tile of a frame that reaches into a block.
  struct Piece {
    std::uint64_t block = 0;
    std::uint32_t frame = 0;  ///< of the row
    std::uint32_t at = 0;     ///< in the frame's leaves, or tiles
  };

  [[nodiscard]] Status index(int frame);
  void indexTiles(int frame);
  void noteRange();
  IndexBox boxOf(std::uint64_t block) const;
  IndexBox loadedBox() const;

  FrameSource& source_;
  BlockGrid grid_;
  std::vector<Bricks> frames_;
  std::vector<Piece> leaves_, tiles_;  // of all frames, in the order of blocks
  std::vector<std::uint64_t> occupied_;
  std::vector<SupportFacts> facts_;
  std::array<float, 3> background_{};
  float minimum_, maximum_;
  int row_ = -1, firstLayer_ = 0, endLayer_ = 0;  // that are loaded
};

template <class Visit>
void BlockRow::visitValues(const Visit& visit) const {
  const IndexBox box = loadedBox();
  const auto channels = static_cast<std::size_t>(grid_.channels());
  for (const Bricks& frame : frames_) {
    for (std::size_t i = 0; i < frame.leaves().size(); ++i) {
      const Bricks::Leaf& leaf = frame.leaves()[i];
      const BrickMask inside = maskInside(leaf.origin, box);
      const auto values = frame.values(i);
      for (std::size_t z = 0; z < inside.size(); ++z) {
        for (std::uint64_t left = leaf.valued[z] & inside[z]; left != 0; left &= left - 1) {
          const std::size_t voxel = 64 * z + static_cast<std::size_t>(std::countr_zero(left));
          for (std::size_t c = 0; c < channels; ++c)
            visit(values[c * Bricks::kVoxels + voxel], std::uint64_t{1}, false);
        }
      }
    }
    for (const Bricks::Tile& tile : frame.tiles()) {
      const IndexBox part = tile.box().intersection(box);
      if (part.empty())
        continue;
      const std::uint64_t voxels = voxelsIn(part);
      for (std::size_t c = 0; c < channels; ++c) visit(tile.value[c], voxels, true);
    }
  }
}

}  // namespace volute
