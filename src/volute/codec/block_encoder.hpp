// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "volute/codec/wavelet_codec.hpp"

namespace volute {

/// What blocks of 16, 8 and 4 frames would cost, by an estimate, in 1/256 bits beyond what the
/// shortest ones must have; and what those of 16 took.
struct LengthCosts {
  static constexpr std::array<int, 3> kFrames{16, 8, 4};
  std::array<std::int64_t, kFrames.size()> costs{};
  std::int64_t blocks = 0, bits = 0;
};

/// What a pass over blocks teaches about a stream: its contexts, and what quantised magnitudes
/// stand for. Whole numbers, so the order of blocks does not matter.
struct Training {
  ContextCounts counts;
  SymbolCounts symbols;  ///< of cells that are coded by symbols; else empty
  /// Magnitudes quantised to 1, and to more (less what they were quantised to), in 1/65536.
  std::int64_t oneSum = 0, oneCount = 0, moreSum = 0, moreCount = 0;
  std::int64_t bits = 0;  ///< of all, without topology and outliers
  LengthCosts lengths;    ///< of blocks that were asked for them

  /// All of the sums.
  std::array<std::int64_t*, 10> sums() {
    return {&oneSum,         &oneCount,         &moreSum,          &moreCount,
            &bits,           &lengths.costs[0], &lengths.costs[1], &lengths.costs[2],
            &lengths.blocks, &lengths.bits};
  }

  std::array<const std::int64_t*, 10> sums() const {
    return {&oneSum,         &oneCount,         &moreSum,          &moreCount,
            &bits,           &lengths.costs[0], &lengths.costs[1], &lengths.costs[2],
            &lengths.blocks, &lengths.bits};
  }

  void add(const Training& other);

  /// Puts what was learnt into the parameters.
  void apply(WaveletParameters& parameters) const;
};

/// How the mode of a block is looked for.
struct ModeChoice {
  std::span<const BlockMode> candidates;
  /// The first ones to be tried; from the best of them on only what is beside it, as
  /// ModeSearch::descend() does. Without any, all candidates are.
  std::span<const BlockMode> starts{};
  /// So many of those that an estimate from the sizes of the coefficients finds cheapest are coded
  /// to know; 0: the estimate decides; kAll: each is coded.
  int coded = kAll;

  static constexpr int kAll = 99;
};

/// A block that is to be encoded: its voxels, and what of them is coded by coefficients.
struct BlockContent {
  BlockShape shape;
  std::span<const float> values;
  std::span<const VoxelState> states;   ///< what its voxels are; of codec 3 alone
  std::vector<float> planes{};          ///< of each component, bent, without outliers
  std::vector<std::uint8_t> support{};  ///< voxels that coefficients are needed for
  bool full = false;                    ///< all of them
  std::vector<Outlier> outliers{};
  double costOfNothing = 0;  ///< of leaving it out, in squared steps; 0: it is exact then
};

/// Writes the blocks of one stream. Thread-safe.
class BlockEncoder {
 public:
  /// @param parameters  kept by reference.
  BlockEncoder(const WaveletParameters& parameters, const StreamInfo& stream)
      : parameters_(parameters), stream_(stream) {}

  /// @param values, states  kept by reference; states are those of codec 3, and not empty there
  BlockContent contentOf(std::span<const float> values, const BlockShape& shape,
                         std::span<const VoxelState> states) const;

  /// The mode among candidates with the least squared error + lambda * bits, where lambda is what
  /// a bit is worth at this quantisation step; none when leaving the block out costs less still.
  std::optional<BlockMode> choose(const BlockContent& block, const ModeChoice& choice) const;

  /// Adds what the block of 16 frames would cost if it were cut in time.
  void addLengthCosts(const BlockContent& block, LengthCosts& lengths) const;

  /// The tiers of a block; all empty without a mode, but for the topology. Adds to `training` what
  /// is in them.
  std::vector<std::vector<std::byte>> encode(const BlockContent& block,
                                             const std::optional<BlockMode>& mode,
                                             Training& training) const;

 private:
  const WaveletParameters& parameters_;
  StreamInfo stream_;
};

}  // namespace volute
