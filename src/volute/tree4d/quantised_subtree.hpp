// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace volute {

/// The nodes of one level of a pruned, quantised hexadeca-tree, breadth-first (Ahrenberg et al.
/// 2005, section 4.3).
struct SubtreeLevel {
  std::vector<std::uint16_t>
      masks;  ///< one a node: bit j: coefficient j is kept; bit 0: the node has children
  std::vector<std::uint16_t> children;     ///< one for each node that has children: which of the 16
  std::vector<std::int32_t> coefficients;  ///< node after node; of a node channel after channel; of
                                           ///< those one for each bit 1..15
};

/// A dense 4D grid of means, shape (t, z, y, x, c), turned into quantised Haar coefficients level
/// by level from the bottom up, pruned, and listed breadth-first from the top down.
struct QuantisedSubtree {
  std::vector<SubtreeLevel> levels;  ///< [0] is the finest
  std::vector<float> mean;           ///< of the whole, one a channel
  /// Which cells of the grid have a node below the finest level, in breadth-first order (see
  /// `hasNode`).
  std::vector<std::uint32_t> leaves;
  bool empty = true;  ///< no coefficient and no child anywhere
};

struct SubtreeShape {
  std::array<int, 4> extents;  ///< cells: t, z, y, x
  int channels = 1;
  int baseLevel = 0;  ///< the tree's level of the finest nodes made here
  int levels = 1;     ///< 2^levels covers the longest extent
};

/// @param hasNode  one a cell: whether the cell has a node of its own one level below; empty = none
/// has.
/// @param step     of the orthonormal coefficients.
/// The sibling beyond an odd border takes the mean of its inner neighbour, so it costs no
/// coefficient; it is no child.
QuantisedSubtree buildSubtree(const SubtreeShape& shape, std::span<const float> means,
                              std::span<const std::uint8_t> hasNode, double step);

/// Calls visit(orthonormal coefficient) for each of the same coefficients before quantisation; for
/// QuantisationModel.
template <class Visit>
void visitCoefficients(const SubtreeShape& shape, std::span<const float> means, Visit&& visit);

}  // namespace volute

#include "volute/tree4d/quantised_subtree-inl.hpp"
