// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <utility>

#include "volute/fds/fds_grid.hpp"

namespace volute {

/// Calls visit(cell) for the cell that holds a point, or all that touch it where it lies on their
/// planes.
/// @param own  the cell that holds it
template <class Visit>
void forTouchingCells(const FdsLattice& lattice, const Vec3& point, const std::array<int, 3>& own,
                      Visit&& visit) {
  constexpr double kNothing = 1e-6;  // of a cell: the point is on a plane
  std::array<int, 3> first{}, last{}, cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = lattice.planes[axis];
    const int in = own[axis];
    const double begin = planes[in], end = planes[in + 1], near = kNothing * (end - begin);
    first[axis] = in > 0 && point[axis] - begin < near ? in - 1 : in;
    last[axis] = in + 1 < lattice.cells(axis) && end - point[axis] < near ? in + 1 : in;
  }
  for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2]) {
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1]) {
      for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0]) visit(std::as_const(cell));
    }
  }
}

template <class Visit>
void forTouchingCells(const FdsLattice& lattice, const Vec3& point, Visit&& visit) {
  std::array<int, 3> own;
  for (int axis = 0; axis < 3; ++axis) own[axis] = cellBetween(lattice.planes[axis], point[axis]);
  forTouchingCells(lattice, point, own, visit);
}

}  // namespace volute
