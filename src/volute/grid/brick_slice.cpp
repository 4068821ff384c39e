// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/brick_slice.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"

namespace volute {

BrickSlice::BrickSlice(const VolumeInfo& info)
    : size_{info.x, info.y, info.z},
      bricks_{(info.x + kSide - 1) / kSide, (info.y + kSide - 1) / kSide, (info.z + kSide - 1) / kSide},
      channels_(info.channels),
      basis_(info.basis),
      bounds_(info.bounds),
      index_(static_cast<std::size_t>(bricks_[0]) * bricks_[1] * bricks_[2], kEmpty) {}

BrickSlice BrickSlice::fromDense(const VolumeInfo& info, std::span<const float> values) {
  BrickSlice slice(info);
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x) {
        for (int c = 0; c < info.channels; ++c) {
          const float value = values[((static_cast<std::size_t>(z) * info.y + y) * info.x + x) * info.channels + c];
          if (value == 0) continue;
          const std::int32_t stored = slice.brickAt(x / kSide, y / kSide, z / kSide);
          float* brick = stored == kEmpty
                             ? slice.addBrick(x / kSide, y / kSide, z / kSide)
                             : slice.values_.data() + static_cast<std::size_t>(stored) * kVoxels * slice.channels_;
          brick[c * kVoxels + ((z % kSide) * kSide + y % kSide) * kSide + x % kSide] = value;
        }
      }
    }
  }
  return slice;
}

float BrickSlice::value(int vx, int vy, int vz, int channel) const {
  if (vx < 0 || vy < 0 || vz < 0 || vx >= size_[0] || vy >= size_[1] || vz >= size_[2]) return 0;
  const std::int32_t stored = brickAt(vx / kSide, vy / kSide, vz / kSide);
  if (stored == kEmpty) return 0;
  return brick(stored)[channel * kVoxels + ((vz % kSide) * kSide + vy % kSide) * kSide + vx % kSide];
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
