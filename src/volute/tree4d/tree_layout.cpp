// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/tree_layout.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "volute/tree4d/haar_node.hpp"
#include "volute/tree4d/tree_node.hpp"

namespace volute {
namespace {

/// Chooses the width of a level's coefficients and stores them.
template <class Narrow>
std::size_t countEscapes(std::span<const std::int32_t> coefficients) {
  constexpr std::int32_t kMax = std::numeric_limits<Narrow>::max();
  return static_cast<std::size_t>(
      std::ranges::count_if(coefficients, [](std::int32_t q) { return std::abs(q) > kMax; }));
}

template <class Narrow>
void store(std::span<const std::int32_t> coefficients, std::vector<Narrow>& out,
           TreeData::Level& level) {
  constexpr std::int32_t kMax = std::numeric_limits<Narrow>::max();
  for (std::int32_t q : coefficients) {
    if (std::abs(q) > kMax) {
      level.escapeIndex.push_back(static_cast<std::uint32_t>(out.size()));
      level.escapeValue.push_back(q);
      q = std::numeric_limits<Narrow>::min();
    }
    out.push_back(static_cast<Narrow>(q));
  }
}

void storeCoefficients(std::span<const std::int32_t> coefficients, TreeData::Level& level) {
  constexpr std::size_t kEscapeBytes = 8;
  const std::size_t narrowBytes =
      coefficients.size() + kEscapeBytes * countEscapes<std::int8_t>(coefficients);
  const std::size_t wideBytes =
      2 * coefficients.size() + kEscapeBytes * countEscapes<std::int16_t>(coefficients);
  level.wide = wideBytes < narrowBytes;
  if (level.wide) {
    store(coefficients, level.wide16, level);
  } else {
    store(coefficients, level.narrow8, level);
    level.narrow8.resize(level.narrow8.size() + TreeData::kPadding);
  }
  level.narrow8.shrink_to_fit();
  level.wide16.shrink_to_fit();
}

}  // namespace

void layOut(std::span<const SubtreeLevel> parts, TreeData& data) {
  data.levels.resize(parts.size());
  std::uint32_t innerCount = 0;
  for (std::size_t l = parts.size(); l-- > 0;) {
    TreeData::Level& level = data.levels[l];
    level.firstNode = static_cast<std::uint32_t>(data.masks.size());
    level.nodes = static_cast<std::uint32_t>(parts[l].masks.size());
    level.scale = data.step / orthonormalScale(static_cast<int>(l));
    storeCoefficients(parts[l].coefficients, level);
    data.masks.insert(data.masks.end(), parts[l].masks.begin(), parts[l].masks.end());
    data.masks.resize(
        (data.masks.size() + TreeData::kGroup - 1) / TreeData::kGroup * TreeData::kGroup, 0);
    data.childMasks.insert(data.childMasks.end(), parts[l].children.begin(),
                           parts[l].children.end());

    std::uint32_t coefficientCount = 0;
    for (std::size_t i = level.firstNode; i < data.masks.size(); ++i) {
      if (i % TreeData::kGroup == 0)
        data.groups.push_back({coefficientCount, innerCount});
      coefficientCount +=
          static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(data.masks[i] & 0xFFFEu)));
      innerCount += data.masks[i] & 1u;
    }
  }

  // Children stand in the order of their parents, from the begin of the level below.
  for (std::size_t l = parts.size(); l-- > 1;) {
    std::uint32_t child = data.levels[l - 1].firstNode;
    for (std::uint16_t children : parts[l].children) {
      data.childBases.push_back(child);
      child += static_cast<std::uint32_t>(std::popcount(children));
    }
  }
  data.masks.shrink_to_fit();
  data.groups.shrink_to_fit();
  data.childMasks.shrink_to_fit();
  data.childBases.shrink_to_fit();
}

std::vector<SubtreeLevel> levelsOf(const TreeData& data) {
  std::vector<SubtreeLevel> parts(data.levels.size());
  std::size_t inner = 0;
  for (std::size_t l = data.levels.size(); l-- > 0;) {
    const TreeData::Level& level = data.levels[l];
    const auto first = data.masks.begin() + level.firstNode;
    parts[l].masks.assign(first, first + level.nodes);
    const auto parents =
        std::ranges::count_if(parts[l].masks, [](std::uint16_t mask) { return (mask & 1) != 0; });
    const auto firstParent = data.childMasks.begin() + static_cast<std::ptrdiff_t>(inner);
    parts[l].children.assign(firstParent, firstParent + parents);
    inner += static_cast<std::size_t>(parents);
    const std::size_t coefficients =
        level.wide ? level.wide16.size() : level.narrow8.size() - TreeData::kPadding;
    for (std::uint32_t i = 0; i < coefficients; ++i)
      parts[l].coefficients.push_back(coefficientAt(level, i));
  }
  return parts;
}

void enterBlocks(TreeData& data) {
  struct Cell {
    std::uint32_t node;
    int level;
    std::array<int, 4> at;  // in cells of its level
    std::array<float, 3> value;
  };

  const int entryLevel = data.entryLevels - 1;
  std::vector<Cell> stack{
      {data.levels.back().firstNode, static_cast<int>(data.levels.size()) - 1, {}, data.mean}};
  while (!stack.empty()) {
    const Cell cell = stack.back();
    stack.pop_back();
    if (cell.level == entryLevel || cell.node == TreeData::kNoNode) {
      // Everything below a cell without a node has the cell's value.
      const int shift = cell.level - entryLevel;
      std::array<int, 4> low{}, high{};
      for (int a = 0; a < 4; ++a) {
        low[a] = cell.at[a] << shift;
        high[a] = std::min((cell.at[a] + 1) << shift, data.entryCounts[a]);
      }
      for (int t = low[0]; t < high[0]; ++t)
        for (int z = low[1]; z < high[1]; ++z)
          for (int y = low[2]; y < high[2]; ++y)
            for (int x = low[3]; x < high[3]; ++x) {
              data.entries[((static_cast<std::size_t>(t) * data.entryCounts[1] + z) *
                                data.entryCounts[2] +
                            y) *
                               data.entryCounts[3] +
                           x] = {cell.node, cell.value};
            }
      continue;
    }
    for (int o = 0; o < kChildren; ++o) {
      Cell child{TreeData::kNoNode, cell.level - 1, {}, cell.value};
      for (int a = 0; a < 4; ++a) child.at[a] = 2 * cell.at[a] + (o >> (3 - a) & 1);
      if ((child.at[0] << (cell.level - 1 - entryLevel)) >= data.entryCounts[0] ||
          (child.at[1] << (cell.level - 1 - entryLevel)) >= data.entryCounts[1] ||
          (child.at[2] << (cell.level - 1 - entryLevel)) >= data.entryCounts[2] ||
          (child.at[3] << (cell.level - 1 - entryLevel)) >= data.entryCounts[3]) {
        continue;
      }
      for (int c = 0; c < data.channels; ++c)
        child.value[c] += nodeDetail(data, cell.level, cell.node, o, c);
      child.node = childNode(data, cell.node, o);
      stack.push_back(child);
    }
  }
}

}  // namespace volute
