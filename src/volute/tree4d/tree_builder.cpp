// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/tree_builder.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"
#include "volute/tree4d/tree_layout.hpp"

namespace volute {
namespace {

void extend(VoxelBox& box, const VoxelBox& other) {
  if (other.empty())
    return;
  if (box.empty()) {
    box = other;
    return;
  }
  for (int a = 0; a < 3; ++a) {
    box.begin[a] = std::min(box.begin[a], other.begin[a]);
    box.end[a] = std::max(box.end[a], other.end[a]);
  }
}

}  // namespace

TreeLevels treeLevels(const VolumeInfo& info) {
  constexpr int kBlockLevels = 4;  // of a block of 16
  const int longest = std::max({info.frames, info.z, info.y, info.x});
  int levels = 1;
  while ((1 << levels) < longest) ++levels;
  return {levels, std::min(levels, kBlockLevels)};
}

TreeBuilder::TreeBuilder(const VolumeInfo& info, std::vector<std::uint64_t> blocks, double step,
                         float minimum, float maximum)
    : info_(info),
      grid_(info),
      totalLevels_(treeLevels(info).total),
      blockLevels_(treeLevels(info).block),
      step_(step),
      minimum_(minimum),
      maximum_(maximum),
      numbers_(std::move(blocks)),
      blocks_(numbers_.size()),
      blockOccupied_(numbers_.size()),
      blockBoxes_(numbers_.size()) {}

std::size_t TreeBuilder::slotOf(std::size_t block) const {
  const auto found = std::ranges::lower_bound(numbers_, block);
  VOLUTE_ASSERT(found != numbers_.end() && *found == block);
  return static_cast<std::size_t>(found - numbers_.begin());
}

void TreeBuilder::addBlock(std::size_t block, std::span<const float> values) {
  VOLUTE_ASSERT(values.size() == grid_.values(block));
  const std::size_t slot = slotOf(block);
  noteOccupied(slot, values);
  blocks_[slot] =
      buildSubtree({grid_.extents(block), info_.channels, 0, blockLevels_}, values, {}, step_);
}

void TreeBuilder::noteOccupied(std::size_t slot, std::span<const float> values) {
  const std::size_t block = numbers_[slot];
  const auto e = grid_.extents(block);
  const auto origin = grid_.origin(block);
  constexpr int kBricks = BlockGrid::kSide / BrickSlice::kSide;
  auto& occupied = blockOccupied_[slot];
  auto& boxes = blockBoxes_[slot];
  occupied.assign(static_cast<std::size_t>(e[0]) * kBricks * kBricks * kBricks, 0);
  boxes.assign(e[0], {});
  std::size_t i = 0;
  for (int t = 0; t < e[0]; ++t)
    for (int z = 0; z < e[1]; ++z)
      for (int y = 0; y < e[2]; ++y)
        for (int x = 0; x < e[3]; ++x, i += info_.channels) {
          bool zero = true;
          for (int c = 0; c < info_.channels; ++c) zero &= values[i + c] == 0;
          if (zero)
            continue;
          occupied[((t * kBricks + z / BrickSlice::kSide) * kBricks + y / BrickSlice::kSide) *
                       kBricks +
                   x / BrickSlice::kSide] = 1;
          const int vz = origin[1] + z, vy = origin[2] + y, vx = origin[3] + x;
          extend(boxes[t], {{vz, vy, vx}, {vz + 1, vy + 1, vx + 1}});
        }
}

QuantisedSubtree TreeBuilder::buildUpperTree() const {
  const auto channels = static_cast<std::size_t>(info_.channels);
  if (totalLevels_ == blockLevels_ && !blocks_.empty()) {  // one block: its root is the root
    QuantisedSubtree upper;
    upper.mean = blocks_[0].mean;
    upper.leaves = {0};
    return upper;
  }
  std::vector<float> means(grid_.count() * channels, 0.0f);
  std::vector<std::uint8_t> hasNode(grid_.count(), 0);
  for (std::size_t slot = 0; slot < blocks_.size(); ++slot) {
    const QuantisedSubtree& block = blocks_[slot];
    if (block.mean.empty())  // never added
      continue;
    std::ranges::copy(block.mean,
                      means.begin() + static_cast<std::ptrdiff_t>(numbers_[slot] * channels));
    hasNode[numbers_[slot]] = block.empty ? 0 : 1;
  }
  return buildSubtree({grid_.counts(), info_.channels, blockLevels_, totalLevels_ - blockLevels_},
                      means, hasNode, step_);
}

std::vector<SubtreeLevel> TreeBuilder::joinLevels(const QuantisedSubtree& upper) const {
  std::vector<SubtreeLevel> levels(totalLevels_);
  std::ranges::copy(upper.levels, levels.begin() + blockLevels_);
  for (int l = 0; l < blockLevels_; ++l) {
    for (std::uint32_t block : upper.leaves) {
      const SubtreeLevel& part = blocks_[slotOf(block)].levels[l];
      levels[l].masks.insert(levels[l].masks.end(), part.masks.begin(), part.masks.end());
      levels[l].children.insert(levels[l].children.end(), part.children.begin(),
                                part.children.end());
      levels[l].coefficients.insert(levels[l].coefficients.end(), part.coefficients.begin(),
                                    part.coefficients.end());
    }
  }
  return levels;
}

Tree4d TreeBuilder::finish() {
  const QuantisedSubtree upper = buildUpperTree();
  TreeData data;
  data.extents = grid_.volumeExtents();
  data.channels = info_.channels;
  data.entryLevels = blockLevels_;
  data.step = static_cast<float>(step_);
  data.minimum = minimum_;
  data.maximum = maximum_;
  std::ranges::copy(upper.mean, data.mean.begin());
  layOut(joinLevels(upper), data);

  // A volume of a single block may have fewer than four levels; its one entry covers it all.
  data.entryCounts = totalLevels_ == blockLevels_ ? std::array<int, 4>{1, 1, 1, 1} : grid_.counts();
  data.entries.resize(static_cast<std::size_t>(data.entryCounts[0]) * data.entryCounts[1] *
                      data.entryCounts[2] * data.entryCounts[3]);
  enterBlocks(data);

  data.bricks = {(info_.z + BrickSlice::kSide - 1) / BrickSlice::kSide,
                 (info_.y + BrickSlice::kSide - 1) / BrickSlice::kSide,
                 (info_.x + BrickSlice::kSide - 1) / BrickSlice::kSide};
  const std::size_t frameBricks =
      static_cast<std::size_t>(data.bricks[0]) * data.bricks[1] * data.bricks[2];
  data.occupied.assign((frameBricks * info_.frames + 63) / 64, 0);
  std::vector<VoxelBox> boxes(info_.frames);
  constexpr int kBricks = BlockGrid::kSide / BrickSlice::kSide;
  for (std::size_t slot = 0; slot < numbers_.size(); ++slot) {
    const auto origin = grid_.origin(numbers_[slot]);
    for (std::size_t i = 0; i < blockOccupied_[slot].size(); ++i) {
      if (!blockOccupied_[slot][i])
        continue;
      const std::size_t t = origin[0] + i / (kBricks * kBricks * kBricks);
      const std::size_t z = origin[1] / BrickSlice::kSide + i / (kBricks * kBricks) % kBricks;
      const std::size_t y = origin[2] / BrickSlice::kSide + i / kBricks % kBricks;
      const std::size_t x = origin[3] / BrickSlice::kSide + i % kBricks;
      const std::size_t bit = ((t * data.bricks[0] + z) * data.bricks[1] + y) * data.bricks[2] + x;
      data.occupied[bit >> 6] |= std::uint64_t{1} << (bit & 63);
    }
    for (std::size_t t = 0; t < blockBoxes_[slot].size(); ++t)
      extend(boxes[origin[0] + t], blockBoxes_[slot][t]);
  }

  blocks_.clear();
  Tree4d tree(info_, std::move(data));
  tree.boxes_ = std::move(boxes);
  return tree;
}

}  // namespace volute
