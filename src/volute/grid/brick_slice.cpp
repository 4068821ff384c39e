// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/brick_slice.hpp"

#include <algorithm>
#include <map>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/bricks.hpp"

namespace volute {
namespace {

constexpr int kSliceSide = BrickSlice::kSide;

BrickPlace bricksOf(const VolumeInfo& info) {
  return {(info.x + kSliceSide - 1) / kSliceSide, (info.y + kSliceSide - 1) / kSliceSide,
          (info.z + kSliceSide - 1) / kSliceSide};
}

IndexBox voxelsOf(const VolumeInfo& info) {
  return {{0, 0, 0}, {info.x, info.y, info.z}};
}

/// Calls visit(place, voxels of the brick that are in `box`) for each brick of a box in the volume.
template <class Visit>
void forBricksIn(const IndexBox& box, Visit&& visit) {
  const auto first = [&](std::size_t axis) {
    return static_cast<int>(box.begin[axis] / kSliceSide);
  };
  const auto last = [&](std::size_t axis) {
    return static_cast<int>((box.end[axis] - 1) / kSliceSide);
  };
  for (int z = first(2); z <= last(2); ++z) {
    for (int y = first(1); y <= last(1); ++y) {
      for (int x = first(0); x <= last(0); ++x) {
        const VoxelIndex from{std::int64_t{x} * kSliceSide, std::int64_t{y} * kSliceSide,
                              std::int64_t{z} * kSliceSide};
        visit(BrickPlace{x, y, z},
              IndexBox{from, {from[0] + kSliceSide, from[1] + kSliceSide, from[2] + kSliceSide}}
                  .intersection(box));
      }
    }
  }
}

bool isWhole(const IndexBox& part) {
  return part.size(0) == kSliceSide && part.size(1) == kSliceSide && part.size(2) == kSliceSide;
}

bool isZero(const Bricks::Tile& tile, int channels) {
  return std::all_of(tile.value.begin(), tile.value.begin() + channels,
                     [](float value) { return value == 0; });
}

}  // namespace

BrickSlice::BrickSlice(const VolumeInfo& info) : BrickSlice(info, std::span<const BrickPlace>()) {}

BrickSlice::BrickSlice(const VolumeInfo& info, std::span<const BrickPlace> places)
    : size_{info.x, info.y, info.z},
      channels_(info.channels),
      basis_(info.basis),
      bounds_(info.bounds),
      firstUniform_(static_cast<std::int32_t>(places.size())),
      table_(bricksOf(info), places.size()),
      values_(places.size() * kVoxels * static_cast<std::size_t>(info.channels)) {
  entries_.reserve(places.size());
  for (const BrickPlace& place : places) {
    const auto number = static_cast<std::int32_t>(entries_.size());
    entries_.push_back({place, number});
    table_.set(place, number);
  }
}

std::size_t BrickSlice::expectAll() {
  const auto all = static_cast<std::size_t>(bricksX()) * bricksY() * bricksZ();
  table_ = BrickTable(table_.count(), all);
  return all;
}

void BrickSlice::addLayers(int first, std::span<const float> values) {
  const std::size_t line = static_cast<std::size_t>(size_[0]) * channels_;
  const int end = first + static_cast<int>(values.size() / (line * size_[1]));
  /// Calls visit(first value of a row of a brick, its number of voxels, z and y in the brick).
  const auto rowsOf = [&](const BrickPlace& place, auto&& visit) {
    const int x = place[0] * kSide, columns = std::min(kSide, size_[0] - x);
    for (int z = place[2] * kSide; z < std::min((place[2] + 1) * kSide, end); ++z) {
      for (int y = place[1] * kSide; y < std::min((place[1] + 1) * kSide, size_[1]); ++y)
        visit(&values[(static_cast<std::size_t>(z - first) * size_[1] + y) * line +
                      static_cast<std::size_t>(x) * channels_],
              columns, z % kSide, y % kSide);
    }
  };
  const int across = bricksY(), deep = (end - first + kSide - 1) / kSide;
  std::vector<std::vector<BrickPlace>> rows(static_cast<std::size_t>(across) * deep);
  parallelFor(rows.size(), [&](std::size_t row) {
    const int by = static_cast<int>(row) % across,
              bz = first / kSide + static_cast<int>(row) / across;
    for (int bx = 0; bx < bricksX(); ++bx) {
      bool empty = true;
      rowsOf({bx, by, bz}, [&](const float* from, int columns, int, int) {
        empty = empty && std::all_of(from, from + columns * channels_,
                                     [](float value) { return value == 0; });
      });
      if (!empty)
        rows[row].push_back({bx, by, bz});
    }
  });
  const std::size_t before = entries_.size();
  for (const auto& row : rows) {
    for (const BrickPlace& place : row) {
      const auto number = static_cast<std::int32_t>(entries_.size());
      entries_.push_back({place, number});
      table_.set(place, number);
    }
  }
  firstUniform_ = static_cast<std::int32_t>(entries_.size());
  values_.resize(entries_.size() * kVoxels * static_cast<std::size_t>(channels_));
  parallelRanges(entries_.size() - before, 16, [&](std::size_t begin, std::size_t last) {
    for (std::size_t i = before + begin; i < before + last; ++i) {
      float* to = brick(static_cast<std::int32_t>(i));
      rowsOf(entries_[i].place, [&](const float* row, int columns, int z, int y) {
        for (int x = 0; x < columns; ++x) {
          for (int c = 0; c < channels_; ++c)
            to[c * kVoxels + (z * kSide + y) * kSide + x] = row[x * channels_ + c];
        }
      });
    }
  });
}

BrickSlice BrickSlice::fromDense(const VolumeInfo& info, std::span<const float> values) {
  BrickSlice slice(info);
  slice.expectAll();
  slice.addLayers(0, values);
  return slice;
}

Result<BrickSlice> BrickSlice::fromLayers(const VolumeInfo& info, bool byLayers,
                                          const ReadLayers& read) {
  constexpr std::size_t kTogether = std::size_t{1} << 20;  // values
  BrickSlice slice(info);
  const std::size_t layer = info.frameValues() / static_cast<std::size_t>(info.z);
  const int some = std::max(1, static_cast<int>(kTogether / layer / kSide)) * kSide;
  const int together = byLayers ? std::min(some, info.z) : info.z;
  // Pages of it that nothing is written to take no memory, and nothing has to move.
  slice.values_.reserve(slice.expectAll() * kVoxels * static_cast<std::size_t>(info.channels));
  std::vector<float> values;
  for (int first = 0; first < info.z; first += together) {
    const int end = std::min(first + together, info.z);
    values.resize(static_cast<std::size_t>(end - first) * layer);
    VOLUTE_TRY(read(first, end, values));
    slice.addLayers(first, values);
  }
  return slice;
}

std::uint64_t BrickSlice::entriesOfTiles(const VolumeInfo& info, const Bricks& bricks) {
  std::uint64_t entries = 0;
  for (const Bricks::Tile& tile : bricks.tiles()) {
    const IndexBox part = tile.box().intersection(voxelsOf(info));
    if (part.empty() || isZero(tile, info.channels))
      continue;
    std::uint64_t count = 1;
    for (int axis = 0; axis < 3; ++axis)
      count *= static_cast<std::uint64_t>(part.size(axis)) / kSide + 2;
    entries += count;
  }
  return entries;
}

BrickSlice BrickSlice::fromBricks(const VolumeInfo& info, const Bricks& bricks) {
  VOLUTE_ASSERT(bricks.channels() == info.channels);
  const IndexBox whole = voxelsOf(info);
  const auto channels = static_cast<std::size_t>(info.channels);
  // Which bricks leaves and borders of tiles reach into, and which are of one value.
  const std::uint64_t tileEntries = entriesOfTiles(info, bricks);
  BrickTable found(bricksOf(info), 2 * bricks.leaves().size() + tileEntries);
  std::vector<BrickPlace> own;
  std::vector<Entry> uniform;
  std::map<std::array<float, 3>, std::int32_t> kinds;
  const auto need = [&](const BrickPlace& place) {
    if (found.at(place) == kEmpty) {
      found.set(place, 0);
      own.push_back(place);
    }
  };
  const auto boxOf = [&](const VoxelIndex& o) {
    return IndexBox{o, {o[0] + kSide, o[1] + kSide, o[2] + kSide}}.intersection(whole);
  };
  for (const Bricks::Leaf& leaf : bricks.leaves()) {
    if (const IndexBox part = boxOf(leaf.origin); !part.empty())
      forBricksIn(part, [&](const BrickPlace& place, const IndexBox&) { need(place); });
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    const IndexBox part = tile.box().intersection(whole);
    if (part.empty() || isZero(tile, info.channels))
      continue;
    const auto kind =
        kinds.try_emplace(tile.value, static_cast<std::int32_t>(kinds.size())).first->second;
    forBricksIn(part, [&](const BrickPlace& place, const IndexBox& inside) {
      if (isWhole(inside))
        uniform.push_back({place, kind});
      else
        need(place);
    });
  }
  std::ranges::sort(own, isBefore);
  BrickSlice slice(info, own);
  if (!uniform.empty()) {
    for (Entry& entry : uniform) {
      entry.stored += slice.firstUniform_;
      slice.table_.set(entry.place, entry.stored);
    }
    slice.values_.resize((own.size() + kinds.size()) * kVoxels * channels);
    for (const auto& [value, kind] : kinds) {
      for (std::size_t c = 0; c < channels; ++c)
        std::fill_n(slice.brick(slice.firstUniform_ + kind) + c * kVoxels, kVoxels, value[c]);
    }
    slice.entries_.insert(slice.entries_.end(), uniform.begin(), uniform.end());
    std::ranges::sort(slice.entries_, isBefore, &Entry::place);
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    const IndexBox part = tile.box().intersection(whole);
    if (part.empty() || isZero(tile, info.channels))
      continue;
    forBricksIn(part, [&](const BrickPlace& place, const IndexBox& inside) {
      if (isWhole(inside))
        return;
      float* to = slice.brick(slice.table_.at(place));
      for (auto z = inside.begin[2]; z < inside.end[2]; ++z) {
        for (auto y = inside.begin[1]; y < inside.end[1]; ++y) {
          for (std::size_t c = 0; c < channels; ++c)
            std::fill_n(to + c * kVoxels + ((z % kSide) * kSide + y % kSide) * kSide +
                            inside.begin[0] % kSide,
                        inside.size(0), tile.value[c]);
        }
      }
    });
  }
  // Leaves may lie across bricks: they share bricks, but no voxels.
  parallelRanges(bricks.leaves().size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const VoxelIndex& o = bricks.leaves()[i].origin;
      const IndexBox part = boxOf(o);
      if (part.empty())
        continue;
      const std::span<const float> from = bricks.values(i);
      forBricksIn(part, [&](const BrickPlace& place, const IndexBox& inside) {
        float* to = slice.brick(slice.table_.at(place));
        if (isWhole(inside)) {
          std::ranges::copy(from, to);
          return;
        }
        for (auto z = inside.begin[2]; z < inside.end[2]; ++z) {
          for (auto y = inside.begin[1]; y < inside.end[1]; ++y) {
            const auto there = static_cast<std::size_t>(((z - o[2]) * kSide + y - o[1]) * kSide +
                                                        inside.begin[0] - o[0]);
            const auto here = static_cast<std::size_t>(((z % kSide) * kSide + y % kSide) * kSide +
                                                       inside.begin[0] % kSide);
            for (std::size_t c = 0; c < channels; ++c)
              std::copy_n(&from[c * kVoxels + there], inside.size(0), to + c * kVoxels + here);
          }
        }
      });
    }
  });
  slice.dropEmpty();
  return slice;
}

