// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_levels.hpp"

#include <algorithm>
#include <limits>

namespace volute {
namespace {

/// Squares of 2^k blocks that hold nothing, for one k.
struct EmptySquares {
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> empty;

  EmptySquares(int c, int r) : columns(c), rows(r), empty(static_cast<std::size_t>(c) * r, 1) {}

  std::uint8_t& at(int x, int y) { return empty[static_cast<std::size_t>(y) * columns + x]; }

  std::uint8_t at(int x, int y) const { return empty[static_cast<std::size_t>(y) * columns + x]; }

  /// Squares of twice the side, empty where all of their parts are.
  EmptySquares halved() const {
    EmptySquares out((columns + 1) / 2, (rows + 1) / 2);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) out.at(x / 2, y / 2) &= at(x, y);
    return out;
  }
};

int blocks(int cells) {
  return (cells + FogLevels::kBlock - 1) / FogLevels::kBlock;
}

/// Blocks with a cell that a coefficient other than zero reaches; widens `occupied` to them.
EmptySquares emptyBlocks(const SplineGrid& grid, int degree, CellRect& occupied) {
  EmptySquares squares(blocks(grid.columns + degree), blocks(grid.rows + degree));
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      if (grid.at(i, j) == 0)
        continue;
      occupied = {std::min(occupied.x0, i), std::min(occupied.y0, j),
                  std::max(occupied.x1, i + degree + 1), std::max(occupied.y1, j + degree + 1)};
      // A support of at most 4 cells touches at most two blocks on each axis.
      for (int y : {j, j + degree})
        for (int x : {i, i + degree}) squares.at(x / FogLevels::kBlock, y / FogLevels::kBlock) = 0;
    }
  }
  return squares;
}

}  // namespace

FogLevels::FogLevels(const SplineGrid& map, int degree, int levels, Restriction restriction)
    : FogLevels(SplinePyramid(map, degree, levels, restriction), map.columns, map.rows) {}

FogLevels::FogLevels(SplinePyramid pyramid, int columns, int rows)
    : pyramid_(std::move(pyramid)), columns_(columns), rows_(rows) {
  double size = 0;
  for (int i = 0; i <= pyramid_.levels(); ++i) {
    const SplineGrid& grid = pyramid_.level(i);
    size += (grid.columns + 2.0 * degree()) * (grid.rows + 2.0 * degree());
  }
  fits_ = size < std::numeric_limits<std::int32_t>::max() / 8;
  // A ray that rounding carries past the last cell reads one cell further, before or behind.
  const std::size_t spare = fits_ ? pyramid_.level(0).columns + 2 * degree() + 8 : 0;
  values_.reserve(static_cast<std::size_t>(fits_ ? size : 0) + 2 * spare);
  values_.resize(spare);
  for (int i = 0; i <= pyramid_.levels(); ++i) add(pyramid_.level(i));
  values_.resize(values_.size() + spare);
}

void FogLevels::add(const SplineGrid& grid) {
  const int d = degree();
  Level level;
  level.cellsX = grid.columns + d;
  level.cellsY = grid.rows + d;
  level.stride = grid.columns + 2 * d;
  level.base = static_cast<std::int32_t>(values_.size());
  if (fits_) {
    values_.resize(values_.size() + static_cast<std::size_t>(level.stride) * (grid.rows + 2 * d));
    for (int j = 0; j < grid.rows; ++j) {
      float* row = &values_[level.base + static_cast<std::size_t>(j + d) * level.stride + d];
      const double* from = &grid.c[static_cast<std::size_t>(j) * grid.columns];
      for (int i = 0; i < grid.columns; ++i) row[i] = static_cast<float>(from[i]);
    }
  }
  const bool finest = levels_.empty();
  findEmpty(level, grid, finest ? mapCells() : CellRect{0, 0, level.cellsX, level.cellsY});
  levels_.push_back(level);
}

void FogLevels::findEmpty(Level& level, const SplineGrid& grid, const CellRect& reach) {
  level.occupied = {level.cellsX, level.cellsY, 0, 0};
  std::vector<EmptySquares> sizes{emptyBlocks(grid, degree(), level.occupied)};
  level.occupied.x1 = std::min(level.occupied.x1 + 1, reach.x1);
  level.occupied.y1 = std::min(level.occupied.y1 + 1, reach.y1);
  while (sizes.back().columns > 1 || sizes.back().rows > 1) sizes.push_back(sizes.back().halved());
  level.skipBase = static_cast<std::int32_t>(skips_.size());
  level.skipStride = sizes[0].columns;
  int inside = 0, empty = 0;
  const CellRect& rect = level.occupied;
  for (int y = 0; y < sizes[0].rows; ++y) {
    for (int x = 0; x < sizes[0].columns; ++x) {
      int side = 0;
      for (std::size_t k = 0; k < sizes.size() && sizes[k].at(x >> k, y >> k); ++k)
        side = kBlock << k;
      skips_.push_back(side);
      const bool within = x >= rect.x0 / kBlock && x <= (rect.x1 - 1) / kBlock &&
                          y >= rect.y0 / kBlock && y <= (rect.y1 - 1) / kBlock;
      inside += within;
      empty += within && side > 0;
    }
  }
  level.emptyShare = inside > 0 ? double(empty) / inside : 1;
}

CellRect FogLevels::mapCells() const {
  const int x = pyramid_.paddingX().offset, y = pyramid_.paddingY().offset;
  return {x, y, x + columns_ + degree(), y + rows_ + degree()};
}

SplineGrid FogLevels::map() const {
  const CellRect cells = mapCells();
  SplineGrid out(columns_, rows_);
  for (int j = 0; j < rows_; ++j)
    for (int i = 0; i < columns_; ++i)
      out.at(i, j) = pyramid_.level(0).at(cells.x0 + i, cells.y0 + j);
  return out;
}

}  // namespace volute
