// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/block_syntax.hpp"
#include "volute/codec/symbol_tables.hpp"

// What the symbols of cells depend on: docs/format.md, 10.4. For reading, writing and pricing.

namespace volute {

/// The coefficients of a cell in the order in which they are coded: each after those that it is
/// beside of.
inline constexpr std::array<std::uint8_t, 15> kCellOrder{1,  2,  4, 8,  3,  5,  6, 9,
                                                         10, 12, 7, 11, 13, 14, 15};

namespace detail {

inline constexpr auto kNearClass = [] {
  std::array<std::uint8_t, symbol::kNearLimits.back() + 2> table{};
  for (std::size_t n = 0; n < table.size(); ++n)
    table[n] = static_cast<std::uint8_t>(
        std::ranges::count_if(symbol::kNearLimits, [n](std::size_t limit) { return n > limit; }));
  return table;
}();

/// First context of the coefficient k of a cell of the finest level, in the class of no neighbours.
inline constexpr auto kFirstOf = [] {
  std::array<std::uint16_t, 16> table{};
  for (unsigned k = 1; k < 16; ++k)
    table[k] = static_cast<std::uint16_t>(symbol::kCoefficient + (kOnes[k & 7] + (k & 8) / 2 - 1) *
                                                                     symbol::kNearClasses *
                                                                     symbol::kSiblingClasses * 2);
  return table;
}();

}  // namespace detail

/// Twice the class of siblings whose symbols have this sum.
inline unsigned siblingStep(unsigned sum) {
  return 2 * (static_cast<unsigned>(sum > 0) + static_cast<unsigned>(sum > 2) +
              static_cast<unsigned>(sum > 7));
}

/// The sum of the symbols of those coefficients that are k but for one high.
inline unsigned siblingSum(int k, const std::uint8_t m[16]) {
  return unsigned{m[k & 7]} + m[k & 11] + m[k & 13] + m[k & 14];
}

/// The magnitudes of one level, at most 255 each. Cells that have none share one entry.
class CellField : public CellPlaces {
 public:
  using Entry = std::array<std::uint8_t, 16>;
  static constexpr std::size_t kCellsOfRow = kLongestSide / 2;

  void reset(const CellLevel& level) {
    const std::size_t size = place(level);
    entryOf_.assign(size, 0);
    sums_.assign(size + kCellsOfRow, 0);
    entries_.resize(1);
    entries_[0] = {};
  }

  /// The sums of neighbours of the cells of a row, those at distance 1 twice, without the cell
  /// before in the row.
  void sumsOfRow(std::ptrdiff_t row, std::uint16_t out[kCellsOfRow]) const {
    const std::uint8_t* s = sums_.data() + row;
    std::uint16_t sum[kCellsOfRow] = {};
    for (int a = 0; a < 3; ++a) addTo<kCellsOfRow>(sum, s + direct_[static_cast<std::size_t>(a)]);
    for (std::uint16_t& one : sum) one = static_cast<std::uint16_t>(2 * one);
    for (std::ptrdiff_t step : diagonal_) addTo<kCellsOfRow>(sum, s + step);
    std::copy_n(sum, kCellsOfRow, out);
  }

  unsigned sum(std::ptrdiff_t cell) const { return sums_[static_cast<std::size_t>(cell)]; }

  const Entry& entry(std::ptrdiff_t cell) const {
    return entries_[entryOf_[static_cast<std::size_t>(cell)]];
  }

  /// For each coefficient its first context (the class of siblings is to be added).
  /// @param parent  the entry of the cell above, or null
  void contexts(std::ptrdiff_t cell, const Entry* parent, unsigned level,
                std::uint16_t out[16]) const {
    std::uint16_t near[16] = {};
    for (std::ptrdiff_t step : direct_) addTo<16>(near, entry(cell + step).data());
    for (std::uint16_t& one : near) one = static_cast<std::uint16_t>(2 * one);
    for (std::ptrdiff_t step : diagonal_) addTo<16>(near, entry(cell + step).data());
    const unsigned first =
        level * symbol::kOrientations * symbol::kNearClasses * symbol::kSiblingClasses * 2;
    static constexpr Entry kNone{};
    const Entry& above = parent != nullptr ? *parent : kNone;
    for (std::size_t k = 1; k < 16; ++k) {
      const std::size_t sum =
          std::min(detail::kNearClass.size() - 1, std::size_t{near[k]} + above[k] / 2u);
      out[k] = static_cast<std::uint16_t>(detail::kFirstOf[k] + first +
                                          8u * detail::kNearClass[sum] + (above[k] > 0 ? 1u : 0u));
    }
  }

  /// The class of neighbours and parent that a context of contexts() has.
  static unsigned nearClassOf(unsigned context) {
    return (context - symbol::kCoefficient) / 8 % symbol::kNearClasses;
  }

