// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/symbol_tables.hpp"

#include <algorithm>
#include <cmath>

#include "volute/codec/index_bits.hpp"

namespace volute {
namespace {

// The index of the probability that a symbol is greater than s, if it is not less: as in a table of
// contexts.
constexpr int kPlaces = 1 << symbol::kProbabilityBits;

using Indices = std::array<int, symbol::kSymbols - 1>;

/// How the indices are coded: whether a context has any (after one that has, after one that has
/// not); whether one more follows; and which, after the last of that symbol.
struct SymbolTableBits {
  AdaptiveBit present[2], more[4];
  IndexBits index[4];
};

std::size_t kindOf(int s) {
  return static_cast<std::size_t>(std::min(s, 3));
}

/// What is taken for granted: the more is around, the greater a symbol.
Indices guessOf(unsigned context) {
  Indices indices;
  indices.fill(24);
  if (context < symbol::kCoefficient) {
    indices[0] = 8 + 5 * static_cast<int>(context / (kSizeClasses * kMemberClasses) % kSumClasses);
  } else if (context < symbol::kLength) {
    const auto inner = static_cast<int>(context - symbol::kCoefficient);
    const int near = inner / 8 % static_cast<int>(symbol::kNearClasses);
    indices.fill(16 + 2 * near);
    indices[0] =
        std::min(kGreatestIndex,
                 10 + 3 * near + 3 * (inner / 2 % static_cast<int>(symbol::kSiblingClasses)));
  }
  return indices;
}

SymbolEnds endsOf(const Indices& indices, int symbols) {
  SymbolEnds result;
  result.ends.fill(static_cast<std::int16_t>(kPlaces - 1));
  result.ends[0] = -1;
  int left = kPlaces - symbols;  // each has one place at least
  for (int s = 0; s + 1 < symbols; ++s) {
    const int greater =
        static_cast<int>((static_cast<std::int64_t>(left) *
                          probabilityOfIndex(indices[static_cast<std::size_t>(s)])) >>
                         16);
    const auto at = static_cast<std::size_t>(s);
    result.ends[at + 1] = static_cast<std::int16_t>(result.ends[at] + left - greater + 1);
    left = greater;
  }
  return result;
}

/// How often a symbol was s, and greater, where it was not less.
struct Seen {
  double same, greater;

  /// What they cost with an index [bits].
  double bits(int index) const {
    constexpr double kUnseen = 0.4;  // what is not seen yet may still come
    const double p = probabilityOfIndex(index) / 65536.0;
    return -(same + kUnseen) * std::log2(1 - p) - (greater + kUnseen) * std::log2(p);
  }
};

double priceOf(const AdaptiveBit& state, bool bit) {
  return -std::log2((bit ? state.one : 65536 - state.one) / 65536.0);
}

}  // namespace

std::vector<std::byte> symbolTable(const SymbolCounts& counts) {
  ArithmeticEncoder out;
  SymbolTableBits bits;
  bool before = false;
  Indices last = guessOf(0);
  for (unsigned context = 0; context < symbol::kCount; ++context) {
    const auto& seen = counts[context];
    if (context == symbol::kCoefficient || context == symbol::kLength)
      last = guessOf(context);
    // How many symbols are not less than s.
    std::array<std::uint64_t, symbol::kSymbols + 1> rest{};
    for (std::size_t s = symbol::kSymbols; s-- > 0;) rest[s] = rest[s + 1] + seen[s];
    // The indices that make symbols and table the shortest.
    const int count = symbol::symbolsOf(context) - 1;
    Indices best = last;
    int changed = 0;  // how many indices stand in the table
    double saved = 0, savedOfAll = 0;
    for (int s = 0; s < count && rest[static_cast<std::size_t>(s)] > 0; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const std::size_t kind = kindOf(s);
      const Seen here{static_cast<double>(rest[at] - rest[at + 1]),
                      static_cast<double>(rest[at + 1])};
      const int wanted = indexOfCounts({static_cast<std::uint32_t>(rest[at] - rest[at + 1]),
                                        static_cast<std::uint32_t>(rest[at + 1])});
      const double staying = here.bits(last[at]);
      IndexBits& own = bits.index[kind];
      double least = staying + priceOf(own.zero, true);
      const int step = wanted > last[at] ? 1 : -1;
      double sizes = priceOf(own.zero, false) + priceOf(own.negative, step < 0);
      for (int size = 1; size <= std::abs(wanted - last[at]); ++size) {
        const AdaptiveBit& longer = own.longerThan(size);
        const int index = last[at] + step * size;
        const double cost = here.bits(index) + sizes + priceOf(longer, false);
        sizes += priceOf(longer, true);
        if (cost < least) {
          least = cost;
          best[at] = index;
        }
      }
      saved += staying - least - (s > 0 ? priceOf(bits.more[kind], true) : 0);
      if (saved > savedOfAll) {
        savedOfAll = saved;
        changed = s + 1;
      }
    }
    const AdaptiveBit& presence = bits.present[before ? 1 : 0];
    const bool present = savedOfAll > priceOf(presence, true) - priceOf(presence, false);
    out.bit(bits.present[before ? 1 : 0], present);
    before = present;
    if (!present)
      continue;
    for (int s = 0; s < count; ++s) {
      const auto at = static_cast<std::size_t>(s);
      const std::size_t kind = kindOf(s);
      if (s > 0) {
        out.bit(bits.more[kind], s < changed);
        if (s >= changed)
          break;
      }
      bits.index[kind].write(out, best[at] - last[at]);
      last[at] = best[at];
    }
  }
  auto bytes = out.finish();
  if (bytes.empty())
    bytes.push_back(std::byte{0});
  return bytes;
}

std::vector<SymbolEnds> symbolsOfTable(std::span<const std::byte> table) {
  std::vector<SymbolEnds> symbols(symbol::kCount);
  if (table.empty()) {
    for (unsigned context = 0; context < symbol::kCount; ++context)
      symbols[context] = endsOf(guessOf(context), symbol::symbolsOf(context));
    return symbols;
  }
  ArithmeticDecoder in(table);
  SymbolTableBits bits;
  bool before = false;
  Indices last = guessOf(0);
  for (unsigned context = 0; context < symbol::kCount; ++context) {
    if (context == symbol::kCoefficient || context == symbol::kLength)
      last = guessOf(context);
    const int count = symbol::symbolsOf(context) - 1;
    before = in.bit(bits.present[before ? 1 : 0]);
    for (int s = 0; before && s < count; ++s) {
      const std::size_t kind = kindOf(s);
      if (s > 0 && !in.bit(bits.more[kind]))
        break;
      int& index = last[static_cast<std::size_t>(s)];
      index = bits.index[kind].read(in, index);
    }
    symbols[context] = endsOf(last, count + 1);
  }
  return symbols;
}

SymbolPrices pricesOf(std::span<const SymbolEnds> symbols) {
  constexpr double kUnit = 4096;
  SymbolPrices prices(symbols.size());
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    for (unsigned s = 0; s < symbol::kSymbols; ++s) {
      const double share = std::max(symbols[i].count(s), 1u) / static_cast<double>(kPlaces);
      prices[i][s] = static_cast<std::uint32_t>(std::lround(-kUnit * std::log2(share)));
    }
  }
  return prices;
}

}  // namespace volute
