// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/rounding_source.hpp"

#include <cmath>
#include <limits>

#include "volute/grid/bricks.hpp"

namespace volute {
namespace {

/// Of values that are not empty.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(float value) {
    if (!std::isfinite(value))
      return;
    low = std::min<double>(low, value), high = std::max<double>(high, value);
  }
};

void addBricks(const Bricks& bricks, Range& range) {
  const auto channels = static_cast<std::size_t>(bricks.channels());
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
    const BrickMask& valued = bricks.leaves()[i].valued;
    const auto values = bricks.values(i);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t at = k % Bricks::kVoxels;
      if ((valued[at / 64] >> at % 64 & 1) != 0)
        range.add(values[k]);
    }
  }
  for (const Bricks::Tile& tile : bricks.tiles())
    for (std::size_t c = 0; c < channels; ++c) range.add(tile.value[c]);
}

/// Some layers of values at a time.
Status addLayers(FrameSource& source, int frame, Range& range) {
  constexpr std::size_t kValues = std::size_t{1} << 22;
  const VolumeInfo& info = source.info();
  const std::size_t layer = info.frameValues() / static_cast<std::size_t>(info.z);
  const int together = source.readsLayers()
                           ? static_cast<int>(std::clamp<std::size_t>(kValues / layer, 1, info.z))
                           : info.z;
  std::vector<float> values;
  for (int first = 0; first < info.z; first += together) {
    const int end = std::min(info.z, first + together);
    values.resize(layer * static_cast<std::size_t>(end - first));
    VOLUTE_TRY(source.readLayers(frame, first, end, values));
    for (const float value : values) {
      if (value != 0)
        range.add(value);
    }
  }
  return {};
}

}  // namespace

double roundingOf(const FrameSource& source) {
  const auto* rounds = dynamic_cast<const RoundingSource*>(&source);
  return rounds ? rounds->rounding() : 0;
}

double offsetOf(const FrameSource& source) {
  const auto* rounds = dynamic_cast<const RoundingSource*>(&source);
  return rounds ? rounds->offset() : 0;
}

Status settleOffset(FrameSource& source) {
  auto* rounds = dynamic_cast<RoundingSource*>(&source);
  if (!rounds || !rounds->takesOffset() || rounds->offset() != 0)
    return {};
  Range range;
  for (int frame = 0; frame < source.info().frames; ++frame) {
    if (!source.hasTopology()) {
      VOLUTE_TRY(addLayers(source, frame, range));
      continue;
    }
    Bricks bricks;
    VOLUTE_TRY(source.readBricks(frame, bricks));
    addBricks(bricks, range);
  }
  // Bits of a float that the offset gives back: three at least.
  constexpr double kFar = 8;
  const double middle = 0.5 * range.low + 0.5 * range.high;
  if (rounds->rounding() == 0 || !(std::abs(middle) > kFar * (0.5 * range.high - 0.5 * range.low)))
    return {};
  rounds->takeOffset(static_cast<float>(middle));
  return {};
}

Bricks raised(const Bricks& frame, double by) {
  const auto more = [by](float value) {
    return static_cast<float>(by + static_cast<double>(value));
  };
  const auto colour = [&](std::array<float, 3> value) {
    std::ranges::transform(value, value.begin(), more);
    return value;
  };
  Bricks all(frame.channels(), colour(frame.background()));
  all.reserve(frame.leaves().size(), frame.tiles().size());
  for (std::size_t i = 0; i < frame.leaves().size(); ++i)
    std::ranges::transform(frame.values(i), all.addLeaf(frame.leaves()[i]).begin(), more);
  for (Bricks::Tile tile : frame.tiles()) {
    tile.value = colour(tile.value);
    all.addTile(tile);
  }
  all.sort();
  return all;
}

}  // namespace volute
