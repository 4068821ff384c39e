// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_row.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "volute/base/assert.hpp"
#include "volute/codec/parallel_try.hpp"

namespace volute {
namespace {

constexpr int kBlock = BlockGrid::kSide;

Status refuseValue(const VolumeInfo& info, int frame, const VoxelIndex& voxel, int channel,
                   float value) {
  return fail(
      ErrorCode::kInvalidData,
      Hint::set("not_finite", "inactive").so("takes such voxels for ones that are not there"),
      "grid '{}', frame {}, voxel ({}, {}, {}) in x, y, z, channel {}: the value is {}; "
      "only finite values can be compressed, replace it in the input",
      info.name, info.frameText(static_cast<std::size_t>(frame)), voxel[0], voxel[1], voxel[2],
      channel, std::isnan(value) ? "not a number" : "infinite");
}

/// The blocks along an axis that [begin, end) reaches into.
struct BlockRange {
  int first = 0, end = 0;

  BlockRange(std::int64_t begin, std::int64_t end_)
      : first(static_cast<int>(begin / kBlock)),
        end(static_cast<int>((end_ + kBlock - 1) / kBlock)) {}
};

}  // namespace

SupportFacts::SupportFacts()
    : least(std::numeric_limits<float>::infinity()),
      most(-std::numeric_limits<float>::infinity()) {}

void SupportFacts::add(float value) {
  least = std::min(least, value);
  most = std::max(most, value);
}

void SupportFacts::add(const SupportFacts& other) {
  least = std::min(least, other.least);
  most = std::max(most, other.most);
  voxels += other.voxels;
  tiles += other.tiles;
}

BlockRow::BlockRow(FrameSource& source)
    : source_(source),
      grid_(source.info()),
      minimum_(SupportFacts().least),
      maximum_(SupportFacts().most) {}

void BlockRow::cutBy(int frames) {
  grid_ = BlockGrid(source_.info(), frames);
  row_ = -1;
}

std::uint64_t BlockRow::occupiedBy(int frames) const {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    const auto part = [&](const Piece& piece) {
      return std::pair(piece.block, static_cast<int>(piece.frame) / frames);
    };
    count += i == 0 || part(leaves_[i]) != part(leaves_[i - 1]) ? 1 : 0;
  }
  return count;
}

std::uint64_t BlockRow::bytesNeeded(const FrameSource& source, int layers) {
  const VolumeInfo& info = source.info();
  const int z = std::min(info.z, layers * kBlock);
  const double share = static_cast<double>(z) / info.z;
  return static_cast<std::uint64_t>(share * static_cast<double>(source.brickBytes())) *
         static_cast<std::uint64_t>(std::min(info.frames, kBlock));
}

IndexBox BlockRow::loadedBox() const {
  const BlockGrid::Index4& volume = grid_.volumeExtents();
  return {{0, 0, firstLayer_ * kBlock},
          {volume[3], volume[2], std::min(volume[1], endLayer_ * kBlock)}};
}

IndexBox BlockRow::boxOf(std::uint64_t block) const {
  const BlockGrid::Index4 o = grid_.origin(block), e = grid_.extents(block);
  return {{o[3], o[2], o[1]}, {o[3] + e[3], o[2] + e[2], o[1] + e[1]}};
}

Status BlockRow::load(int row, int firstLayer, int endLayer) {
  if (row == row_ && firstLayer == firstLayer_ && endLayer == endLayer_)
    return {};
  row_ = -1;
  const VolumeInfo& info = source_.info();
  const int first = row * grid_.frames();
  const int frames = grid_.endOfRow(row) - first;
  firstLayer_ = firstLayer;
  endLayer_ = endLayer;
  const IndexBox box = loadedBox();
  frames_.resize(static_cast<std::size_t>(frames));
  facts_.assign(frames_.size(), {});
  leaves_.clear();
  tiles_.clear();
  row_ = row;  // for the numbers of blocks
  for (int i = 0; i < frames; ++i) {
    Bricks& frame = frames_[static_cast<std::size_t>(i)];
    auto status = source_.readBricks(first + i, static_cast<int>(box.begin[2]),
                                     static_cast<int>(box.end[2]), frame);
    if (status)
      status = index(i);
    if (!status) {
      row_ = -1;
      return status;
    }
    if (i == 0)
      background_ = frame.background();
    if (frame.background() != background_) {
      row_ = -1;
      return fail(ErrorCode::kInvalidData,
                  "grid '{}', frame {}: its background is {:.6g}, but {:.6g} in the frames before; "
                  "expected one background in all frames",
                  info.name, info.frameText(static_cast<std::size_t>(first + i)),
                  offsetOf(source_) + frame.background()[0], offsetOf(source_) + background_[0]);
    }
  }
  const auto order = [](const Piece& a, const Piece& b) {
    return std::tie(a.block, a.frame, a.at) < std::tie(b.block, b.frame, b.at);
  };
  std::ranges::sort(leaves_, order);
  occupied_.clear();
  for (const Piece& piece : leaves_) {
    if (occupied_.empty() || occupied_.back() != piece.block)
      occupied_.push_back(piece.block);
  }
  for (int i = 0; i < frames; ++i) indexTiles(i);
  std::ranges::sort(tiles_, order);
  noteRange();
  return {};
}

