// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/codec/block_codec.hpp"
#include "volute/codec/byte_io.hpp"
#include "volute/codec/haar_transform.hpp"
#include "volute/codec/packing.hpp"

namespace volute {
namespace {

constexpr std::array<int, 4> kTierLevels{2, 1, 1, 1};
constexpr std::uint64_t kMaxEscape = std::uint64_t{1} << 53;
constexpr std::uint64_t kEscape = 255;

struct LevelRange {
  int begin, end;
};

// The levels of a block that a tier holds; empty when the block is too small to have any.
LevelRange levelsOfTier(const BlockShape& shape, std::size_t tier) {
  LevelRange range{0, 0};
  for (std::size_t i = 0; i <= tier; ++i) range = {range.end, range.end + kTierLevels[i]};
  const int levels = shape.levels();
  return {std::min(range.begin, levels), std::min(range.end, levels)};
}

// Level 0 stands at the origin; it is quantised like the level above it.
int strideExponent(const BlockShape& shape, int level) {
  return shape.levels() - std::max(level, 1) - 1;
}

double stepOf(const BlockShape& shape, int level, double step) {
  return std::ldexp(step, -2 * (strideExponent(shape, level) + 1));
}

std::size_t cellCount(const BlockShape& shape, int level) {
  return level == 0 ? 1 : HaarCells(shape.extents, strideExponent(shape, level)).count();
}

// visit(position, existing, part) for each cell of a level; level 0 is a cell with coefficient 0
// alone.
template <class Visit>
void visitCells(const BlockShape& shape, int level, const HaarCells& cells, const Visit& visit) {
  if (level > 0) {
    cells.visit(visit);
  } else {
    const double cell = std::ldexp(1.0, strideExponent(shape, 0) + 1);
    double part = 1;
    for (int side : shape.extents) part *= side / cell;
    visit(std::ptrdiff_t{0}, std::uint16_t{1}, part);
  }
}

HaarCells cellsOf(const BlockShape& shape, int level) {
  return {shape.extents, std::max(strideExponent(shape, level), 0)};
}

// The five planes of a segment, being read.
struct PlaneReaders {
  ByteReader cells{{}}, masksLow{{}}, masksHigh{{}}, values{{}}, escapes{{}};

  // The next quantised coefficient; false when there is none or it is too great.
  bool nextValue(std::int64_t& q) {
    std::uint64_t value = values.u8();
    if (value == kEscape) {
      const std::uint64_t more = escapes.varint();
      if (more > kMaxEscape)
        return false;
      value += more;
    }
    const std::uint64_t zigzag = value + 1;
    const auto magnitude = static_cast<std::int64_t>((zigzag + 1) / 2);
    q = zigzag % 2 != 0 ? -magnitude : magnitude;
    return values.ok() && escapes.ok();
  }
};

std::size_t bitsSet(std::span<const std::byte> bytes) {
  std::size_t count = 0;
  for (const std::byte byte : bytes)
    count += static_cast<std::size_t>(std::popcount(static_cast<unsigned>(byte)));
  return count;
}

// Cuts a segment's content into its planes; false when they do not fit it exactly. That each mask
// bit may be set and each escape is used is seen on the way through them.
bool cutPlanes(std::span<const std::byte> content, const BlockShape& shape, LevelRange levels,
               PlaneReaders& planes) {
  ByteReader in(content);
  std::size_t cellBytes = 0;
  std::size_t scalingBytes = 0;
  for (int level = levels.begin; level < levels.end; ++level) {
    cellBytes += (cellCount(shape, level) + 7) / 8 * shape.channels;
    if (level == 0)
      scalingBytes = cellBytes;
  }
  const auto cells = in.bytes(cellBytes);
  if (!in.ok())
    return false;
  const std::size_t scaling = bitsSet(cells.first(scalingBytes));
  const std::size_t masked = bitsSet(cells) - scaling;
  const auto low = in.bytes(masked);
  const auto high = in.bytes(masked);
  const auto values = in.bytes(scaling + bitsSet(low) + bitsSet(high));
  if (!in.ok())
    return false;
  planes = {ByteReader(cells), ByteReader(low), ByteReader(high), ByteReader(values),
            ByteReader(in.bytes(in.remaining()))};
  return true;
}

bool decodeLevel(PlaneReaders& planes, const BlockShape& shape, int level, double step,
                 std::span<float> plane) {
  const HaarCells cells = cellsOf(shape, level);
  constexpr double kLargest = std::numeric_limits<float>::max();
  const double levelStep = stepOf(shape, level, step);
  unsigned bits = 0;
  int left = 0;
  bool sound = true;
  visitCells(shape, level, cells, [&](std::ptrdiff_t position, std::uint16_t existing, double) {
    if (left == 0) {
      bits = planes.cells.u8();
      left = 8;
    }
    const bool set = bits & 1;
    bits >>= 1;
    --left;
    if (!set)
      return true;
    unsigned mask = 1;
    if (level > 0) {
      mask = planes.masksLow.u8();
      mask |= static_cast<unsigned>(planes.masksHigh.u8()) << 8;
    }
    sound = mask != 0 && (mask & ~static_cast<unsigned>(existing)) == 0;
    for (; sound && mask != 0; mask &= mask - 1) {
      std::int64_t q = 0;
      sound = planes.nextValue(q);
      const double value = std::clamp(static_cast<double>(q) * levelStep, -kLargest, kLargest);
      plane[static_cast<std::size_t>(position +
                                     cells.offset(static_cast<unsigned>(std::countr_zero(mask))))] =
          static_cast<float>(value);
    }
    return sound;
  });
  return sound && bits == 0;
}

bool decodeTier(std::span<const std::byte> content, const BlockShape& shape, std::size_t tier,
                int levelEnd, double step, std::span<float> coefficients) {
  const LevelRange levels = levelsOfTier(shape, tier);
  PlaneReaders planes;
  if (!cutPlanes(content, shape, levels, planes))
    return false;
  for (int level = levels.begin; level < std::min(levels.end, levelEnd); ++level) {
    for (int c = 0; c < shape.channels; ++c) {
      const auto plane = coefficients.subspan(c * shape.voxels(), shape.voxels());
      if (!decodeLevel(planes, shape, level, step, plane))
        return false;
    }
  }
  return levels.end > levelEnd ||
         (planes.values.remaining() == 0 && planes.escapes.remaining() == 0);
}

std::uint64_t maxContent(const BlockShape& shape, std::size_t tier) {
  constexpr std::uint64_t kBytesOfAValue = 1 + 8;  // the byte and the longest escape
  const LevelRange levels = levelsOfTier(shape, tier);
  std::uint64_t bytes = 0;
  for (int level = levels.begin; level < levels.end; ++level) {
    const std::uint64_t cells = cellCount(shape, level);
    bytes += (cells + 7) / 8 + cells * (2 + (level == 0 ? 1 : 15) * kBytesOfAValue);
  }
  return bytes * static_cast<std::uint64_t>(shape.channels);
}

class HaarDecoder final : public BlockDecoder {
 public:
  HaarDecoder(double step, const StreamInfo& stream) : step_(step), stream_(stream) {}

