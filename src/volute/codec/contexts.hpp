// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/codec/arithmetic_coder.hpp"

// What the probability of each bit of codecs 2 and 3 depends on (docs/format.md, section 8).

namespace volute {

/// Levels that have cells: strides 1, 2, 4, 8.
inline constexpr int kCellLevels = 4;

/// Sizes of neighbourhoods fall into ten classes, or fifteen where the size of a coefficient is
/// guessed from them, those of single coefficients into six.
inline constexpr int kSumClasses = 10;
inline constexpr int kWideClasses = 15;
inline constexpr int kSizeClasses = 6;
inline constexpr int kMemberClasses = 4;

namespace context {

// Each group begins where the one before ends. Within a group the last index runs fastest, and
// neighbours in that order are alike: the file's table relies on it.
inline constexpr unsigned kShaped = 0;                 ///< whether a block has a support
inline constexpr unsigned kWavelet = kShaped + 1;      ///< its wavelet: not 9/7; then Haar
inline constexpr unsigned kTime = kWavelet + 2;        ///< its time levels, in two bits
inline constexpr unsigned kEnd = kTime + 3;            ///< corrections follow
inline constexpr unsigned kLine = kEnd + 1;            ///< uniform lines of the support
inline constexpr unsigned kSupport = kLine + 2;        ///< by 12 neighbours
inline constexpr unsigned kScaling = kSupport + 4096;  ///< bits of a scaling coefficient
inline constexpr unsigned kCell = kScaling + 32;       ///< level, neighbours, parent, members
inline constexpr unsigned kZero = kCell + kCellLevels * kSumClasses * kSizeClasses *
                                              4;  ///< level, highs, neighbours, parent, siblings
inline constexpr unsigned kSize =
    kZero + kCellLevels * 5 * kSumClasses * kSizeClasses * kSizeClasses;  ///< level, all three, k
inline constexpr unsigned kLong =
    kSize + kCellLevels * 5 * kWideClasses * 16;  ///< neighbours, bits above 15
inline constexpr unsigned kCorrected =
    kLong + kWideClasses * 32;                           ///< line; voxel by the one before
inline constexpr unsigned kCorrection = kCorrected + 3;  ///< size of a correction
// Codec 3 alone; a table of codec 2 ends before them.
inline constexpr unsigned kFull = kCorrection + 32;  ///< all voxels of a block are active
inline constexpr unsigned kCoded = kFull + 1;        ///< a block has coefficients
inline constexpr unsigned kOther = kCoded + 1;       ///< a block has inactive voxels with values
inline constexpr unsigned kOtherVoxel = kOther + 1;  ///< whether one is; by 4 neighbours
inline constexpr unsigned kOutliers =
    kOtherVoxel + 81;  ///< a block has outliers; its lines; voxels
inline constexpr unsigned kCount = kOutliers + 4;

}  // namespace context

/// All estimates, as they are when a block begins.
using Contexts = std::vector<AdaptiveBit>;

/// How often each context saw a 0 and a 1.
struct ContextCounts {
  std::vector<std::array<std::uint32_t, 2>> seen{context::kCount};

  void add(unsigned at, bool bit) { ++seen[at][bit ? 1 : 0]; }

  void add(const ContextCounts& other);
};

/// Probabilities in tables are numbers from 1 to 63, finer near 0 and near 1: of a 1 in 1/65536,
/// and the number for what was seen.
std::uint16_t probabilityOfIndex(int index);
int indexOfCounts(const std::array<std::uint32_t, 2>& seen);

/// What blocks begin with before anything is known of a file.
Contexts untrainedContexts();

/// The table for a file: the estimates that its counts suggest, where they are worth their bits.
std::vector<std::byte> contextTable(const ContextCounts& counts);

/// What the table says blocks begin with; untrainedContexts() without one. Any bytes give valid
/// contexts.
Contexts contextsOf(std::span<const std::byte> table);

}  // namespace volute
