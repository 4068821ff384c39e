// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/block_grid.hpp"
#include "volute/tree4d/quantised_subtree.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

/// Levels of the tree of a volume: 2^total covers its longest side; of these, `block` lie in a
/// block.
struct TreeLevels {
  int total = 1;
  int block = 1;
};

TreeLevels treeLevels(const VolumeInfo& info);

/// Makes a Tree4d from independent blocks, in any order and from any thread; holds the quantised
/// blocks only.
class TreeBuilder {
 public:
  /// Values are clamped to [minimum, maximum] when they are read.
  /// @param blocks  of BlockGrid(info), ascending, that will be added; all others are zero
  TreeBuilder(const VolumeInfo& info, std::vector<std::uint64_t> blocks, double step, float minimum,
              float maximum);

  /// One of them, shape (t, z, y, x, c). Each block once; different blocks may come from different
  /// threads.
  void addBlock(std::size_t block, std::span<const float> values);

  Tree4d finish();

 private:
  std::size_t slotOf(std::size_t block) const;
  void noteOccupied(std::size_t slot, std::span<const float> values);
  QuantisedSubtree buildUpperTree() const;
  std::vector<SubtreeLevel> joinLevels(const QuantisedSubtree& upper) const;

  VolumeInfo info_;
  BlockGrid grid_;
  int totalLevels_;
  int blockLevels_;
  double step_;
  float minimum_, maximum_;
  std::vector<std::uint64_t> numbers_;  // of the blocks that are added
  std::vector<QuantisedSubtree> blocks_;
  std::vector<std::vector<std::uint8_t>> blockOccupied_;  // per block: one a frame and brick of 8^3
  std::vector<std::vector<VoxelBox>>
      blockBoxes_;  // per block: one a frame, in voxels of the volume
};

}  // namespace volute
