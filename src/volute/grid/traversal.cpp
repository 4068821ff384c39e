// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/traversal.hpp"

#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

int cellIndex(const CellGrid& grid, int axis, double coordinate) {
  const double index = (coordinate - grid.origin[axis]) / grid.cell[axis];
  return index > 0 ? static_cast<int>(std::min(index, grid.count[axis] - 1.0)) : 0;
}

}  // namespace

Box3 CellGrid::bounds() const {
  return {origin, Vec3(plane(0, count[0]), plane(1, count[1]), plane(2, count[2]))};
}

std::array<int, 3> CellGrid::cellAt(const Vec3& point) const {
  return {cellIndex(*this, 0, point.x()), cellIndex(*this, 1, point.y()),
          cellIndex(*this, 2, point.z())};
}

bool enterCells(const CellGrid& grid, const CellRange& range, const Segment& segment,
                CellEntry& entry) {
  if (range.empty())
    return false;
  entry.begin = segment.begin;
  entry.end = segment.end;
  for (int axis = 0; axis < 3; ++axis) {
    const double direction = segment.direction[axis];
    const double origin = segment.origin[axis];
    double low = grid.plane(axis, range.begin[axis]);
    double high = grid.plane(axis, range.end[axis]);
    if (range.found) {
      const double slack = kRounding * (std::abs(origin) + std::abs(low) + std::abs(high));
      low -= slack, high += slack;
    }
    if (direction == 0) {
      if (!(origin >= low && origin <= high))
        return false;
      entry.cell[axis] = cellIndex(grid, axis, origin);
      if (range.found)
        entry.cell[axis] = std::clamp(entry.cell[axis], range.begin[axis], range.end[axis] - 1);
      if (entry.cell[axis] < range.begin[axis] || entry.cell[axis] >= range.end[axis])
        return false;
      entry.step[axis] = 0;
      entry.crossing[axis] = kInfinity;
      continue;
    }
    entry.step[axis] = direction > 0 ? 1 : -1;
    const double in = ((direction > 0 ? low : high) - origin) / direction;
    const double out = ((direction > 0 ? high : low) - origin) / direction;
    if (!(in <= entry.begin))
      entry.begin = in;  // so that NaN, too, ends in a miss
    if (!(out >= entry.end))
      entry.end = out;
    if (!(entry.begin < entry.end))
      return false;
  }
  if (!(entry.begin < entry.end))
    return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (entry.step[axis] == 0)
      continue;
    int& index = entry.cell[axis];
    const double start = segment.origin[axis] + entry.begin * segment.direction[axis];
    index = std::clamp(cellIndex(grid, axis, start), range.begin[axis], range.end[axis] - 1);
    // `start` is rounded. A cell too early costs an empty step; one too late would be wrong for
    // nearly parallel rays.
    const int before = index - entry.step[axis];
    if (before >= range.begin[axis] && before < range.end[axis] &&
        CellEntry::leaves(grid, segment, axis, before) > entry.begin) {
      index = before;
    }
    entry.crossing[axis] = CellEntry::leaves(grid, segment, axis, index);
  }
  return true;
}

}  // namespace volute
