// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/brick_slice.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {

BrickSlice::BrickSlice(const VolumeInfo& info)
    : size_{info.x, info.y, info.z},
      bricks_{(info.x + kSide - 1) / kSide, (info.y + kSide - 1) / kSide,
              (info.z + kSide - 1) / kSide},
      channels_(info.channels),
      basis_(info.basis),
      bounds_(info.bounds),
      index_(static_cast<std::size_t>(bricks_[0]) * bricks_[1] * bricks_[2], kEmpty) {}

BrickSlice BrickSlice::fromDense(const VolumeInfo& info, std::span<const float> values) {
  BrickSlice slice(info);
  const int channels = info.channels;
  /// Calls visit(first value of a row of a brick, its number of voxels, z and y in the brick).
  const auto rowsOf = [&](int bx, int by, int bz, auto&& visit) {
    const int x = bx * kSide, columns = std::min(kSide, info.x - x);
    for (int z = bz * kSide; z < std::min((bz + 1) * kSide, info.z); ++z) {
      for (int y = by * kSide; y < std::min((by + 1) * kSide, info.y); ++y)
        visit(&values[((static_cast<std::size_t>(z) * info.y + y) * info.x + x) * channels],
              columns, z % kSide, y % kSide);
    }
  };
  const auto eachRowOfBricks = [&](auto&& body) {
    parallelFor(static_cast<std::size_t>(slice.bricks_[1]) * slice.bricks_[2],
                [&](std::size_t row) {
                  const int by = static_cast<int>(row) % slice.bricks_[1],
                            bz = static_cast<int>(row) / slice.bricks_[1];
                  for (int bx = 0; bx < slice.bricks_[0]; ++bx)
                    body(bx, by, bz, slice.index_[row * slice.bricks_[0] + bx]);
                });
  };
  eachRowOfBricks([&](int bx, int by, int bz, std::int32_t& stored) {
    bool empty = true;
    rowsOf(bx, by, bz, [&](const float* row, int columns, int, int) {
      empty = empty &&
              std::all_of(row, row + columns * channels, [](float value) { return value == 0; });
    });
    stored = empty ? kEmpty : 0;
  });
  std::int32_t count = 0;
  for (std::int32_t& stored : slice.index_) {
    if (stored != kEmpty)
      stored = count++;
  }
  slice.values_.resize(static_cast<std::size_t>(count) * kVoxels * channels);
  eachRowOfBricks([&](int bx, int by, int bz, std::int32_t& stored) {
    if (stored == kEmpty)
      return;
    float* brick = slice.values_.data() + static_cast<std::size_t>(stored) * kVoxels * channels;
    rowsOf(bx, by, bz, [&](const float* row, int columns, int z, int y) {
      for (int x = 0; x < columns; ++x) {
        for (int c = 0; c < channels; ++c)
          brick[c * kVoxels + (z * kSide + y) * kSide + x] = row[x * channels + c];
      }
    });
  });
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

float* BrickSlice::addBrick(int bx, int by, int bz) {
  std::int32_t& stored = index_[(static_cast<std::size_t>(bz) * bricks_[1] + by) * bricks_[0] + bx];
  VOLUTE_ASSERT(stored == kEmpty);
  stored = static_cast<std::int32_t>(storedBricks());
  values_.resize(values_.size() + static_cast<std::size_t>(kVoxels) * channels_);
  return values_.data() + static_cast<std::size_t>(stored) * kVoxels * channels_;
}

void BrickSlice::clear() {
  std::ranges::fill(index_, kEmpty);
  values_.clear();
}

void BrickSlice::assign(std::vector<std::int32_t> index, std::vector<float> values) {
  VOLUTE_ASSERT(index.size() == index_.size() && values.size() % (kVoxels * channels_) == 0);
  index_ = std::move(index);
  values_ = std::move(values);
}

}  // namespace volute
