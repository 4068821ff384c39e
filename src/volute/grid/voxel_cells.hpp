// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/math/cubic.hpp"
#include "volute/math/quadrature.hpp"

// What media and surfaces of voxels share: their cells, and what is interpolated in one. Not for
// others.

namespace volute::voxels {

/// Voxels, or the cells between their centres.
inline CellGrid cellsOf(const BrickSlice& slice) {
  const Vec3 voxel = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  if (slice.basis() == Basis::kBox)
    return {slice.bounds().min, voxel, {slice.x(), slice.y(), slice.z()}};
  // Cell i lies between the centres of voxels i - 2 and i - 1.
  if (slice.basis() == Basis::kCubic) {
    return {slice.bounds().min - 1.5 * voxel, voxel, {slice.x() + 3, slice.y() + 3, slice.z() + 3}};
  }
  // Cell i lies between the centres of voxels i - 1 and i.
  return {slice.bounds().min - 0.5 * voxel, voxel, {slice.x() + 1, slice.y() + 1, slice.z() + 1}};
}

/// The cells that voxels of stored bricks reach into.
inline CellRange occupiedCells(const BrickSlice& slice, const CellGrid& cells) {
  CellRange range{cells.count, {0, 0, 0}};
  const int reach = slice.basis() == Basis::kBox ? 0 : slice.basis() == Basis::kTrilinear ? 1 : 3;
  for (const BrickSlice::Entry& entry : slice.entries()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int first = entry.place[axis] * BrickSlice::kSide;
      range.begin[axis] = std::min(range.begin[axis], first);
      range.end[axis] =
          std::max(range.end[axis], std::min(first + BrickSlice::kSide + reach, cells.count[axis]));
    }
  }
  return range;
}

/// The eight voxels around a trilinear cell, x fastest.
inline constexpr std::array<std::array<int, 3>, 8> kCorners{{{-1, -1, -1},
                                                             {0, -1, -1},
                                                             {-1, 0, -1},
                                                             {0, 0, -1},
                                                             {-1, -1, 0},
                                                             {0, -1, 0},
                                                             {-1, 0, 0},
                                                             {0, 0, 0}}};

/// Where a point is in its cell: from 0 to 1 across it on each axis, rounding kept inside.
inline Vec3 placeInCell(const CellGrid& grid, const std::array<int, 3>& cell, const Vec3& point) {
  Vec3 place;
  for (int axis = 0; axis < 3; ++axis) {
    place[axis] =
        std::clamp((point[axis] - grid.plane(axis, cell[axis])) / grid.cell[axis], 0.0, 1.0);
  }
  return place;
}

/// A ray inside one cell: its place is linear in u.
struct InCell {
  Vec3 at;        ///< where u = 0
  Vec3 velocity;  ///< per metre

  InCell(const CellGrid& grid, const std::array<int, 3>& cell, const Segment& segment, double begin,
         double end)
      : at(placeInCell(grid, cell, segment.at(begin))),
        velocity((placeInCell(grid, cell, segment.at(end)) - at) / (end - begin)) {}
};

/// The share of each corner at a place in the cell.
inline std::array<double, 8> cornerShares(const Vec3& place) {
  std::array<double, 8> shares;
  for (int i = 0; i < 8; ++i) {
    shares[i] = (i & 1 ? place.x() : 1 - place.x()) * (i & 2 ? place.y() : 1 - place.y()) *
                (i & 4 ? place.z() : 1 - place.z());
  }
  return shares;
}

/// The corners' line integrals over `length`: shares are cubic in u, so two Gauss points are exact.
inline std::array<double, 8> cornerIntegrals(const InCell& ray, double length) {
  std::array<double, 8> sum{};
  const GaussRule rule = gaussRule(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const double u = 0.5 * length * (1 + rule.nodes[k]);
    const auto shares = cornerShares(ray.at + u * ray.velocity);
    for (int i = 0; i < 8; ++i) sum[i] += 0.5 * length * rule.weights[k] * shares[i];
  }
  return sum;
}

/// The interpolated value along the ray as a polynomial of u.
inline Cubic cornerCubic(const InCell& ray, std::array<double, 8> v) {
  // To v[0] + v[1] x + v[2] y + v[3] xy + v[4] z ..., then by Horner's rule with linear functions
  // for x, y, z.
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 8; ++i) {
      if (i & (1 << axis))
        v[i] -= v[i ^ (1 << axis)];
    }
  }
  const auto times = [](const Cubic& p, double a, double b) {  // p * (a + b u)
    return Cubic{
        {a * p.c[0], a * p.c[1] + b * p.c[0], a * p.c[2] + b * p.c[1], a * p.c[3] + b * p.c[2]}};
  };
  std::array<Cubic, 8> p;
  for (int i = 0; i < 8; ++i) p[i].c[0] = v[i];
  for (int axis = 2; axis >= 0; --axis) {
    for (int i = 0; i < (1 << axis); ++i)
      p[i] += times(p[i | (1 << axis)], ray.at[axis], ray.velocity[axis]);
  }
  return p[0];
}

}  // namespace volute::voxels