  std::span<const int> tierLevels() const override { return kTierLevels; }

  std::uint64_t maxSegmentBytes(const BlockShape& shape, std::size_t tier) const override {
    const std::uint64_t content = maxContent(shape, tier);
    return content == 0 ? 0 : 1 + content;
  }

  Status decode(Tiers tiers, int levels, const BlockShape& shape,
                std::span<float> values) const override {
    VOLUTE_ASSERT(values.size() == shape.values() && tiers.size() <= kTierLevels.size());
    const auto finish = [this](float value) {
      return std::min(stream_.valueMax,
                      std::max(stream_.valueMin, value));  // NaN becomes the minimum
    };
    if (empty(tiers)) {
      std::ranges::fill(values, finish(0));
      return {};
    }
    const std::size_t voxels = shape.voxels();
    std::vector<float> coefficients(values.size());
    for (std::size_t tier = 0; tier < tiers.size(); ++tier) {
      if (tiers[tier].empty() || levelsOfTier(shape, tier).begin >= levels)
        continue;
      VOLUTE_ASSIGN(const auto content, unpack(tiers[tier], maxContent(shape, tier)));
      if (!decodeTier(content, shape, tier, levels, step_, coefficients)) {
        return fail(ErrorCode::kInvalidData, "is malformed in tier {}", tier);
      }
    }
    for (std::size_t c = 0; c < static_cast<std::size_t>(shape.channels); ++c) {
      const auto plane = std::span(coefficients).subspan(c * voxels, voxels);
      haarInverse(plane, shape.extents);
      for (std::size_t i = 0; i < voxels; ++i) values[i * shape.channels + c] = finish(plane[i]);
    }
    return {};
  }

  Result<std::string> describe(Tiers tiers, const BlockShape&) const override {
    return empty(tiers) ? "empty" : "plain haar, 4 time levels";
  }

  double haarStep() const override { return step_; }

 private:
  static bool empty(Tiers tiers) {
    return std::ranges::all_of(tiers, [](const auto& tier) { return tier.empty(); });
  }

  double step_;
  StreamInfo stream_;
};

}  // namespace

Result<std::shared_ptr<const BlockDecoder>> openHaarDecoder(std::span<const std::byte> parameters,
                                                            const StreamInfo& stream) {
  ByteReader in(parameters);
  const double step = in.f64();
  if (!in.ok() || in.remaining() != 0 || !std::isfinite(step) || step <= 0)
    return fail(ErrorCode::kInvalidData, "the quantisation step is missing or impossible");
  return std::make_shared<const HaarDecoder>(step, stream);
}

}  // namespace volute
