// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/wavelet_codec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/codec/byte_io.hpp"

namespace volute {
namespace {

constexpr std::array kTimeLevels{0, 1, 2, 4};
constexpr std::array kWavelets{Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97};

// What the parameters of codec 3 begin with.
constexpr int kHasInactive = 1, kBent = 2, kBySymbols = 4, kWithoutTopology = 8, kMore = 16;
// What a second byte says, where kMore is set: halvings of the frames of a block, and more.
constexpr int kFrameHalvings = 7, kMeans = 8, kHasOffset = 16;

bool within(double value, double least, double most) {
  return value >= least && value <= most;
}

}  // namespace

std::string describe(const BlockMode& mode) {
  return fmt::format("{} {}, {} time level{}", mode.shaped ? "shaped" : "plain",
                     waveletName(mode.wavelet), mode.timeLevels, mode.timeLevels == 1 ? "" : "s");
}

std::string shortName(const BlockMode& mode) {
  return fmt::format("{}:{}:{}", mode.shaped ? "shaped" : "plain", waveletName(mode.wavelet),
                     mode.timeLevels);
}

std::optional<BlockMode> blockModeByName(std::string_view name) {
  for (const BlockMode& mode : allBlockModes()) {
    if (name == shortName(mode))
      return mode;
  }
  return std::nullopt;
}

std::span<const BlockMode> allBlockModes() {
  static const std::vector<BlockMode> modes = [] {
    std::vector<BlockMode> all;
    for (bool shaped : {false, true})
      for (Wavelet wavelet : kWavelets)
        for (int timeLevels : kTimeLevels) all.push_back({shaped, wavelet, timeLevels});
    return all;
  }();
  return modes;
}

std::vector<std::byte> writeParameters(const WaveletParameters& parameters, int channels) {
  ByteWriter out;
  if (parameters.extended || parameters.sparse) {
    const int more = std::countr_zero(static_cast<unsigned>(BlockGrid::kSide)) -
                     std::countr_zero(static_cast<unsigned>(parameters.blockFrames)) +
                     (parameters.means ? kMeans : 0) + (parameters.offset != 0 ? kHasOffset : 0);
    out.u8(static_cast<std::uint8_t>(
        (parameters.inactive ? kHasInactive : 0) | (parameters.bends() ? kBent : 0) |
        (parameters.bySymbols ? kBySymbols : 0) | (parameters.sparse ? 0 : kWithoutTopology) |
        (more != 0 ? kMore : 0)));
    if (more != 0)
      out.u8(static_cast<std::uint8_t>(more));
    if (parameters.offset != 0)
      out.f64(parameters.offset);
    for (int c = 0; c < channels; ++c) out.f32(parameters.background[static_cast<std::size_t>(c)]);
    for (int c = 0; parameters.inactive && c < channels; ++c)
      out.f32((*parameters.inactive)[static_cast<std::size_t>(c)]);
    if (parameters.bends())
      out.f64(parameters.bendScale), out.f64(parameters.bendOffset);
  }
  out.zigzag(parameters.exponent);
  out.f64(parameters.step);
  out.f64(parameters.maxError);
  out.varint(static_cast<std::uint64_t>(parameters.one));
  out.zigzag(parameters.more);
  if (channels == 3) {
    for (float value : parameters.color.rows) out.f32(value);
  }
  if (parameters.bySymbols)
    out.varint(parameters.table.size());
  out.bytes(parameters.table);
  if (parameters.bySymbols)
    out.bytes(parameters.symbolTable);
  return out.take();
}

Result<WaveletParameters> readParameters(std::uint32_t codec, std::span<const std::byte> bytes,
                                         int channels) {
  constexpr std::uint64_t kMaxTableBytes = 4 * context::kCount + 64 * symbol::kCount;
  WaveletParameters parameters;
  ByteReader in(bytes);
  parameters.extended = codec == kSparseCodec;
  bool finite = true;
  const auto readColour = [&](std::array<float, 3>& value) {
    for (int c = 0; c < channels; ++c) {
      value[static_cast<std::size_t>(c)] = in.f32();
      finite = finite && std::isfinite(value[static_cast<std::size_t>(c)]);
    }
  };
  if (parameters.extended) {
    const int flags = in.u8();
    const int more = (flags & kMore) != 0 ? in.u8() : 0;
    const int halvings = more & kFrameHalvings;
    finite = flags < 2 * kMore && more < 2 * kHasOffset && (BlockGrid::kSide >> halvings) > 0;
    parameters.blockFrames = std::max(BlockGrid::kSide >> halvings, 1);
    parameters.means = (more & kMeans) != 0;
    if ((more & kHasOffset) != 0) {
      constexpr double kLargest = std::numeric_limits<float>::max();
      parameters.offset = in.f64();
      finite = finite && within(std::abs(parameters.offset), 1e-300, kLargest);
    }
    parameters.bySymbols = (flags & kBySymbols) != 0;
    parameters.sparse = (flags & kWithoutTopology) == 0;
    readColour(parameters.background);
    if ((flags & kHasInactive) != 0)
      readColour(parameters.inactive.emplace());
    if ((flags & kBent) != 0) {
      parameters.bendScale = in.f64();
      parameters.bendOffset = in.f64();
      finite = finite && within(parameters.bendScale, 1e-30, 1e30) &&
               within(parameters.bendOffset, 0, 1e30);
    }
  }
  const std::int64_t exponent = in.zigzag();
  parameters.step = in.f64();
  parameters.maxError = in.f64();
  const std::uint64_t one = in.varint();
  const std::int64_t more = in.zigzag();
  bool orthonormal = true;
  if (channels == 3) {
    for (float& value : parameters.color.rows) {
      value = in.f32();
      orthonormal = orthonormal && within(value, -1.001, 1.001);
    }
  }
  if (!in.ok() || !finite || !within(static_cast<double>(exponent), -126, 127) ||
      !(parameters.step > 0) || !std::isfinite(parameters.step) ||
      !within(parameters.maxError, 0, 1e38) || !within(static_cast<double>(one), 1, 512) ||
      !within(static_cast<double>(more), -255, 255) || !orthonormal ||
      in.remaining() > kMaxTableBytes) {
    return fail(ErrorCode::kInvalidData, "parameters of its codec that are missing or impossible");
  }
  parameters.exponent = static_cast<int>(exponent);
  parameters.one = static_cast<int>(one);
  parameters.more = static_cast<int>(more);
  const auto table = in.bytes(parameters.bySymbols ? in.varint() : in.remaining());
  if (!in.ok())
    return fail(ErrorCode::kInvalidData, "parameters whose tables are longer than they are");
  parameters.table.assign(table.begin(), table.end());
  parameters.contexts = contextsOf(table);
  if (parameters.bySymbols) {
    const auto symbols = in.bytes(in.remaining());
    parameters.symbolTable.assign(symbols.begin(), symbols.end());
    parameters.symbols = symbolsOfTable(symbols);
  }
  return parameters;
}

TierStrides stridesOfTier(const BlockShape& shape, std::size_t tier, int levels) {
  int begin = 0;
  for (std::size_t i = 0; i < tier; ++i) begin += kWaveletTiers[i];
  const int end = std::min({begin + kWaveletTiers[tier], levels, shape.levels()});
  // Level i has the stride of exponent (number of levels) - 1 - i; level 0 is the scaling.
  return {shape.levels() - 1 - std::max(begin, 1), shape.levels() - 1 - std::max(end, 1),
          begin == 0};
}

void reconstruct(std::span<float> planes, std::span<const std::uint8_t> support,
                 const BlockMode& mode, const BlockShape& shape,
                 const WaveletParameters& parameters, const StreamInfo& stream, bool coarse,
                 std::span<float> all, FrameSpan wanted) {
  const std::size_t allVoxels = shape.voxels();
  const AxisLevels levels = blockLevels(shape.extents, mode.timeLevels);
  for (int c = 0; c < shape.channels; ++c)
    shapeInverse(planes.subspan(c * allVoxels, allVoxels), support, shape.extents, mode.wavelet,
                 levels, wanted.first, wanted.end);
  const std::size_t slab = allVoxels / static_cast<std::size_t>(shape.extents[0]);
  const std::size_t begin = static_cast<std::size_t>(wanted.first) * slab;
  const std::size_t voxels =
      static_cast<std::size_t>(std::min(wanted.end, shape.extents[0]) - wanted.first) * slab;
  const auto channels = static_cast<std::size_t>(shape.channels);
  const std::span<float> values = all.subspan(begin * channels, voxels * channels);
  if (!support.empty())
    support = support.subspan(begin, voxels);
  // Of one channel in one go with what follows.
  const bool direct = shape.channels == 1 && !parameters.bends();
  const float* from = direct ? planes.data() + begin : values.data();
  const float unit = direct ? parameters.unit() : 1;
  if (!direct)
    parameters.color.merge(planes, shape.channels, parameters.unit(), all);
  if (parameters.bends()) {
    for (float& value : values) value = parameters.unbent(value);
  }
  // NaN, which only a damaged file can make, becomes the minimum.
  constexpr float kLargest = std::numeric_limits<float>::max();
  const float range = std::min(stream.valueMax / 2 - stream.valueMin / 2, kLargest / 4);
  const float low = coarse ? std::max(stream.valueMin, -kLargest / 2) - 2 * range : stream.valueMin;
  const float high = coarse ? std::min(stream.valueMax, kLargest / 2) + 2 * range : stream.valueMax;
  const auto clamped = [=](float value) {
    const float least = low < value ? value : low;
    return high < least ? high : least;
  };
  // By sixteens, which compilers make vectors of.
  constexpr std::size_t kMany = 16;
  std::size_t i = 0;
  for (; i + kMany <= values.size(); i += kMany) {
    float some[kMany];
    for (std::size_t j = 0; j < kMany; ++j) some[j] = from[i + j] * unit;
    for (float& value : some) value = clamped(value);
    for (std::size_t j = 0; j < kMany; ++j) values[i + j] = some[j];
  }
  for (; i < values.size(); ++i) values[i] = clamped(from[i] * unit);
  if (support.empty() || coarse)
    return;
  const float outside = std::min(stream.valueMax, std::max(stream.valueMin, 0.0f));
  if (shape.channels == 1) {
    for (std::size_t v = 0; v < voxels; ++v) values[v] = support[v] != 0 ? values[v] : outside;
  } else {
    for (std::size_t i = 0; i < voxels; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        values[3 * i + c] = support[i] != 0 ? values[3 * i + c] : outside;
  }
}

void applyStates(std::span<const VoxelState> states, std::span<const Outlier> outliers,
                 const WaveletParameters& parameters, const StreamInfo& stream,
                 std::span<float> values) {
  const auto channels = static_cast<std::size_t>(stream.channels);
  if (channels == 1) {
    // Selections instead of branches: edges are anywhere.
    const float empty = parameters.background[0];
    const float valued = parameters.inactive ? (*parameters.inactive)[0] : 0;
    const bool codesValued = isCoded(VoxelState::kValued, parameters);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const float own = values[i];
      const float other = states[i] == VoxelState::kValued ? (codesValued ? own : valued) : empty;
      values[i] = states[i] == VoxelState::kActive ? own : other;
    }
  }
  for (std::size_t i = 0; channels > 1 && i < states.size(); ++i) {
    if (isCoded(states[i], parameters))
      continue;
    const auto& value =
        states[i] == VoxelState::kEmpty ? parameters.background : *parameters.inactive;
    std::copy_n(value.begin(), channels,
                values.begin() + static_cast<std::ptrdiff_t>(i * channels));
  }
  for (const Outlier& outlier : outliers) {
    for (std::size_t c = 0; c < channels; ++c) {
      const float value = outlier.value[c];
      const float least = stream.valueMin < value ? value : stream.valueMin;
      values[outlier.voxel * channels + c] = stream.valueMax < least ? stream.valueMax : least;
    }
  }
}

std::vector<std::string_view> blockModeNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const BlockMode& mode : allBlockModes()) all.push_back(shortName(mode));
    return all;
  }();
  return {names.begin(), names.end()};
}

}  // namespace volute