std::size_t BrickSlice::placeOf(int vx, int vy, int vz) const {
  const std::int32_t stored = brickAt(vx / kSide, vy / kSide, vz / kSide);
  VOLUTE_ASSERT(stored != kEmpty);
  return static_cast<std::size_t>(stored) * kVoxels +
         static_cast<std::size_t>(((vz % kSide) * kSide + vy % kSide) * kSide + vx % kSide);
}

float BrickSlice::value(int vx, int vy, int vz, int channel) const {
  if (vx < 0 || vy < 0 || vz < 0 || vx >= size_[0] || vy >= size_[1] || vz >= size_[2])
    return 0;
  const std::int32_t stored = brickAt(vx / kSide, vy / kSide, vz / kSide);
  if (stored == kEmpty)
    return 0;
  return brick(
      stored)[channel * kVoxels + ((vz % kSide) * kSide + vy % kSide) * kSide + vx % kSide];
}

BrickSlice BrickSlice::halved(int channel) const {
  VolumeInfo info;
  info.x = (x() + 1) / 2, info.y = (y() + 1) / 2, info.z = (z() + 1) / 2;
  info.basis = basis_;
  const Vec3 voxel = bounds_.size().cwiseQuotient(Vec3(x(), y(), z()));
  const Vec3 size = 2 * voxel.cwiseProduct(Vec3(info.x, info.y, info.z));
  info.bounds = Box3{bounds_.min, bounds_.min + size};
  std::vector<BrickPlace> places;
  BrickTable found({bricksX() / 2 + 1, bricksY() / 2 + 1, bricksZ() / 2 + 1}, entries_.size());
  for (const Entry& entry : entries_) {
    const BrickPlace place{entry.place[0] / 2, entry.place[1] / 2, entry.place[2] / 2};
    if (found.at(place) < 0) {
      found.set(place, 0);
      places.push_back(place);
    }
  }
  std::ranges::sort(places, isBefore);
  BrickSlice half(info, places);
  constexpr int kHalf = kSide / 2;
  for (const Entry& entry : entries_) {
    const auto& [bx, by, bz] = entry.place;
    const int corner = ((bz % 2 * kSide + by % 2) * kSide + bx % 2) * kHalf;
    float* to = half.brick(half.brickAt(bx / 2, by / 2, bz / 2)) + corner;
    const float* from = brick(entry.stored) + channel * kVoxels;
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) to[(z / 2 * kSide + y / 2) * kSide + x / 2] += *from++ / 8;
  }
  return half;
}

