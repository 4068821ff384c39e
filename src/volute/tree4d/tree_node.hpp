// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <bit>

#include "volute/tree4d/tree_data.hpp"

// What one node says, read from the arrays step by step: the obviously right twin of the kernels in
// read.cpp.

namespace volute {

/// Coefficients of the level before `node`, in multiples of channels.
inline std::uint32_t firstCoefficient(const TreeData& data, std::uint32_t node) {
  std::uint32_t count = data.groups[node / TreeData::kGroup].coefficients;
  for (std::uint32_t i = node / TreeData::kGroup * TreeData::kGroup; i < node; ++i) {
    count +=
        static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(data.masks[i] & 0xFFFEu)));
  }
  return count;
}

/// Number `index` in the array of a level's coefficients, in quantisation steps.
inline std::int32_t coefficientAt(const TreeData::Level& level, std::uint32_t index) {
  const std::int32_t q = level.wide ? level.wide16[index] : level.narrow8[index];
  if (q != (level.wide ? INT16_MIN : INT8_MIN))
    return q;
  const auto found = std::lower_bound(level.escapeIndex.begin(), level.escapeIndex.end(), index);
  return level.escapeValue[static_cast<std::size_t>(found - level.escapeIndex.begin())];
}

/// What `node` adds to its mean in child `o`: the sum of its wavelets there.
inline float nodeDetail(const TreeData& data, int level, std::uint32_t node, int o, int channel) {
  std::int32_t sum = 0;
  const auto kept =
      static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(data.masks[node] & 0xFFFEu)));
  std::uint32_t index = firstCoefficient(data, node) * data.channels + channel * kept;
  for (int j = 1; j < 16; ++j) {
    if (!(data.masks[node] >> j & 1))
      continue;
    const std::int32_t q = coefficientAt(data.levels[level], index);
    sum += std::popcount(static_cast<unsigned>(o & j)) % 2 == 1 ? -q : q;
    ++index;
  }
  return static_cast<float>(sum) * data.levels[level].scale;
}

/// The node of child `o`, or kNoNode when nothing refines it.
inline std::uint32_t childNode(const TreeData& data, std::uint32_t node, int o) {
  if (!(data.masks[node] & 1))
    return TreeData::kNoNode;
  std::uint32_t inner = data.groups[node / TreeData::kGroup].inner;
  for (std::uint32_t i = node / TreeData::kGroup * TreeData::kGroup; i < node; ++i)
    inner += data.masks[i] & 1u;
  const unsigned children = data.childMasks[inner];
  if (!(children >> o & 1))
    return TreeData::kNoNode;
  return data.childBases[inner] +
         static_cast<std::uint32_t>(std::popcount(children & ((1u << o) - 1)));
}

}  // namespace volute