void BlockRow::noteRange() {
  SupportFacts all;
  for (const SupportFacts& frame : facts_) all.add(frame);
  if (all.voxels < voxelsIn(loadedBox()) * facts_.size()) {
    for (int c = 0; c < grid_.channels(); ++c) all.add(background_[static_cast<std::size_t>(c)]);
  }
  minimum_ = std::min(minimum_, all.least);
  maximum_ = std::max(maximum_, all.most);
}

// Looks at the values of a frame's leaves, and notes which blocks they reach into.
Status BlockRow::index(int frame) {
  const VolumeInfo& info = source_.info();
  const Bricks& bricks = frames_[static_cast<std::size_t>(frame)];
  const IndexBox box = loadedBox();
  const int firstFrame = row_ * grid_.frames();
  constexpr std::size_t kLeavesATask = 256;
  const std::size_t count = bricks.leaves().size();
  const std::size_t tasks = (count + kLeavesATask - 1) / kLeavesATask;
  std::vector<SupportFacts> facts(tasks);
  std::vector<std::vector<Piece>> pieces(tasks);
  VOLUTE_TRY(parallelTry(tasks, [&](std::size_t task) -> Status {
    for (std::size_t i = task * kLeavesATask; i < std::min(count, (task + 1) * kLeavesATask); ++i) {
      const Bricks::Leaf& leaf = bricks.leaves()[i];
      const BrickMask inside = maskInside(leaf.origin, box);
      const auto values = bricks.values(i);
      for (std::size_t z = 0; z < inside.size(); ++z) {
        const std::uint64_t here = leaf.valued[z] & inside[z];
        facts[task].voxels += static_cast<std::uint64_t>(std::popcount(here));
        for (std::uint64_t left = here; left != 0; left &= left - 1) {
          const int bit = std::countr_zero(left);
          for (int c = 0; c < info.channels; ++c) {
            const float value = values[static_cast<std::size_t>(c * Bricks::kVoxels) + 64 * z +
                                       static_cast<std::size_t>(bit)];
            if (!std::isfinite(value)) {
              return refuseValue(info, firstFrame + frame,
                                 {leaf.origin[0] + bit % 8, leaf.origin[1] + bit / 8,
                                  leaf.origin[2] + static_cast<std::int64_t>(z)},
                                 c, value);
            }
            facts[task].add(value);
          }
        }
      }
      const IndexBox reach = IndexBox{
          leaf.origin,
          {leaf.origin[0] + Bricks::kSide, leaf.origin[1] + Bricks::kSide,
           leaf.origin[2] +
               Bricks::kSide}}.intersection(box);
      if (reach.empty())
        continue;
      const BlockRange x(reach.begin[0], reach.end[0]), y(reach.begin[1], reach.end[1]),
          z(reach.begin[2], reach.end[2]);
      for (int bz = z.first; bz < z.end; ++bz)
        for (int by = y.first; by < y.end; ++by)
          for (int bx = x.first; bx < x.end; ++bx) {
            const std::uint64_t block = grid_.blockAt({row_, bz, by, bx});
            const BrickMask part = maskInside(leaf.origin, boxOf(block));
            bool any = false;
            for (std::size_t k = 0; k < part.size(); ++k)
              any = any || (part[k] & leaf.valued[k]) != 0;
            if (any)
              pieces[task].push_back(
                  {block, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(i)});
          }
    }
    return {};
  }));
  SupportFacts& all = facts_[static_cast<std::size_t>(frame)];
  for (std::size_t task = 0; task < tasks; ++task) {
    all.add(facts[task]);
    leaves_.insert(leaves_.end(), pieces[task].begin(), pieces[task].end());
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    const std::uint64_t voxels = voxelsIn(tile.box().intersection(box));
    all.voxels += voxels;
    all.tiles += voxels;
    for (int c = 0; c < info.channels; ++c) {
      const float value = tile.value[static_cast<std::size_t>(c)];
      if (!std::isfinite(value))
        return refuseValue(info, firstFrame + frame, tile.origin, c, value);
      if (voxels > 0)
        all.add(value);
    }
  }
  return {};
}

// The occupied blocks that a frame's tiles reach into.
void BlockRow::indexTiles(int frame) {
  const auto tiles = frames_[static_cast<std::size_t>(frame)].tiles();
  const IndexBox box = loadedBox();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const IndexBox reach = tiles[i].box().intersection(box);
    if (reach.empty())
      continue;
    const auto note = [&](std::uint64_t block) {
      tiles_.push_back({block, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(i)});
    };
    const BlockRange x(reach.begin[0], reach.end[0]), y(reach.begin[1], reach.end[1]),
        z(reach.begin[2], reach.end[2]);
    const double blocks = 1.0 * (x.end - x.first) * (y.end - y.first) * (z.end - z.first);
    if (blocks > static_cast<double>(occupied_.size())) {
      for (const std::uint64_t block : occupied_) {
        if (!boxOf(block).intersection(reach).empty())
          note(block);
      }
      continue;
    }
    for (int bz = z.first; bz < z.end; ++bz)
      for (int by = y.first; by < y.end; ++by)
        for (int bx = x.first; bx < x.end; ++bx) {
          const std::uint64_t block = grid_.blockAt({row_, bz, by, bx});
          if (std::ranges::binary_search(occupied_, block))
            note(block);
        }
  }
}

