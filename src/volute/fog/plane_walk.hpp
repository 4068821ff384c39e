// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {

/// Cells x0..x1-1 by y0..y1-1.
struct CellRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// A ray seen from above: x = ox + dx s, y = oy + dy s in cells, s in metres along the ray in
/// space.
struct PlaneRay {
  double ox = 0, oy = 0;
  double dx = 0, dy = 0;  ///< [1/m]; both zero for a vertical ray
};

/// One axis of a walk over cells [from, to).
struct PlaneAxis {
  double o = 0, d = 0;
  int from = 0, to = 0;
  int cell = 0;
  double crossing = 0;  ///< where the ray leaves the cell; infinite when it never does

  /// Cuts begin and end to where the ray is within the cells; false when it never is.
  bool clip(double& begin, double& end) const {
    if (d == 0)
      return o >= from && o <= to;
    const double a = (from - o) / d, b = (to - o) / d;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
    return begin < end;
  }

  double at(double s) const { return d == 0 ? o : o + d * s; }

  /// A ray in a plane between cells runs through the upper ones; one that enters on a plane goes on
  /// into the cell ahead.
  void enter(double begin) {
    const double p = at(begin);
    const double index = d < 0 ? std::ceil(p) - 1 : std::floor(p);
    cell = static_cast<int>(std::clamp(index, double(from), double(to - 1)));
    advanceCrossing();
  }

  /// From the plane itself, so that nothing adds up.
  void advanceCrossing() {
    crossing = d == 0 ? std::numeric_limits<double>::infinity() : (cell + (d > 0) - o) / d;
  }

  /// False when the ray has left the cells.
  bool step() {
    cell += d > 0 ? 1 : -1;
    advanceCrossing();
    return cell >= from && cell < to;
  }
};

/// Calls visit(cellX, cellY, begin, end) for each cell of `rect` that the ray passes between begin
/// and end, front to back, with begin < end. Either may be infinite; a vertical ray visits one
/// cell.
template <class Visit>
void walkCells(const PlaneRay& ray, const CellRect& rect, double begin, double end, Visit&& visit) {
  PlaneAxis x{ray.ox, ray.dx, rect.x0, rect.x1}, y{ray.oy, ray.dy, rect.y0, rect.y1};
  if (rect.empty() || !(begin < end) || !x.clip(begin, end) || !y.clip(begin, end))
    return;
  x.enter(begin);
  y.enter(begin);
  while (begin < end) {
    PlaneAxis& next = y.crossing < x.crossing ? y : x;
    const double leave = std::min(next.crossing, end);
    if (leave > begin) {
      visit(x.cell, y.cell, begin, leave);
      begin = leave;
    }
    if (!next.step())
      return;
  }
}

}  // namespace volute
