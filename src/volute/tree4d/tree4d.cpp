// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/tree4d.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <numeric>

#include "volute/base/parallel.hpp"
#include "volute/tree4d/tree_layout.hpp"
#include "volute/tree4d/tree_node.hpp"
#include "volute/tree4d/tree_read.hpp"

namespace volute {
namespace {

constexpr int kMaxSide = BlockGrid::kSide;

template <class T>
std::size_t bytesOf(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

/// Calls body(z, y, x, values) for each block of frame t, from many threads: its first voxel and
/// its values, shape (channel, z, y, x), which are not set where no brick is occupied.
template <class Body>
std::uint64_t forEachBlockOf(const TreeData& data, int t, Body&& body) {
  const auto& n = data.entryCounts;
  const int side = 1 << data.entryLevels;
  const std::size_t count = static_cast<std::size_t>(n[1]) * n[2] * n[3];
  constexpr std::size_t kGrain = 8;
  std::atomic<std::uint64_t> visited{0};
  parallelRanges(count, kGrain, [&](std::size_t begin, std::size_t end) {
    alignas(64) float values[3 * kMaxSide * kMaxSide * kMaxSide];
    for (std::size_t i = begin; i < end; ++i) {
      const int z = static_cast<int>(i / n[3] / n[2]) * side;
      const int y = static_cast<int>(i / n[3] % n[2]) * side;
      const int x = static_cast<int>(i % n[3]) * side;
      bool any = false;
      for (int bz = z; bz < std::min(z + side, data.extents[1]); bz += BrickSlice::kSide)
        for (int by = y; by < std::min(y + side, data.extents[2]); by += BrickSlice::kSide)
          for (int bx = x; bx < std::min(x + side, data.extents[3]); bx += BrickSlice::kSide)
            any |= data.isOccupied(t, bz, by, bx);
      if (any)
        visited += readBlockSlice(data, data.entryAt(t, z, y, x), t, values);
      body(z, y, x, values);
    }
  });
  return visited;
}

/// The cube of `edge` voxels (less at the border) that begins at voxel (z, y, x), out of its
/// block's values.
BoxCopy boxOf(const TreeData& data, const float* block, int edge, int z, int y, int x,
              int channel) {
  const int side = 1 << data.entryLevels;
  const int mask = side - 1;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(side) * side;
  BoxCopy copy{};
  copy.from = block + channel * side * plane + (z & mask) * plane + (y & mask) * side + (x & mask);
  copy.fromRow = side;
  copy.fromPlane = plane;
  copy.depth = std::min(edge, data.extents[1] - z);
  copy.height = std::min(edge, data.extents[2] - y);
  copy.width = std::min(edge, data.extents[3] - x);
  return copy;
}

void fillZero(const BoxCopy& brick) {
  for (int z = 0; z < brick.depth; ++z)
    for (int y = 0; y < brick.height; ++y)
      for (int x = 0; x < brick.width; ++x)
        brick.to[z * brick.toPlane + y * brick.toRow + x * brick.toStep] = 0;
}

template <class Visit>
void forEachBrickIn(const TreeData& data, int side, int z, int y, int x, Visit&& visit) {
  for (int bz = z; bz < std::min(z + side, data.extents[1]); bz += BrickSlice::kSide)
    for (int by = y; by < std::min(y + side, data.extents[2]); by += BrickSlice::kSide)
      for (int bx = x; bx < std::min(x + side, data.extents[3]); bx += BrickSlice::kSide)
        visit(bz, by, bx);
}

}  // namespace

float Tree4d::value(int t, int z, int y, int x, int channel) const {
  return readValue(data_, {t, z, y, x}, channel);
}

void Tree4d::values(std::span<const std::array<int, 4>> voxels, std::span<float> values) const {
  readValues(data_, voxels, values);
}

double Tree4d::valueFromRoot(int t, int z, int y, int x, int channel) const {
  if (!data_.isOccupied(t, z, y, x))
    return 0;
  double value = data_.mean[channel];
  std::uint32_t node = data_.levels.back().firstNode;
  for (int l = static_cast<int>(data_.levels.size()) - 1; node != TreeData::kNoNode; --l) {
    const int o = (t >> l & 1) << 3 | (z >> l & 1) << 2 | (y >> l & 1) << 1 | (x >> l & 1);
    value += nodeDetail(data_, l, node, o, channel);
    node = childNode(data_, node, o);
  }
  return std::clamp<double>(value, data_.minimum, data_.maximum);
}

void Tree4d::extractFrame(int t, std::span<float> values) const {
  const int side = 1 << data_.entryLevels;
  const std::ptrdiff_t channels = data_.channels;
  auto place = [&](BoxCopy box, int z, int y, int x, int c) {
    box.toStep = channels;
    box.toRow = info_.x * channels;
    box.toPlane = info_.y * box.toRow;
    box.to = &values[z * box.toPlane + y * box.toRow + x * channels + c];
    return box;
  };
  forEachBlockOf(data_, t, [&](int z, int y, int x, const float* block) {
    bool full = true;
    forEachBrickIn(data_, side, z, y, x,
                   [&](int bz, int by, int bx) { full &= data_.isOccupied(t, bz, by, bx); });
    for (int c = 0; c < channels; ++c) {
      if (full) {
        copyValues(data_, place(boxOf(data_, block, side, z, y, x, c), z, y, x, c));
        continue;
      }
      forEachBrickIn(data_, side, z, y, x, [&](int bz, int by, int bx) {
        const BoxCopy box =
            place(boxOf(data_, block, BrickSlice::kSide, bz, by, bx, c), bz, by, bx, c);
        if (data_.isOccupied(t, bz, by, bx)) {
          copyValues(data_, box);
        } else {
          fillZero(box);
        }
      });
    }
  });
}

BrickSlice Tree4d::extractSlice(int t, std::uint64_t* nodesVisited) const {
  std::vector<BrickPlace> places;
  for (int bz = 0; bz < data_.bricks[0]; ++bz)
    for (int by = 0; by < data_.bricks[1]; ++by)
      for (int bx = 0; bx < data_.bricks[2]; ++bx) {
        if (data_.isOccupied(t, bz * BrickSlice::kSide, by * BrickSlice::kSide,
                             bx * BrickSlice::kSide))
          places.push_back({bx, by, bz});
      }
  BrickSlice slice(info_, places);
  const int side = 1 << data_.entryLevels;
  const std::uint64_t visited =
      forEachBlockOf(data_, t, [&](int z, int y, int x, const float* block) {
        forEachBrickIn(data_, side, z, y, x, [&](int bz, int by, int bx) {
          const std::int32_t at =
              slice.brickAt(bx / BrickSlice::kSide, by / BrickSlice::kSide, bz / BrickSlice::kSide);
          if (at == BrickSlice::kEmpty)
            return;
          for (int c = 0; c < data_.channels; ++c) {
            BoxCopy brick = boxOf(data_, block, BrickSlice::kSide, bz, by, bx, c);
            brick.toStep = 1;
            brick.toRow = BrickSlice::kSide;
            brick.toPlane = BrickSlice::kSide * BrickSlice::kSide;
            brick.to = slice.brick(at) + static_cast<std::ptrdiff_t>(c) * BrickSlice::kVoxels;
            copyValues(data_, brick);
          }
        });
      });
  if (nodesVisited != nullptr)
    *nodesVisited += visited;
  return slice;
}

Tree4d Tree4d::prefix(std::size_t nodes) const {
  std::vector<SubtreeLevel> levels = levelsOf(data_);
  std::size_t left = std::max<std::size_t>(nodes, 1);
  for (std::size_t l = levels.size(); l-- > 0;) {
    SubtreeLevel& level = levels[l];
    if (level.masks.size() <= left) {
      left -= level.masks.size();
      continue;
    }
    level.masks.resize(left);
    std::size_t coefficients = 0, parents = 0;
    for (std::uint16_t mask : level.masks) {
      coefficients +=
          static_cast<std::size_t>(std::popcount(static_cast<unsigned>(mask & 0xFFFEu))) *
          data_.channels;
      parents += mask & 1u;
    }
    level.coefficients.resize(coefficients);
    level.children.resize(parents);
    left = 0;
    // Parents forget the children that were cut off.
    SubtreeLevel& above = levels[l + 1];
    std::vector<std::uint16_t> kept;
    std::size_t parent = 0, child = 0;
    for (std::uint16_t& mask : above.masks) {
      if (!(mask & 1))
        continue;
      unsigned children = above.children[parent++];
      for (unsigned m = children; m != 0; m &= m - 1) {
        if (child++ >= level.masks.size())
          children &= ~(m & (0u - m));
      }
      if (children == 0) {
        mask &= 0xFFFEu;
      } else {
        kept.push_back(static_cast<std::uint16_t>(children));
      }
    }
    above.children = std::move(kept);
  }
  TreeData data;
  data.extents = data_.extents;
  data.channels = data_.channels;
  data.entryLevels = data_.entryLevels;
  data.step = data_.step;
  data.minimum = data_.minimum;
  data.maximum = data_.maximum;
  data.mean = data_.mean;
  data.entryCounts = data_.entryCounts;
  data.entries.resize(data_.entries.size());
  data.occupied = data_.occupied;
  data.bricks = data_.bricks;
  layOut(levels, data);
  enterBlocks(data);
  Tree4d tree(info_, std::move(data));
  tree.boxes_ = boxes_;
  return tree;
}

std::size_t Tree4d::nodeCount() const {
  return std::accumulate(
      data_.levels.begin(), data_.levels.end(), std::size_t{0},
      [](std::size_t sum, const TreeData::Level& level) { return sum + level.nodes; });
}

std::size_t Tree4d::memoryBytes() const {
  std::size_t bytes = sizeof(Tree4d) + bytesOf(data_.masks) + bytesOf(data_.groups) +
                      bytesOf(data_.childMasks) + bytesOf(data_.childBases) +
                      bytesOf(data_.levels) + bytesOf(data_.entries) + bytesOf(data_.occupied) +
                      bytesOf(boxes_);
  for (const TreeData::Level& level : data_.levels) {
    bytes += bytesOf(level.narrow8) + bytesOf(level.wide16) + bytesOf(level.escapeIndex) +
             bytesOf(level.escapeValue);
  }
  return bytes;
}

}  // namespace volute
