// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/codec/block_codec.hpp"
#include "volute/codec/color_transform.hpp"
#include "volute/codec/contexts.hpp"
#include "volute/codec/subbands.hpp"
#include "volute/codec/symbol_tables.hpp"
#include "volute/wavelet/shape_adaptive.hpp"

// Codecs 2 and 3: what their readers and their writers share. docs/format.md, section 8.

namespace volute {

/// How many levels the tiers of codec 2 hold.
inline constexpr std::array<int, 3> kWaveletTiers{3, 1, 1};

/// How a block is transformed. Each block has the mode that costs it least.
struct BlockMode {
  bool shaped = false;  ///< with a lossless support, outside of which values are exactly 0
  Wavelet wavelet = Wavelet::kCdf97;
  int timeLevels = 4;  ///< 0, 1, 2 or 4 halvings of time, fewer where there is less to halve

  bool operator==(const BlockMode&) const = default;
};

/// "shaped cdf53, 4 time levels".
std::string describe(const BlockMode& mode);

/// "plain:cdf97:4" and the like.
std::string shortName(const BlockMode& mode);

/// Empty for other texts.
std::optional<BlockMode> blockModeByName(std::string_view name);

/// All of them.
std::span<const BlockMode> allBlockModes();

/// Their short names.
std::vector<std::string_view> blockModeNames();

/// What holds for all blocks of a stream.
struct WaveletParameters {
  /// Values are coded as multiples of 2^exponent, so that none of them is near a float's limits.
  int exponent = 0;
  double step = 1;  ///< quantisation step of a coefficient with synthesis norm 1, > 0; in units
  ColorTransform color;
  /// What a quantised magnitude m stands for: one, for 1; m + more for greater ones. In 1/256.
  int one = 256, more = 0;
  double maxError = 0;                ///< > 0: corrections keep every voxel within it
  bool extended = false;              ///< codec 3
  bool sparse = false;                ///< codec 3: blocks begin with their topology
  std::array<float, 3> background{};  ///< of what is empty
  /// What all voxels hold that are valued and not active, where that is one value: such voxels are
  /// not coded.
  std::optional<std::array<float, 3>> inactive{};
  /// Codec 3: values are coded as bent() ones if bendScale is above 0, which makes faint ones finer
  /// than strong ones.
  double bendScale = 0, bendOffset = 0;
  int blockFrames = BlockGrid::kSide;  ///< codec 3: 16, 8, 4, 2 or 1
  bool means = false;                  ///< codec 3: the index has the mean of each block
  double offset = 0;                   ///< codec 3: values are differences from it
  /// Values beyond are kept as they are, for a writer of codec 3.
  float outlierLow = -std::numeric_limits<float>::infinity();
  float outlierHigh = std::numeric_limits<float>::infinity();
  /// What a coefficient that is not zero costs, with its share of all zeros [bits], for a writer.
  double coefficientBits = 6;
  std::vector<std::byte> table;  ///< contextTable()
  Contexts contexts = untrainedContexts();
  /// Codec 3: cells are coded by symbols, from these tables, instead of by bits.
  bool bySymbols = false;
  std::vector<std::byte> symbolTable;  ///< volute::symbolTable()
  std::vector<SymbolEnds> symbols{};   ///< what it says
  SymbolPrices symbolPrices{};         ///< of them, for a writer

  /// The magnitude, in steps, that is shown for q.
  double shown(std::int32_t q) const {
    const int m = q < 0 ? -q : q;
    return m == 0 ? 0 : m == 1 ? one / 256.0 : m + more / 256.0;
  }

  bool bends() const { return bendScale > 0; }

  float bent(float value) const {
    const double half = 0.5 * bendOffset, size = std::abs(static_cast<double>(value));
    return static_cast<float>(
        std::copysign((std::sqrt(size + half * half) - half) / bendScale, value));
  }

  float unbent(float value) const {
    const double t = bendScale * std::abs(static_cast<double>(value));
    return static_cast<float>(std::copysign(t * (t + bendOffset), value));
  }

  /// 2^exponent.
  float unit() const { return std::ldexp(1.0f, exponent); }

  /// Distance between neighbouring corrections: a little less than twice maxError, which leaves
  /// room for rounding.
  double correctionStep() const { return maxError * 2 * (1 - 1.0 / 128); }

  /// Means of blocks as the index has them: (bent) values in sixteenths of a step.
  std::int64_t quantisedMean(double value) const {
    const double bentValue = bends() ? bent(static_cast<float>(value)) : value;
    constexpr double kGreatest = 1e15;
    return std::llround(std::clamp(bentValue * 16 / (step * unit()), -kGreatest, kGreatest));
  }

  float mean(std::int64_t quantised) const {
    constexpr double kLargest = std::numeric_limits<float>::max();
    const double value = static_cast<double>(quantised) / 16 * step * unit();
    const auto shown = static_cast<float>(std::clamp(value, -kLargest, kLargest));
    return bends() ? unbent(shown) : shown;
  }
};

std::vector<std::byte> writeParameters(const WaveletParameters& parameters, int channels);
[[nodiscard]] Result<WaveletParameters> readParameters(std::uint32_t codec,
                                                       std::span<const std::byte> bytes,
                                                       int channels);

/// The strides whose cells a tier holds, from `first` down to (not including) `end`; and whether it
/// is the one with the scaling coefficients.
struct TierStrides {
  int first = -1, end = -1;
  bool scaling = false;
};

/// @param levels  levels of the block to be decoded, from the coarsest.
TierStrides stridesOfTier(const BlockShape& shape, std::size_t tier, int levels);

/// A voxel whose values stand apart from the others', as they are.
struct Outlier {
  std::uint32_t voxel = 0;
  std::array<float, 3> value{};
};

/// Whether a voxel's values are coded, by coefficients or as an outlier.
inline bool isCoded(VoxelState state, const WaveletParameters& parameters) {
  return state == VoxelState::kActive || (state == VoxelState::kValued && !parameters.inactive);
}

/// Puts in what is known beside coefficients: the background, the value of inactive voxels, and
/// outliers. Codec 3.
void applyStates(std::span<const VoxelState> states, std::span<const Outlier> outliers,
                 const WaveletParameters& parameters, const StreamInfo& stream,
                 std::span<float> values);

/// Turns planes of dequantised coefficients into values, as a reader sees them before corrections:
/// inverse transform, colour, and what is known of the original: its range, and zeros outside of
/// the support. With `coarse` these are left out, since they would change the means that levels
/// are; then values stay within one range of the original's.
/// @param wanted  frames of `values` that are filled
void reconstruct(std::span<float> planes, std::span<const std::uint8_t> support,
                 const BlockMode& mode, const BlockShape& shape,
                 const WaveletParameters& parameters, const StreamInfo& stream, bool coarse,
                 std::span<float> values, FrameSpan wanted = {});

}  // namespace volute
