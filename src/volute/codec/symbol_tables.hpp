// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/contexts.hpp"

// Tables of symbols: how often each of 16 symbols is, in each situation that a coefficient can be
// in. They stand in the file and do not change (docs/format.md, 10.4).

namespace volute {

namespace symbol {

inline constexpr int kSymbols = 16;
/// A magnitude of so much, or more, is this symbol; what it is follows.
inline constexpr int kEscape = 15;
inline constexpr int kProbabilityBits = 15;

inline constexpr unsigned kNearClasses = 16;
inline constexpr unsigned kSiblingClasses = 4;
inline constexpr unsigned kOrientations = 7;

// Contexts, in the order of the table. Within a group the last index runs fastest.
inline constexpr unsigned kCell = 0;  ///< level, neighbours, parent, members; two symbols
inline constexpr unsigned kCoefficient =
    kCell + kCellLevels * kSumClasses * kSizeClasses *
                kMemberClasses;  ///< level, orientation, near, siblings, whether a parent
inline constexpr unsigned kLength = kCoefficient + kCellLevels * kOrientations * kNearClasses *
                                                       kSiblingClasses *
                                                       2;    ///< near: bits of an escape
inline constexpr unsigned kLonger = kLength + kNearClasses;  ///< more bits still
inline constexpr unsigned kCount = kLonger + 1;

inline constexpr int symbolsOf(unsigned context) {
  return context < kCoefficient ? 2 : kSymbols;
}

/// Exceeds so many limits: the class of neighbours and parent.
inline constexpr std::array<std::uint16_t, kNearClasses - 1> kNearLimits{
    0, 1, 2, 4, 6, 10, 15, 22, 34, 51, 76, 115, 172, 258, 387};

}  // namespace symbol

/// Where the symbols of a context end among 2^15 places: symbol s has those after ends[s] up to
/// ends[s + 1]. ends[0] = -1.
struct SymbolEnds {
  std::array<std::int16_t, symbol::kSymbols + 1> ends;

  /// The symbol of a place. Most are small.
  unsigned at(int place) const {
    const int small = static_cast<int>(place > ends[1]) + static_cast<int>(place > ends[2]) +
                      static_cast<int>(place > ends[3]);
    auto s = static_cast<unsigned>(small);
    if (small == 3) [[unlikely]] {
      while (place > ends[s + 1]) ++s;
    }
    return s;
  }

  std::uint32_t first(unsigned s) const { return static_cast<std::uint32_t>(ends[s] + 1); }

  std::uint32_t count(unsigned s) const {
    return static_cast<std::uint32_t>(ends[s + 1] - ends[s]);
  }
};

/// How often each context saw each symbol.
using SymbolCounts = std::vector<std::array<std::uint32_t, symbol::kSymbols>>;

/// The bytes for a file: what its counts suggest, where that is worth its bits.
std::vector<std::byte> symbolTable(const SymbolCounts& counts);

/// What such bytes say; a guess without any. Any bytes give valid tables.
std::vector<SymbolEnds> symbolsOfTable(std::span<const std::byte> table);

/// -log2 of the share of each symbol, in 1/4096 bit.
using SymbolPrices = std::vector<std::array<std::uint32_t, symbol::kSymbols>>;
SymbolPrices pricesOf(std::span<const SymbolEnds> symbols);

}  // namespace volute