BrickSlice BrickSlice::unshared() const {
  if (entries_.size() == storedBricks())
    return *this;
  VolumeInfo info;
  info.x = size_[0], info.y = size_[1], info.z = size_[2];
  info.channels = channels_, info.basis = basis_, info.bounds = bounds_;
  std::vector<BrickPlace> places;
  for (const Entry& entry : entries_) places.push_back(entry.place);
  BrickSlice slice(info, places);
  for (std::size_t i = 0; i < entries_.size(); ++i)
    std::copy_n(brick(entries_[i].stored), kVoxels * channels_,
                slice.brick(static_cast<std::int32_t>(i)));
  return slice;
}

std::vector<BrickPlace> BrickSlice::reached(const BrickPlace& count, BrickTable& table) const {
  table = BrickTable(count, entries_.size() + entries_.size() / 2);
  std::vector<BrickPlace> places;
  for (const Entry& entry : entries_) {
    for (int i = 0; i < 8; ++i) {
      const BrickPlace at{entry.place[0] + (i & 1), entry.place[1] + (i >> 1 & 1),
                          entry.place[2] + (i >> 2)};
      if (at[0] < count[0] && at[1] < count[1] && at[2] < count[2] && table.at(at) == kEmpty) {
        table.set(at, 0);
        places.push_back(at);
      }
    }
  }
  std::ranges::sort(places, isBefore);
  for (std::size_t i = 0; i < places.size(); ++i)
    table.set(places[i], static_cast<std::int32_t>(i));
  return places;
}

void BrickSlice::dropEmpty() {
  const std::size_t each = static_cast<std::size_t>(kVoxels) * channels_;
  std::vector<std::int32_t> number(storedBricks(), kEmpty);
  std::int32_t count = 0, uniformFrom = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (i == static_cast<std::size_t>(firstUniform_))
      uniformFrom = count;
    const float* from = brick(static_cast<std::int32_t>(i));
    if (std::all_of(from, from + each, [](float value) { return value == 0; }))
      continue;
    number[i] = count++;
    if (number[i] != static_cast<std::int32_t>(i))
      std::copy_n(from, each, brick(number[i]));
  }
  if (static_cast<std::size_t>(count) == number.size())
    return;
  firstUniform_ = static_cast<std::size_t>(firstUniform_) < number.size() ? uniformFrom : count;
  values_.resize(static_cast<std::size_t>(count) * each);
  for (Entry& entry : entries_) {
    entry.stored = number[static_cast<std::size_t>(entry.stored)];
    table_.set(entry.place, entry.stored);
  }
  std::erase_if(entries_, [](const Entry& entry) { return entry.stored == kEmpty; });
}

}  // namespace volute