  /// @param sum  of all, at most 255
  void remember(std::ptrdiff_t cell, const std::uint8_t m[16], unsigned sum) {
    entryOf_[static_cast<std::size_t>(cell)] = static_cast<std::uint16_t>(entries_.size());
    std::copy_n(m, 16, entries_.emplace_back().begin());
    sums_[static_cast<std::size_t>(cell)] = static_cast<std::uint8_t>(std::min(sum, 255u));
  }

 private:
  template <std::size_t kCount>
  static void addTo(std::uint16_t* sum, const std::uint8_t* numbers) {
    for (std::size_t i = 0; i < kCount; ++i)
      sum[i] = static_cast<std::uint16_t>(sum[i] + numbers[i]);
  }

  std::vector<std::uint16_t> entryOf_;
  std::vector<std::uint8_t> sums_;
  std::vector<Entry> entries_;
};

/// The fields of a component at the level that is coded and the one above.
struct ComponentFields {
  CellField current, above;
};

/// The way through the cells of a block, as BlockWalk goes it.
class FieldWalk {
 public:
  /// @param fields  room, one for each component
  FieldWalk(const BlockShape& shape, const BlockMode& mode, std::span<const std::uint8_t> support,
            std::span<ComponentFields> fields)
      : shape_(shape),
        mode_(mode),
        support_(support),
        levels_(blockLevels(shape.extents, mode.timeLevels)),
        fields_(fields) {}

  /// Calls code(component, level, field, cell, position, existing, context, parent, x) for each
  /// cell that has coefficients: with its place in the field and in the block, its orientations,
  /// the context of the symbol that says whether any is not zero, the entry of its parent, or null,
  /// and its place in its row. begin(component, level) comes before the cells of each level.
  template <class Begin, class Code>
  void cells(const TierStrides& strides, const Begin& begin, const Code& code) {
    for (int stride = strides.first; stride > strides.end; --stride) {
      if (stride >= deepest(levels_))
        continue;
      const CellLevel level(shape_.extents, levels_, stride, mode_.wavelet);
      for (int c = 0; c < shape_.channels; ++c) {
        ComponentFields& fields = fields_[static_cast<std::size_t>(c)];
        std::swap(fields.current, fields.above);
        fields.current.reset(level);
        begin(c, level);
        codeLevel(c, level, fields, code);
      }
      above_ = level;
    }
  }

 private:
  template <class Code>
  void codeLevel(int c, const CellLevel& level, ComponentFields& fields, const Code& code) {
    CellField& field = fields.current;
    const CellField* parents = above_ ? &fields.above : nullptr;
    const unsigned first = symbol::kCell + static_cast<unsigned>(level.stride) * kSumClasses *
                                               kSizeClasses * kMemberClasses;
    BlockGrid::Index4 cell{};
    const auto& count = level.cells;
    for (cell[0] = 0; cell[0] < count[0]; ++cell[0])
      for (cell[1] = 0; cell[1] < count[1]; ++cell[1])
        for (cell[2] = 0; cell[2] < count[2]; ++cell[2]) {
          cell[3] = 0;
          const std::uint16_t inRow = level.existingInRow(cell);
          std::ptrdiff_t position = level.position(cell);
          std::ptrdiff_t at = field.at(cell);
          const std::ptrdiff_t up = parents != nullptr ? parents->at(above_->cellAbove(cell)) : 0;
          const int perParent = above_ && above_->halved[3] ? 1 : 0;
          std::uint16_t sums[CellField::kCellsOfRow];
          field.sumsOfRow(at, sums);
          for (; cell[3] < count[3]; ++cell[3], position += level.step[3], ++at) {
            std::uint16_t existing = inRow;
            if (level.cut[3] && cell[3] == count[3] - 1)
              existing = static_cast<std::uint16_t>(existing & ~level.high[3]);
            if (!support_.empty())
              existing = level.within(support_.data() + position, existing);
            if (existing == 0)
              continue;
            const std::ptrdiff_t parent = up + (cell[3] >> perParent);
            const unsigned sum = sums[cell[3]] + 2 * field.sum(at - 1);
            const unsigned above = parents != nullptr ? parents->sum(parent) : 0;
            const unsigned context =
                first +
                (sumClass((sum + 2) / 4) * kSizeClasses + sizeClass((above + 1) / 2)) *
                    kMemberClasses +
                memberClass(onesOf(existing));
            code(c, level, field, at, position, existing, context,
                 parents != nullptr ? &parents->entry(parent) : nullptr,
                 static_cast<unsigned>(cell[3]));
          }
        }
  }

  BlockShape shape_;
  BlockMode mode_;
  std::span<const std::uint8_t> support_;
  AxisLevels levels_;
  std::span<ComponentFields> fields_;
  std::optional<CellLevel> above_;
};

}  // namespace volute
