// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/rounding_source.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include "volute/grid/bricks.hpp"

namespace volute {
namespace {

/// Of values that are not empty.
struct Range {
  /// Their middle is far from zero where it is more than so many times their distance from it away:
  /// an offset gives back three bits of a float at least.
  static constexpr double kFarOfRounded = 8;
  /// Of floats it gives back what a transform in float32 rounds: 2e-5 of their range there, and
  /// more the farther they are.
  static constexpr double kFarOfFloats = 32;

  /// Floats that are all the same so far need none, whatever comes: it may be endless.
  static constexpr std::uint64_t kEnough = std::uint64_t{1} << 26;

  bool ofFloats = false;
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  std::uint64_t read = 0;  ///< values, empty ones too

  void add(float value) {
    if (!std::isfinite(value))
      return;
    low = std::min<double>(low, value), high = std::max<double>(high, value);
  }

  double middle() const { return 0.5 * low + 0.5 * high; }

  /// A number near the middle that parts of a sequence mostly have in common, so that they can be
  /// joined as they are.
  double roundNumber() const {
    const double step = std::ldexp(1.0, std::ilogb(high - low) + 4);
    return step * std::round(middle() / step);
  }

  /// Whether no further values can lead to an offset.
  bool isSettled() const {
    return isNear(kFarOfRounded) || (ofFloats && !(low < high) && read > kEnough);
  }

  /// What is near stays so with any more values.
  bool isNear(double far) const {
    return low <= high && !(std::abs(middle()) > far * (0.5 * high - 0.5 * low));
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
  for (int first = 0; first < info.z && !range.isSettled(); first += together) {
    const int end = std::min(info.z, first + together);
    values.resize(layer * static_cast<std::size_t>(end - first));
    range.read += values.size();
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

std::string typeOfValues(const FrameSource& source) {
  const bool vectors = source.info().channels == 3;
  if (offsetOf(source) != 0)
    return vectors ? "vec3d" : "double";
  return vectors ? "vec3s" : "float";
}

Status settleOffset(FrameSource& source, Offsets which) {
  auto* rounds = dynamic_cast<RoundingSource*>(&source);
  if (which == Offsets::kNone || !rounds || !rounds->takesOffset() || rounds->offset() != 0 ||
      (which == Offsets::kOfRounded && !rounds->mayRound()))
    return {};
  Range range{.ofFloats = !rounds->mayRound()};
  for (int frame = 0; frame < source.info().frames; ++frame) {
    if (range.isSettled())
      return {};
    if (!source.hasTopology()) {
      VOLUTE_TRY(addLayers(source, frame, range));
      continue;
    }
    Bricks bricks;
    VOLUTE_TRY(source.readBricks(frame, bricks));
    addBricks(bricks, range);
    // Floats have one that is exact.
    for (std::size_t c = 0; !rounds->mayRound() && c < 3; ++c) {
      if (bricks.background()[c] != 0)
        range.add(bricks.background()[c]);
    }
  }
  const bool floats = rounds->rounding() == 0;
  // Floats that are all the same need nothing.
  if (!(range.low <= range.high) || (floats && (which != Offsets::kAll || range.low == range.high)))
    return {};
  if (!range.isNear(floats ? Range::kFarOfFloats : Range::kFarOfRounded))
    rounds->takeOffset(static_cast<float>(floats ? range.roundNumber() : range.middle()));
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
