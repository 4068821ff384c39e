// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/contexts.hpp"
#include "volute/codec/subbands.hpp"

// The order of the bits of quantised coefficients, and what each depends on: docs/format.md,
// section 8. Written once for writing, reading and pricing: a Bits object codes a bit and gives it
// back; a reader ignores the value that it is handed.
//
//   concept Bits:  bool bit(unsigned context, bool value);  bool even(bool value);

namespace volute {

/// Magnitudes are remembered for their neighbours up to this.
inline constexpr int kRemembered = 255;

/// Greatest number of bits of a quantised coefficient.
inline constexpr int kMaxBits = 30;

namespace detail {

template <std::size_t kSize>
constexpr std::array<std::uint8_t, 256> classTable(const std::array<int, kSize>& upTo) {
  std::array<std::uint8_t, 256> table{};
  for (int n = 0; n < 256; ++n) {
    std::uint8_t c = 0;
    while (c < kSize && n > upTo[c]) ++c;
    table[n] = c;
  }
  return table;
}

}  // namespace detail

inline constexpr auto kSumClass = detail::classTable(std::array{0, 1, 2, 4, 6, 9, 14, 22, 40});
inline constexpr auto kWideClass =
    detail::classTable(std::array{0, 1, 2, 4, 6, 9, 14, 22, 32, 46, 66, 94, 134, 190});
inline constexpr auto kSizeClass = detail::classTable(std::array{0, 1, 2, 4, 9});

inline unsigned sumClass(unsigned sum) {
  return kSumClass[std::min(sum, 255u)];
}

inline unsigned wideClass(unsigned sum) {
  return kWideClass[std::min(sum, 255u)];
}

inline unsigned sizeClass(unsigned size) {
  return kSizeClass[std::min(size, 255u)];
}

/// Cells with few coefficients are in classes of their own.
inline unsigned memberClass(unsigned members) {
  return members < 4 ? 0 : members < 8 ? 1 : members < 15 ? 2 : 3;
}

/// How many bits are set in a number below 16.
inline constexpr std::array<std::uint8_t, 16> kOnes{0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

inline unsigned onesOf(std::uint16_t word) {
  return unsigned{kOnes[word & 15]} + kOnes[word >> 4 & 15] + kOnes[word >> 8 & 15] +
         kOnes[word >> 12];
}

/// Where the cells of a level are in memory, with a border of empty cells around all.
class CellPlaces {
 public:
  std::ptrdiff_t at(const BlockGrid::Index4& cell) const {
    std::ptrdiff_t at = 0;
    for (int axis = 0; axis < 4; ++axis) at += (cell[axis] + 1) * stride_[axis];
    return at;
  }

 protected:
  /// @return how many cells that are, those of the border too
  std::size_t place(const CellLevel& level) {
    std::size_t size = 1;
    for (int axis = 4; axis-- > 0;) {
      stride_[axis] = static_cast<std::ptrdiff_t>(size);
      size *= static_cast<std::size_t>(level.cells[axis]) + 2;
    }
    int n = 0;
    for (int a = 0; a < 4; ++a) {
      direct_[a] = -stride_[a];
      for (int b = a + 1; b < 4; ++b) {
        diagonal_[n++] = -stride_[a] - stride_[b];
        diagonal_[n++] = -stride_[a] + stride_[b];
      }
    }
    return size;
  }

  std::array<std::ptrdiff_t, 4> stride_{}, direct_{};
  std::array<std::ptrdiff_t, 12> diagonal_{};
};

/// The magnitudes of one level, for the contexts of the cells to come and of the next level: a cell
/// is 16 of them.
class CellMemory : public CellPlaces {
 public:
  /// Forgets all, for the cells of another level.
  void reset(const CellLevel& level) {
    const std::size_t size = place(level);
    magnitudes_.assign(16 * size, 0);
    sums_.assign(size, 0);
  }

  /// Neighbours before a cell: those at distance 1 twice, diagonal ones once.
  unsigned sumAround(std::ptrdiff_t cell) const {
    const std::uint16_t* s = sums_.data() + cell;
    unsigned sum = 0;
    for (std::ptrdiff_t d : direct_) sum += 2u * s[d];
    for (std::ptrdiff_t d : diagonal_) sum += s[d];
    return sum;
  }

  /// Magnitudes around a cell, summed for each of the 16 orientations.
  void around(std::ptrdiff_t cell, std::uint16_t out[16]) const {
    const std::uint8_t* m = magnitudes_.data() + 16 * cell;
    std::uint16_t sum[16] = {};
    for (std::ptrdiff_t d : direct_) {
      const std::uint8_t* from = m + 16 * d;
      for (int k = 0; k < 16; ++k) sum[k] = static_cast<std::uint16_t>(sum[k] + 2 * from[k]);
    }
    for (std::ptrdiff_t d : diagonal_) {
      const std::uint8_t* from = m + 16 * d;
      for (int k = 0; k < 16; ++k) sum[k] = static_cast<std::uint16_t>(sum[k] + from[k]);
    }
    std::copy(sum, sum + 16, out);
  }

  unsigned sum(std::ptrdiff_t cell) const { return sums_[cell]; }

  std::uint8_t magnitude(std::ptrdiff_t cell, int k) const { return magnitudes_[16 * cell + k]; }

  void remember(std::ptrdiff_t cell, int k, std::int32_t q) {
    const auto m = static_cast<std::uint8_t>(std::min(std::abs(q), kRemembered));
    magnitudes_[16 * cell + k] = m;
    sums_[cell] = static_cast<std::uint16_t>(sums_[cell] + m);
  }

 private:
  std::vector<std::uint8_t> magnitudes_;
  std::vector<std::uint16_t> sums_;
};

/// What is known of a cell before it is coded.
struct CellContext {
  int level = 0;
  unsigned cell = 0;  ///< context of the bit that says whether anything is in it
  std::uint16_t around[16] = {};
  std::uint8_t parent[16] = {};

  /// Context of coefficient k's zero bit. `siblings`: siblingsOf() it.
  unsigned zero(int k, unsigned siblings) const {
    return context::kZero +
           ((orientation(k) * kSumClasses + sumClass((around[k] + 1u) / 2)) * kSizeClasses +
            sizeClass(2u * parent[k])) *
               kSizeClasses +
           sizeClass(siblings);
  }

  /// First context of its magnitude.
  unsigned size(int k, unsigned siblings) const {
    const unsigned sum = around[k] + 2u * parent[k] + 2 * siblings;
    return context::kSize + (orientation(k) * kWideClasses + wideClass((sum + 1) / 2)) * 16;
  }

  /// The magnitudes of the orientations that are k but for one high; `m`: of the cell's
  /// coefficients before k, and 0 from k on and for 0.
  static unsigned siblingsOf(int k, const std::uint8_t m[16]) {
    // Without a bit that k does not have it is k itself, and still 0.
    return unsigned{m[k & 7]} + m[k & 11] + m[k & 13] + m[k & 14];
  }

 private:
  unsigned orientation(int k) const { return static_cast<unsigned>(level) * 5 + kOnes[k]; }
};

/// A magnitude of at least 1: unary up to 16, then Exp-Golomb.
template <class Bits>
std::int32_t codeMagnitude(Bits& bits, unsigned context, std::int32_t magnitude) {
  for (std::int32_t k = 1; k < 16; ++k) {
    if (!bits.bit(context + static_cast<unsigned>(k), magnitude > k))
      return k;
  }
  const auto rest = static_cast<std::uint32_t>(magnitude - 15);
  const int length = magnitude > 15 ? static_cast<int>(std::bit_width(rest)) - 1 : 0;
  const unsigned longer =
      context::kLong + 32 * ((context - context::kSize) / 16 % static_cast<unsigned>(kWideClasses));
  int n = 0;
  while (n < kMaxBits - 1 && bits.bit(longer + static_cast<unsigned>(n), length > n)) ++n;
  std::uint32_t value = 1;
  for (int i = n; i-- > 0;) value = value << 1 | (bits.even((rest >> i & 1) != 0) ? 1u : 0u);
  return static_cast<std::int32_t>(value) + 15;
}

/// Any number: how many bits its magnitude has, in unary, those below the first, and the sign.
/// `context`: the first of kMaxBits.
template <class Bits>
std::int32_t codeNumber(Bits& bits, unsigned context, std::int32_t q) {
  const auto magnitude = static_cast<std::uint32_t>(std::abs(q));
  const int length = static_cast<int>(std::bit_width(magnitude));
  int n = 0;
  while (n < kMaxBits && bits.bit(context + static_cast<unsigned>(n), length > n)) ++n;
  if (n == 0)
    return 0;
  std::uint32_t value = 1;
  for (int i = n - 1; i-- > 0;)
    value = value << 1 | (bits.even((magnitude >> i & 1) != 0) ? 1u : 0u);
  const bool negative = bits.even(q < 0);
  return negative ? -static_cast<std::int32_t>(value) : static_cast<std::int32_t>(value);
}

/// The coefficients `existing` of a cell in which one at least is not zero.
template <class Bits>
void codeMembers(Bits& bits, const CellContext& c, std::uint16_t existing, std::int32_t q[16]) {
  bool seen = false;
  std::uint8_t m[16] = {};
  for (unsigned left = existing; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    const unsigned siblings = CellContext::siblingsOf(k, m);
    // The last one must be what makes the cell more than empty.
    const bool implied = !seen && (left & (left - 1)) == 0;
    if (!implied && !bits.bit(c.zero(k, siblings), q[k] != 0)) {
      q[k] = 0;
      continue;
    }
    seen = true;
    const std::int32_t magnitude = codeMagnitude(bits, c.size(k, siblings), std::abs(q[k]));
    q[k] = bits.even(q[k] < 0) ? -magnitude : magnitude;
    m[k] = static_cast<std::uint8_t>(std::min(magnitude, kRemembered));
  }
}

/// Visits the cells of a level that have coefficients, in C order:
///
///   bool code(position, existing, context, neighbours, q)
///
/// with the cell's position in the block, its orientations, the context of its bit, and
/// neighbours(), which fills in the rest of the context and must be called before codeMembers(). It
/// says whether any of q is not zero.
///
/// @param support  of the block, or empty for all.
/// @param parent  the memory of the level above, whose strides are twice as far; null for none.
/// @param memory  what is remembered of this one.
template <class Code>
void codeLevel(const CellLevel& level, std::span<const std::uint8_t> support,
               const CellLevel* above, const CellMemory* parent, CellMemory& memory,
               const Code& code) {
  memory.reset(level);
  CellContext c;
  c.level = level.stride;
  const unsigned first =
      context::kCell + static_cast<unsigned>(c.level) * kSumClasses * kSizeClasses * kMemberClasses;
  BlockGrid::Index4 cell{};
  const auto& count = level.cells;
  for (cell[0] = 0; cell[0] < count[0]; ++cell[0])
    for (cell[1] = 0; cell[1] < count[1]; ++cell[1])
      for (cell[2] = 0; cell[2] < count[2]; ++cell[2]) {
        // A row of cells along x.
        cell[3] = 0;
        const std::uint16_t inRow = level.existingInRow(cell);
        std::ptrdiff_t position = level.position(cell);
        std::ptrdiff_t at = memory.at(cell);
        const std::ptrdiff_t parents = parent != nullptr ? parent->at(above->cellAbove(cell)) : 0;
        const int perParent = above != nullptr && above->halved[3] ? 1 : 0;
        for (; cell[3] < count[3]; ++cell[3], position += level.step[3], ++at) {
          std::uint16_t existing = inRow;
          if (level.cut[3] && cell[3] == count[3] - 1)
            existing = static_cast<std::uint16_t>(existing & ~level.high[3]);
          if (!support.empty())
            existing = level.within(support.data() + position, existing);
          if (existing == 0)
            continue;
          const std::ptrdiff_t up = parents + (cell[3] >> perParent);
          const unsigned parentSum = parent != nullptr ? parent->sum(up) : 0;
          c.cell = first +
                   (sumClass((memory.sumAround(at) + 2) / 4) * kSizeClasses +
                    sizeClass((parentSum + 1) / 2)) *
                       kMemberClasses +
                   memberClass(onesOf(existing));
          const auto neighbours = [&] {
            memory.around(at, c.around);
            for (int k = 0; k < 16; ++k)
              c.parent[k] = parent != nullptr ? parent->magnitude(up, k) : 0;
          };
          std::int32_t q[16] = {};
          if (!code(position, existing, c, neighbours, q))
            continue;
          for (unsigned left = existing; left != 0; left &= left - 1) {
            const int k = std::countr_zero(left);
            if (q[k] != 0)
              memory.remember(at, k, q[k]);
          }
        }
      }
}

}  // namespace volute
