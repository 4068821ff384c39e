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

/// @param at  place in a frame
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
              info.name, info.frameText(frame), x, y, z, channel,
              std::isnan(value) ? "not a number" : "infinite");
}

}  // namespace

BlockRow::BlockRow(FrameSource& source)
    : source_(source),
      grid_(source.info()),
      minimum_(std::numeric_limits<float>::infinity()),
      maximum_(-std::numeric_limits<float>::infinity()) {}

std::uint64_t BlockRow::bytesNeeded(const VolumeInfo& info, int layers) {
  const auto z = static_cast<std::uint64_t>(std::min(info.z, layers * BlockGrid::kSide));
  return std::uint64_t{4} * (info.frameValues() / static_cast<std::uint64_t>(info.z)) * z *
         static_cast<std::uint64_t>(std::min(info.frames, BlockGrid::kSide));
}

std::uint64_t BlockRow::bytesNeeded(const VolumeInfo& info) {
  return bytesNeeded(info, BlockGrid(info).counts()[1]);
}

Status BlockRow::load(int row, int firstLayer, int endLayer) {
  if (row == row_ && firstLayer == firstLayer_ && endLayer == endLayer_)
    return {};
  row_ = -1;
  const VolumeInfo& info = source_.info();
  const int first = row * BlockGrid::kSide;
  const int frames = std::min(BlockGrid::kSide, info.frames - first);
  const int begin = firstLayer * BlockGrid::kSide;
  const int end = std::min(info.z, endLayer * BlockGrid::kSide);
  firstLayer_ = firstLayer;
  endLayer_ = endLayer;
  const std::size_t part =
      info.frameValues() / static_cast<std::size_t>(info.z) * static_cast<std::size_t>(end - begin);
  values_.resize(static_cast<std::size_t>(frames) * part);
  for (int i = 0; i < frames; ++i) {
    VOLUTE_TRY(
        source_.readLayers(first + i, begin, end,
                           std::span(values_).subspan(static_cast<std::size_t>(i) * part, part)));
  }
  VOLUTE_TRY(scan(first));
  row_ = row;
  return {};
}

Status BlockRow::scan(int firstFrame) {
  const VolumeInfo& info = source_.info();
  const std::size_t layerValues = info.frameValues() / static_cast<std::size_t>(info.z);
  const std::size_t before = layerValues * static_cast<std::size_t>(firstLayer_ * BlockGrid::kSide);
  const auto frames =
      static_cast<std::size_t>(std::min(BlockGrid::kSide, info.frames - firstFrame));
  const std::size_t frameValues = values_.size() / frames;
  std::vector<float> low(frames), high(frames);
  VOLUTE_TRY(parallelTry(frames, [&](std::size_t i) -> Status {
    const auto frame = std::span<const float>(values_).subspan(i * frameValues, frameValues);
    float least = frame[0], greatest = frame[0];
    for (std::size_t at = 0; at < frame.size(); ++at) {
      const float value = frame[at];
      if (!std::isfinite(value))
        return refuseValue(info, firstFrame + static_cast<int>(i), before + at, value);
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
  const int firstZ = firstLayer_ * BlockGrid::kSide;
  const int layers = std::min(volume[1], endLayer_ * BlockGrid::kSide) - firstZ;
  VOLUTE_ASSERT(values.size() == grid_.values(block));
  auto out = values.begin();
  for (int t = 0; t < extents[0]; ++t) {
    for (int z = 0; z < extents[1]; ++z) {
      for (int y = 0; y < extents[2]; ++y) {
        const std::size_t at =
            ((static_cast<std::size_t>(t) * layers + origin[1] - firstZ + z) * volume[2] +
             origin[2] + y) *
                volume[3] +
            origin[3];
        out = std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(at * channels), line, out);
      }
    }
  }
}

}  // namespace volute