void BlockRow::InactiveValue::add(const InactiveValue& other) {
  if (!other.any)
    return;
  several = several || other.several || (any && value != other.value);
  value = other.value;
  any = true;
}

BlockRow::InactiveValue BlockRow::inactiveValue() const {
  const IndexBox box = loadedBox();
  const auto channels = static_cast<std::size_t>(grid_.channels());
  InactiveValue all;
  for (const Bricks& frame : frames_) {
    for (std::size_t i = 0; i < frame.leaves().size() && !all.several; ++i) {
      const Bricks::Leaf& leaf = frame.leaves()[i];
      const BrickMask inside = maskInside(leaf.origin, box);
      for (std::size_t z = 0; z < inside.size(); ++z) {
        for (std::uint64_t left = leaf.valued[z] & ~leaf.active[z] & inside[z]; left != 0;
             left &= left - 1) {
          InactiveValue one{true};
          for (std::size_t c = 0; c < channels; ++c)
            one.value[c] = frame.values(
                i)[c * Bricks::kVoxels + 64 * z + static_cast<std::size_t>(std::countr_zero(left))];
          all.add(one);
        }
      }
    }
  }
  return all;
}

std::vector<Bricks::Tile> BlockRow::tilesOf(int frame) const {
  const IndexBox box = loadedBox();
  const std::int64_t last = grid_.volumeExtents()[1] - 1;
  std::vector<Bricks::Tile> own;
  for (const Bricks::Tile& tile : frames_[static_cast<std::size_t>(frame)].tiles()) {
    const std::int64_t z = std::clamp<std::int64_t>(tile.origin[2], 0, last);
    if (z >= box.begin[2] && z < box.end[2])
      own.push_back(tile);
  }
  return own;
}

void BlockRow::cut(std::size_t block, std::span<float> values, BlockStates& states) const {
  const BlockGrid::Index4 extents = grid_.extents(block);
  const auto channels = static_cast<std::size_t>(grid_.channels());
  VOLUTE_ASSERT(values.size() == grid_.values(block));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = background_[i % channels];
  states.assign(values.size() / channels, VoxelState::kEmpty);
  const IndexBox box = boxOf(block);
  const auto placeOf = [&](std::uint32_t t, std::int64_t x, std::int64_t y, std::int64_t z) {
    return ((static_cast<std::size_t>(t) * static_cast<std::size_t>(extents[1]) +
             static_cast<std::size_t>(z - box.begin[2])) *
                static_cast<std::size_t>(extents[2]) +
            static_cast<std::size_t>(y - box.begin[1])) *
               static_cast<std::size_t>(extents[3]) +
           static_cast<std::size_t>(x - box.begin[0]);
  };
  const auto putTile = [&](std::uint32_t frame, const Bricks::Tile& tile) {
    const IndexBox part = tile.box().intersection(box);
    if (part.empty())
      return;
    for (std::int64_t z = part.begin[2]; z < part.end[2]; ++z)
      for (std::int64_t y = part.begin[1]; y < part.end[1]; ++y) {
        float* to = &values[placeOf(frame, part.begin[0], y, z) * channels];
        for (std::int64_t x = part.begin[0]; x < part.end[0]; ++x)
          to = std::copy_n(tile.value.begin(), channels, to);
      }
  };
  if (std::ranges::binary_search(occupied_, block)) {
    for (const Piece& piece : std::ranges::equal_range(tiles_, block, {}, &Piece::block))
      putTile(piece.frame, frames_[piece.frame].tiles()[piece.at]);
  } else {
    for (std::uint32_t frame = 0; frame < frames_.size(); ++frame)
      for (const Bricks::Tile& tile : frames_[frame].tiles()) putTile(frame, tile);
  }
  for (const Piece& piece : std::ranges::equal_range(leaves_, block, {}, &Piece::block)) {
    const Bricks& frame = frames_[piece.frame];
    const Bricks::Leaf& leaf = frame.leaves()[piece.at];
    const BrickMask inside = maskInside(leaf.origin, box);
    const auto from = frame.values(piece.at);
    for (std::size_t z = 0; z < inside.size(); ++z) {
      for (std::uint64_t left = leaf.valued[z] & inside[z]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const std::size_t place =
            placeOf(piece.frame, leaf.origin[0] + bit % 8, leaf.origin[1] + bit / 8,
                    leaf.origin[2] + static_cast<std::int64_t>(z));
        states[place] =
            (leaf.active[z] >> bit & 1) != 0 ? VoxelState::kActive : VoxelState::kValued;
        for (std::size_t c = 0; c < channels; ++c)
          values[place * channels + c] =
              from[c * Bricks::kVoxels + 64 * z + static_cast<std::size_t>(bit)];
      }
    }
  }
}

}  // namespace volute
