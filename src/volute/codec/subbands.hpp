// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <bit>
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

  /// Where a cell's orientation 0 stands in the block.
  std::ptrdiff_t position(const Index4& cell) const {
    return cell[0] * step[0] + cell[1] * step[1] + cell[2] * step[2] + cell[3] * step[3];
  }

  /// The cell of this level whose places hold the same frames and voxels as a cell of the next
  /// finer one.
  Index4 cellAbove(Index4 cell) const {
    for (int axis = 0; axis < 4; ++axis) cell[axis] >>= halved[axis] ? 1 : 0;
    return cell;
  }

  /// The orientations that lie inside the block in a row of cells along x, but for its last cell.
  std::uint16_t existingInRow(const Index4& cell) const {
    std::uint16_t left = orientations;
    for (int axis = 0; axis < 3; ++axis) {
      if (cut[axis] && cell[axis] == cells[axis] - 1)
        left = static_cast<std::uint16_t>(left & ~high[axis]);
    }
    return left;
  }

  /// Those of `existing` that belong to the support, whose value at the cell's position is *cell.
  std::uint16_t within(const std::uint8_t* cell, std::uint16_t existing) const {
    unsigned in = 0;
    if (existing == 0xFFFE) {
      for (int k = 1; k < 16; ++k) in |= static_cast<unsigned>(cell[offset[k]]) << k;
    } else {
      for (unsigned left = existing; left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        in |= static_cast<unsigned>(cell[offset[k]]) << k;
      }
    }
    return static_cast<std::uint16_t>(in);
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
