// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "volute/codec/wavelet_codec.hpp"

namespace volute {

/// What a way through blocks teaches about a stream: its contexts, and what quantised magnitudes
/// stand for. Whole numbers, so the order of blocks does not matter.
struct Training {
  ContextCounts counts;
  SymbolCounts symbols;  ///< of cells that are coded by symbols; else empty
  /// Magnitudes quantised to 1, and to more (less what they were quantised to), in 1/65536.
  std::int64_t oneSum = 0, oneCount = 0, moreSum = 0, moreCount = 0;
  std::int64_t bits = 0;  ///< of all, without topology and outliers

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

/// Writes the blocks of one stream. Thread-safe.
class BlockEncoder {
 public:
  /// @param parameters  kept by reference.
  BlockEncoder(const WaveletParameters& parameters, const StreamInfo& stream)
      : parameters_(parameters), stream_(stream) {}

  /// The mode among candidates with the least squared error + lambda * bits, where lambda is what
  /// a bit is worth at this quantisation step; none when leaving the block out costs less still.
  /// @param states  what its voxels are; of codec 3 alone, and not empty there
  std::optional<BlockMode> choose(std::span<const float> values, const BlockShape& shape,
                                  std::span<const VoxelState> states,
                                  const ModeChoice& choice) const;

  /// The tiers of a block; all empty without a mode, but for the topology. Adds to `training` what
  /// is in them.
  std::vector<std::vector<std::byte>> encode(std::span<const float> values, const BlockShape& shape,
                                             std::span<const VoxelState> states,
                                             const std::optional<BlockMode>& mode,
                                             Training& training) const;

 private:
  const WaveletParameters& parameters_;
  StreamInfo stream_;
};

}  // namespace volute
