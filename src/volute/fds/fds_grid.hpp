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

/// Meshes that are not farther apart are one [m], unless that is more than a twentieth of a cell.
inline constexpr double kMeshSeparation = 1e-3;

/// Planes x, y, z between cells [m], strictly ascending, two at least on each axis.
using FdsPlanes = std::array<std::vector<double>, 3>;

/// Rectilinear cells with values in them or at their corners: a mesh, the part of it that a 3D
/// slice covers, or a 2D slice as a layer one cell thick.
struct FdsLattice {
  int mesh = 0;  ///< place in SmvIndex::meshes
  FdsPlanes planes;
  bool nodal = false;  ///< values at corners, trilinear between them; else constant in each cell
  int thinAxis = -1;   ///< of a 2D slice: across it
  double place = 0;    ///< where on that axis its values lie [m]

  int cells(int axis) const { return static_cast<int>(planes[axis].size()) - 1; }

  std::size_t cellCount() const { return static_cast<std::size_t>(cells(0)) * cells(1) * cells(2); }

  std::size_t nodeCount() const { return planes[0].size() * planes[1].size() * planes[2].size(); }

  std::size_t valueCount() const { return nodal ? nodeCount() : cellCount(); }

  std::size_t cellAt(const std::array<int, 3>& cell) const {
    return (static_cast<std::size_t>(cell[2]) * cells(1) + cell[1]) * cells(0) + cell[0];
  }

  Box3 bounds() const {
    return {Vec3(planes[0].front(), planes[1].front(), planes[2].front()),
            Vec3(planes[0].back(), planes[1].back(), planes[2].back())};
  }
};

/// Where the eight corners of a cell are among the values of a nodal lattice.
struct NodePlaces {
  explicit NodePlaces(const FdsLattice& lattice)
      : strideY(lattice.planes[0].size()), strideZ(strideY * lattice.planes[1].size()) {}

  std::size_t first(const std::array<int, 3>& cell) const {
    return cell[2] * strideZ + cell[1] * strideY + static_cast<std::size_t>(cell[0]);
  }

  std::size_t offset(int corner) const {
    return (corner & 1) + ((corner >> 1) & 1) * strideY + (corner >> 2) * strideZ;
  }

  std::size_t strideY;
  std::size_t strideZ;
};

/// The cell between planes that holds a place; one on a plane belongs to the upper cell, one
/// outside to the outermost.
inline int cellBetween(const std::vector<double>& planes, double place) {
  const auto upper = std::upper_bound(planes.begin() + 1, planes.end() - 1, place);
  return static_cast<int>(upper - planes.begin()) - 1;
}

/// Calls visit(cell, begin, end) for each cell between the planes that the segment's points from
/// `begin` to `end` pass, front to back, with begin < end and each begin the end before it. The
/// points lie inside the planes but for rounding. After Amanatides and Woo 1987, with each crossing
/// from its own plane, so that nothing adds up, and all axes advanced alike: which one is next
/// cannot be predicted. A ray in a plane runs through the upper cells.
template <class Visit>
void traversePlanes(const FdsPlanes& planes, const Segment& segment, double begin, double end,
                    Visit&& visit) {
  struct Axis {
    const double* planes;
    int last;  // plane
    int step;
    int ahead;  // 1 when the next plane is the cell's upper one
    double origin;
    double inverse;

    double crossing(int cell) const {
      return (planes[std::clamp(cell + ahead, 0, last)] - origin) * inverse;
    }
  };

  std::array<Axis, 3> axes;
  std::array<int, 3> cell;
  std::array<double, 3> next;
  for (int a = 0; a < 3; ++a) {
    const double direction = segment.direction[a];
    const double origin = segment.origin[a];
    const double place = direction == 0 ? origin : origin + begin * direction;
    const int step = direction > 0 ? 1 : direction < 0 ? -1 : 0;
    axes[a] = {planes[a].data(), static_cast<int>(planes[a].size()) - 1, step, step > 0 ? 1 : 0,
               origin,           direction == 0 ? 0 : 1 / direction};
    cell[a] = cellBetween(planes[a], place);
    if (step < 0 && cell[a] > 0 && place == planes[a][cell[a]])
      --cell[a];
    next[a] = std::numeric_limits<double>::infinity();
    if (step != 0) {
      next[a] = axes[a].crossing(cell[a]);
      end = std::min(end, axes[a].crossing(step > 0 ? axes[a].last : 0));
    }
  }
  double from = begin;
  while (from < end) {
    const double to = std::min(std::min(next[0], next[1]), std::min(next[2], end));
    if (to > from)
      visit(cell, from, to);
    for (int a = 0; a < 3; ++a) {
      const bool crossed = next[a] <= to;
      cell[a] += crossed ? axes[a].step : 0;
      const double crossing = axes[a].crossing(cell[a]);
      next[a] = crossed ? crossing : next[a];
    }
    from = std::max(from, to);
  }
}

/// Lattices side by side without seams, overlaps or double counts: all their outer planes make a
/// coarse table that says which lattice is where. Outer planes that lie within kMeshSeparation
/// and a twentieth of a cell of each other are one, as in FDS; where lattices overlap, the finest
/// counts, and of equal ones the first.
class FdsGrid {
 public:
  /// kTooLarge when the lattices' outer planes cut space into too many parts.
  /// @param held  empty, or whether each lattice's values are held here: where others are counts as
  ///              outside of the lattices, but for bounds()
  [[nodiscard]] static Result<std::shared_ptr<const FdsGrid>> create(
      std::vector<FdsLattice> lattices, std::vector<bool> held = {});

  std::span<const FdsLattice> lattices() const { return lattices_; }

  /// Whether a lattice has values here.
  bool holds(std::size_t lattice) const { return held_.empty() || held_[lattice]; }

  const Box3& bounds() const { return bounds_; }

  /// The coarse table: its planes, and the lattice of each part between them or -1, x fastest.
  const FdsPlanes& partPlanes() const { return planes_; }

  std::span<const std::int32_t> parts() const { return table_; }

  /// Which lattice a point lies in, or -1.
  int latticeAt(const Vec3& point) const;

  /// Calls visit(lattice, begin, end) for the parts of the segment in lattices, front to back.
  template <class Visit>
  void traverse(const Segment& segment, Visit&& visit) const;

 private:
  std::vector<FdsLattice> lattices_;
  std::vector<bool> held_;  // empty: all
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
                 });
  if (lattice >= 0 && from < until)
    visit(lattice, from, until);
}

}  // namespace volute
