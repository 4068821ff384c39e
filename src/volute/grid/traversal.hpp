// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>

#include "volute/math/box.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Cells of one size between the planes origin + i * cell, i = 0..count on each axis (x, y, z) [m].
struct CellGrid {
  Vec3 origin = Vec3::Zero();
  Vec3 cell = Vec3::Ones();
  std::array<int, 3> count{};

  double plane(int axis, int i) const { return origin[axis] + i * cell[axis]; }

  Box3 bounds() const;

  /// The cell of a point inside the bounds. A point on a shared face belongs to the upper cell.
  std::array<int, 3> cellAt(const Vec3& point) const;
};

/// Cells begin..end-1 on each axis.
struct CellRange {
  std::array<int, 3> begin{};
  std::array<int, 3> end{};
  /// A walk over larger cells says that the segment is in the range: their planes may have been
  /// rounded otherwise.
  bool found = false;

  bool empty() const { return begin[0] >= end[0] || begin[1] >= end[1] || begin[2] >= end[2]; }
};

/// Where a ray enters a range of cells, and how it goes on.
struct CellEntry {
  double begin = 0;  ///< the part of the segment inside the range [m]
  double end = 0;
  std::array<int, 3> cell{};  ///< the cell after `begin`
  std::array<int, 3> step{};  ///< -1, 0 or 1
  std::array<double, 3>
      crossing{};  ///< ray parameter of the next plane on each axis; infinite when it is parallel

  /// The parameter at which the ray leaves cell index `i` of `axis`. From the plane itself, so that
  /// nothing adds up.
  static double leaves(const CellGrid& grid, const Segment& segment, int axis, int i) {
    return (grid.plane(axis, segment.direction[axis] > 0 ? i + 1 : i) - segment.origin[axis]) /
           segment.direction[axis];
  }
};

/// False when the segment misses the range. A ray in a plane between cells runs through the upper
/// ones.
bool enterCells(const CellGrid& grid, const CellRange& range, const Segment& segment,
                CellEntry& entry);

/// Calls visit(cell, begin, end) for each cell of the range that the segment passes, front to back,
/// with begin < end and each begin the end before it. The parameters are exact to the rounding of
/// one division (after Amanatides and Woo 1987, but without their running sums).
template <class Visit>
void traverseCells(const CellGrid& grid, const CellRange& range, const Segment& segment,
                   Visit&& visit) {
  CellEntry entry;
  if (!enterCells(grid, range, segment, entry))
    return;
  double begin = entry.begin;
  while (begin < entry.end) {
    int axis = entry.crossing[1] < entry.crossing[0] ? 1 : 0;
    if (entry.crossing[2] < entry.crossing[axis])
      axis = 2;
    const double end = std::min(entry.crossing[axis], entry.end);
    if (end > begin) {
      visit(entry.cell, begin, end);
      begin = end;
    }
    int& index = entry.cell[axis];
    index += entry.step[axis];
    if (index < range.begin[axis] || index >= range.end[axis])
      return;
    entry.crossing[axis] = CellEntry::leaves(grid, segment, axis, index);
  }
}

}  // namespace volute
