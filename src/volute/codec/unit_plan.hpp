// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstdint>

#include "volute/codec/block_grid.hpp"

namespace volute {

/// How the blocks of a sequence are shared out: a unit is some layers of blocks (16 frames x 16
/// slices) of one row. Its blocks follow each other in the order of blocks, and so do units. What
/// is summed up in floating point is so for each layer, then over layers, so that sums do not
/// depend on how many layers a unit has.
class UnitPlan {
 public:
  struct Unit {
    int row = 0;
    int firstLayer = 0, endLayer = 0;  ///< of the row
  };

  UnitPlan() = default;

  UnitPlan(const BlockGrid& grid, int layersAUnit)
      : rows_(grid.counts()[0]),
        layers_(grid.counts()[1]),
        layersAUnit_(layersAUnit),
        blocksALayer_(static_cast<std::size_t>(grid.counts()[2]) * grid.counts()[3]) {}

  std::int64_t count() const { return std::int64_t{rows_} * unitsARow(); }

  std::int64_t unitsARow() const { return (layers_ + layersAUnit_ - 1) / layersAUnit_; }

  Unit unit(std::int64_t number) const {
    const int first = static_cast<int>(number % unitsARow()) * layersAUnit_;
    return {static_cast<int>(number / unitsARow()), first, std::min(layers_, first + layersAUnit_)};
  }

  /// Layers of all rows, as they are numbered for sums.
  std::size_t layers() const { return static_cast<std::size_t>(rows_) * layers_; }

  std::size_t firstLayer(const Unit& unit) const {
    return static_cast<std::size_t>(unit.row) * layers_ + unit.firstLayer;
  }

  std::size_t blocksALayer() const { return blocksALayer_; }

  std::size_t firstBlock(const Unit& unit) const { return firstLayer(unit) * blocksALayer_; }

  std::size_t blocks(const Unit& unit) const {
    return static_cast<std::size_t>(unit.endLayer - unit.firstLayer) * blocksALayer_;
  }

 private:
  int rows_ = 0, layers_ = 0;
  int layersAUnit_ = 1;
  std::size_t blocksALayer_ = 0;
};

}  // namespace volute
