// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <atomic>
#include <bitset>
#include <cstdint>
#include <memory>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"

// The fast execution of CubicVoxels, apart from the medium.

namespace volute {

/// Bricks of 8^3 cells, each with the coefficients that count in one of its cells: 11 a side, so
/// that the 64 of a cell are always in one brick.
struct CubicGrid {
  static constexpr int kSide = BrickSlice::kSide + 3;
  static constexpr int kCoefficients = kSide * kSide * kSide;

  CubicGrid(std::shared_ptr<const BrickSlice> slice, double emissionScale, double extinctionScale);

  struct Brick {
    std::size_t begin = 0;                    ///< of its coefficients, shape (c, z, y, x)
    std::bitset<BrickSlice::kVoxels> filled;  ///< cells, x fastest, in which one of them is not 0
  };

  /// Calls visit(brick, first of the cell's coefficients in each channel, begin, end) for each cell
  /// on a segment that is not all zero, front to back, until it returns false.
  template <class Visit>
  void traverse(const Segment& segment, Visit&& visit) const;

  int channels() const { return slice->channels(); }

  std::shared_ptr<const BrickSlice> slice;
  double emissionScale, extinctionScale;
  CellGrid cells;
  CellGrid bricks;   ///< the cells of the table
  BrickTable table;  ///< which of `stored`
  std::vector<Brick> stored;
  std::vector<float> coefficients;

  struct Counts {
    std::atomic<std::uint64_t> cells{0}, visited{0};
  };

  std::shared_ptr<Counts> counts = std::make_shared<Counts>();
};

/// The light along one segment.
Radiance marchCubic(const CubicGrid& grid, const Segment& segment);

template <class Visit>
void CubicGrid::traverse(const Segment& segment, Visit&& visit) const {
  std::uint64_t crossed = 0, visited = 0;
  bool on = true;
  table.walk(
      bricks, segment, [&](const BrickPlace& at, std::int32_t which, double begin, double end) {
        ++visited;
        const Brick& brick = stored[static_cast<std::size_t>(which)];
        CellRange range{.found = true};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          range.begin[axis] = at[axis] * BrickSlice::kSide;
          range.end[axis] = std::min(range.begin[axis] + BrickSlice::kSide, cells.count[axis]);
        }
        const Segment within{segment.origin, segment.direction, begin, end};
        traverseCells(cells, range, within, [&](const auto& cell, double from, double to) {
          const int x = cell[0] - range.begin[0], y = cell[1] - range.begin[1],
                    z = cell[2] - range.begin[2];
          if (!on || !brick.filled[static_cast<std::size_t>(
                         (z * BrickSlice::kSide + y) * BrickSlice::kSide + x)])
            return;
          ++crossed;
          on = visit(
              cell,
              &coefficients[brick.begin + static_cast<std::size_t>((z * kSide + y) * kSide + x)],
              from, to);
        });
        return on;
      });
  counts->cells += crossed, counts->visited += visited;
}

}  // namespace volute
