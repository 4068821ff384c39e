// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_row.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/codec/parallel_try.hpp"

namespace volute {
namespace {

Status refuseValue(const VolumeInfo& info, int frame, std::size_t at, float value) {
  const std::size_t channel = at % info.channels;
  const std::size_t voxel = at / info.channels;
  const std::size_t x = voxel % info.x;
  const std::size_t y = voxel / info.x % info.y;
  const std::size_t z = voxel / info.x / info.y;
  return fail(ErrorCode::kInvalidData,
              "grid '{}', frame {}, voxel ({}, {}, {}) in x, y, z, channel {}: the value is {}; "
              "only finite values can be "
              "compressed, replace it in the input",
              info.name, info.frameNumbers[frame], x, y, z, channel,
              std::isnan(value) ? "not a number" : "infinite");
}

}  // namespace

BlockRow::BlockRow(FrameSource& source)
    : source_(source),
      grid_(source.info()),
      minimum_(std::numeric_limits<float>::infinity()),
      maximum_(-std::numeric_limits<float>::infinity()) {}

std::uint64_t BlockRow::bytesNeeded(const VolumeInfo& info) {
  return std::uint64_t{4} * info.frameValues() * std::min(info.frames, BlockGrid::kSide);
}

Status BlockRow::load(int row) {
  const VolumeInfo& info = source_.info();
  const int first = row * BlockGrid::kSide;
  const int frames = std::min(BlockGrid::kSide, info.frames - first);
  const std::size_t frameValues = info.frameValues();
  values_.resize(frames * frameValues);
  for (int i = 0; i < frames; ++i) {
    VOLUTE_TRY(
        source_.readFrame(first + i, std::span(values_).subspan(i * frameValues, frameValues)));
  }
  return scan(first);
}

Status BlockRow::scan(int firstFrame) {
  const VolumeInfo& info = source_.info();
  const std::size_t frameValues = info.frameValues();
  const std::size_t frames = values_.size() / frameValues;
  std::vector<float> low(frames), high(frames);
  VOLUTE_TRY(parallelTry(frames, [&](std::size_t i) -> Status {
    const auto frame = std::span<const float>(values_).subspan(i * frameValues, frameValues);
    float least = frame[0], greatest = frame[0];
    for (std::size_t at = 0; at < frame.size(); ++at) {
      const float value = frame[at];
      if (!std::isfinite(value))
        return refuseValue(info, firstFrame + static_cast<int>(i), at, value);
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
    low[i] = least;
    high[i] = greatest;
    return {};
  }));
  minimum_ = std::min(minimum_, *std::ranges::min_element(low));
  maximum_ = std::max(maximum_, *std::ranges::max_element(high));
  return {};
}

void BlockRow::cut(std::size_t block, std::span<float> values) const {
  const BlockGrid::Index4 origin = grid_.origin(block);
  const BlockGrid::Index4 extents = grid_.extents(block);
  const BlockGrid::Index4& volume = grid_.volumeExtents();
  const auto channels = static_cast<std::size_t>(grid_.channels());
  const std::size_t line = extents[3] * channels;
  VOLUTE_ASSERT(values.size() == grid_.values(block));
  auto out = values.begin();
  for (int t = 0; t < extents[0]; ++t) {
    for (int z = 0; z < extents[1]; ++z) {
      for (int y = 0; y < extents[2]; ++y) {
        const std::size_t at =
            ((static_cast<std::size_t>(t) * volume[1] + origin[1] + z) * volume[2] + origin[2] +
             y) *
                volume[3] +
            origin[3];
        out = std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(at * channels), line, out);
      }
    }
  }
}

}  // namespace volute
