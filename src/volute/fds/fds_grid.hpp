// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/box.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Planes x, y, z between cells [m], strictly ascending, two at least on each axis.
using FdsPlanes = std::array<std::vector<double>, 3>;

/// Rectilinear cells with values in them or at their corners: a mesh, the part of it that a 3D
/// slice covers, or a 2D slice as a layer one cell thick.
struct FdsLattice {
  int mesh = 0;  ///< place in SmvIndex::meshes
  FdsPlanes planes;
  bool nodal = false;  ///< values at corners, trilinear between them; else constant in each cell

  int cells(int axis) const { return static_cast<int>(planes[axis].size()) - 1; }

  std::size_t cellCount() const { return static_cast<std::size_t>(cells(0)) * cells(1) * cells(2); }

  std::size_t valueCount() const {
    return nodal ? planes[0].size() * planes[1].size() * planes[2].size() : cellCount();
  }

  std::size_t cellAt(const std::array<int, 3>& cell) const {
    return (static_cast<std::size_t>(cell[2]) * cells(1) + cell[1]) * cells(0) + cell[0];
  }

  Box3 bounds() const {
    return {Vec3(planes[0].front(), planes[1].front(), planes[2].front()),
            Vec3(planes[0].back(), planes[1].back(), planes[2].back())};
  }
};

/// The cell between planes that holds a place; one on a plane belongs to the upper cell, one
/// outside to the outermost.
inline int cellBetween(const std::vector<double>& planes, double place) {
  const auto upper = std::upper_bound(planes.begin() + 1, planes.end() - 1, place);
  return static_cast<int>(upper - planes.begin()) - 1;
}

/// Calls visit(cell, begin, end) for each cell between the planes that the segment's points from
/// `begin` to `end` pass, front to back, with begin < end and each begin the end before it; stops
/// when visit returns false. The points lie inside the planes but for rounding. After Amanatides
/// and Woo 1987, with each crossing from its own plane, so that nothing adds up. A ray in a plane
/// runs through the upper cells.
template <class Visit>
void traversePlanes(const FdsPlanes& planes, const Segment& segment, double begin, double end,
                    Visit&& visit) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::array<int, 3> cell;
  std::array<int, 3> step;
  std::array<double, 3> crossing;
  std::array<double, 3> inverse;
  for (int axis = 0; axis < 3; ++axis) {
    const double direction = segment.direction[axis];
    const double place =
        direction == 0 ? segment.origin[axis] : segment.origin[axis] + begin * direction;
    cell[axis] = cellBetween(planes[axis], place);
    step[axis] = direction > 0 ? 1 : direction < 0 ? -1 : 0;
    inverse[axis] = direction == 0 ? 0 : 1 / direction;
    if (direction < 0 && cell[axis] > 0 && place == planes[axis][cell[axis]])
      --cell[axis];
    crossing[axis] =
        direction == 0
            ? kNever
            : (planes[axis][cell[axis] + (direction > 0 ? 1 : 0)] - segment.origin[axis]) *
                  inverse[axis];
  }
  double from = begin;
  while (from < end) {
    int axis = crossing[1] < crossing[0] ? 1 : 0;
    if (crossing[2] < crossing[axis])
      axis = 2;
    const double to = std::min(crossing[axis], end);
    if (to > from) {
      if (!visit(cell, from, to))
        return;
      from = to;
    }
    int& index = cell[axis];
    index += step[axis];
    if (index < 0 || index + 1 >= static_cast<int>(planes[axis].size())) {
      // The outermost cell takes what rounding leaves over.
      index -= step[axis];
      crossing[axis] = kNever;
      if (crossing[0] == kNever && crossing[1] == kNever && crossing[2] == kNever) {
        if (end > from)
          visit(cell, from, end);
        return;
      }
      continue;
    }
    crossing[axis] =
        (planes[axis][index + (step[axis] > 0 ? 1 : 0)] - segment.origin[axis]) * inverse[axis];
  }
}

/// Lattices side by side without seams, overlaps or double counts: all their outer planes make a
/// coarse table that says which lattice is where. Outer planes that lie within 1e-4 of a cell of
/// each other are one (.smv files give five decimals); where lattices overlap, the finest counts,
/// and of equal ones the first.
class FdsGrid {
 public:
  /// kTooLarge when the lattices' outer planes cut space into too many parts.
  [[nodiscard]] static Result<std::shared_ptr<const FdsGrid>> create(
      std::vector<FdsLattice> lattices);

  std::span<const FdsLattice> lattices() const { return lattices_; }

  const Box3& bounds() const { return bounds_; }

  /// Which lattice a point lies in, or -1.
  int latticeAt(const Vec3& point) const;

  /// Calls visit(lattice, begin, end) for the parts of the segment in lattices, front to back.
  template <class Visit>
  void traverse(const Segment& segment, Visit&& visit) const;

 private:
  std::vector<FdsLattice> lattices_;
  Box3 bounds_;
  FdsPlanes planes_;                 // of the table
  std::vector<std::int32_t> table_;  // lattice of each part, or -1; x fastest
};

template <class Visit>
void FdsGrid::traverse(const Segment& segment, Visit&& visit) const {
  const Interval inside =
      bounds_.intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  if (inside.empty())
    return;
  const std::size_t strideY = planes_[0].size() - 1;
  const std::size_t strideZ = strideY * (planes_[1].size() - 1);
  int lattice = -1;
  double from = inside.begin;
  double until = inside.begin;
  traversePlanes(planes_, segment, inside.begin, inside.end,
                 [&](const std::array<int, 3>& part, double begin, double end) {
                   const int here = table_[part[2] * strideZ + part[1] * strideY + part[0]];
                   if (here != lattice) {
                     if (lattice >= 0)
                       visit(lattice, from, begin);
                     lattice = here;
                     from = begin;
                   }
                   until = end;
                   return true;
                 });
  if (lattice >= 0 && from < until)
    visit(lattice, from, until);
}

}  // namespace volute
