// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "volute/codec/block_grid.hpp"
#include "volute/wavelet/shape_adaptive.hpp"

namespace volute {

/// The wavelet coefficients of one level of a transformed block, as cells: a cell has one place for
/// each orientation k, whose bits 8, 4, 2, 1 say that t, z, y, x are high; k = 0 is what the next
/// level goes on with. Axes that are not halved at this level have no high.
struct CellLevel {
  using Index4 = BlockGrid::Index4;

  int stride = 0;  ///< j: coefficients stand at distances of 2^j, cells of 2^(j+1) on halved axes
  std::array<bool, 4> halved{};
  Index4 cells{};  ///< on each axis

  std::array<std::ptrdiff_t, 4> step{};  ///< between cells in the block
  std::array<int, 16> offset{};          ///< of orientation k from its cell, in the block
  std::uint16_t orientations = 0;        ///< bit k: exists here
  std::array<std::uint16_t, 4> high{};   ///< orientations that are high on an axis
  std::array<bool, 4> cut{};  ///< the last cell of this axis has no high: an odd number of samples

  std::array<double, 16> norm{};  ///< synthesis norms

  CellLevel(const Index4& extents, const AxisLevels& levels, int stride, Wavelet wavelet);

  /// The orientations of a cell that lie inside the block.
  std::uint16_t existing(const Index4& cell) const {
    std::uint16_t left = orientations;
    for (int axis = 0; axis < 4; ++axis) {
      if (cut[axis] && cell[axis] == cells[axis] - 1)
        left = static_cast<std::uint16_t>(left & ~high[axis]);
    }
    return left;
  }
};

/// The scaling coefficients that are left after all levels.
struct ScalingLattice {
  BlockGrid::Index4 count{};
  std::array<std::ptrdiff_t, 4> step{};
  double norm = 1;

  ScalingLattice(const BlockGrid::Index4& extents, const AxisLevels& levels, Wavelet wavelet);
};

/// C-order strides of a block.
std::array<std::ptrdiff_t, 4> stridesOf(const BlockGrid::Index4& extents);

}  // namespace volute
