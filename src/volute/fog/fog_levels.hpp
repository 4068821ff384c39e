// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/fog/plane_walk.hpp"
#include "volute/wavelet/spline_pyramid.hpp"

namespace volute {

/// A fog map at all its levels, as walks read it: the merged approximations in double, the same in
/// float with a border of zeros, and what is empty.
class FogLevels {
 public:
  struct Level {
    int cellsX = 0, cellsY = 0;
    /// Every cell outside is zero, and so is the last row and column unless the map ends there: a
    /// ray in the plane behind what is not empty must not be counted to it.
    CellRect occupied;
    /// Coefficient (i, j) is values()[base + (j + degree) * stride + i + degree], so cell (x, y)
    /// reads a square of (degree + 1)^2 values from base + y * stride + x on.
    std::int32_t base = 0, stride = 0;
    /// For blocks of kBlock^2 cells: the side [cells] of the largest aligned empty square around
    /// it, a multiple of kBlock; 0 where something is. Entry of (x, y):
    /// skips()[skipBase + (y / kBlock) * skipStride + x / kBlock].
    std::int32_t skipBase = 0, skipStride = 0;
    double emptyShare = 0;  ///< of the blocks within `occupied`
  };

  static constexpr int kBlock = 8;

  FogLevels(const SplineGrid& map, int degree, int levels, Restriction restriction);

  /// Of a pyramid that was made from a map of so many columns and rows.
  FogLevels(SplinePyramid pyramid, int columns, int rows);

  const SplinePyramid& pyramid() const { return pyramid_; }

  int degree() const { return pyramid_.degree(); }

  int count() const { return pyramid_.levels() + 1; }

  const Level& level(int i) const { return levels_[i]; }

  /// Columns of the map, without padding.
  int columns() const { return columns_; }

  int rows() const { return rows_; }

  /// The cells of the map, in the padded domain's cells of level 0.
  CellRect mapCells() const;

  /// The cells that level i may reach: of the map for the finest, else of the whole domain.
  CellRect cells(int i) const {
    return i == 0 ? mapCells() : CellRect{0, 0, levels_[i].cellsX, levels_[i].cellsY};
  }

  /// The map's coefficients, without padding.
  SplineGrid map() const;

  std::span<const float> values() const { return values_; }

  std::span<const std::int32_t> skips() const { return skips_; }

  /// False when offsets do not fit in 31 bits: then only double walks can be used.
  bool fits() const { return fits_; }

 private:
  void add(const SplineGrid& grid);
  void findEmpty(Level& level, const SplineGrid& grid, const CellRect& reach);

  SplinePyramid pyramid_;
  int columns_ = 0, rows_ = 0;
  std::vector<Level> levels_;
  std::vector<float> values_;
  std::vector<std::int32_t> skips_;
  bool fits_ = true;
};

}  // namespace volute
