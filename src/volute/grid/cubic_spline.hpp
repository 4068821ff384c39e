// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>

#include "volute/grid/voxel_cells.hpp"
#include "volute/math/polynomial.hpp"

// B-splines of degree 3 in one cell between eight voxel centres, in double. Not for others.

namespace volute::voxels {

/// The coefficients that count in a cell, shape (z, y, x): those of the voxels one beyond its
/// corners on each side.
inline constexpr int kSplineCorners = 64;

/// Of the four B-splines that are not zero at a place 0..1 between two knots; they sum to 1.
inline std::array<double, 4> splineShares(double t) {
  const double s = 1 - t;
  const double t3 = t * t * t, s3 = s * s * s;
  return {s3 / 6, (4 - 6 * t * t + 3 * t3) / 6, (4 - 6 * s * s + 3 * s3) / 6, t3 / 6};
}

/// The value at a place in the cell.
inline double splineValue(std::span<const double, kSplineCorners> c, const Vec3& place) {
  const auto x = splineShares(place.x()), y = splineShares(place.y()), z = splineShares(place.z());
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double* row = &c[16 * k + 4 * j];
      sum += z[k] * y[j] * (x[0] * row[0] + x[1] * row[1] + x[2] * row[2] + x[3] * row[3]);
    }
  }
  return sum;
}

/// The line integral over `length`: of degree 9 in u, so that five Gauss points are exact.
inline double splineIntegral(std::span<const double, kSplineCorners> c, const InCell& ray,
                             double length) {
  return gaussIntegral(5, 0, length,
                       [&](double u) { return splineValue(c, ray.at + u * ray.velocity); });
}

/// The four B-splines of an axis as polynomials of u, at place a + b u.
inline std::array<Cubic, 4> splineCurves(double a, double b) {
  constexpr std::array<Cubic, 4> kOfPlace{
      Cubic{{1 / 6.0, -0.5, 0.5, -1 / 6.0}}, Cubic{{4 / 6.0, 0, -1, 0.5}},
      Cubic{{1 / 6.0, 0.5, 0.5, -0.5}}, Cubic{{0, 0, 0, 1 / 6.0}}};
  std::array<Cubic, 4> curves;
  for (std::size_t i = 0; i < 4; ++i) {
    curves[i] = kOfPlace[i].shifted(a);
    double power = 1;
    for (double& c : curves[i].c) c *= power, power *= b;
  }
  return curves;
}

/// The value along the ray as a polynomial of u, of degree 9.
inline Polynomial splineAlong(std::span<const double, kSplineCorners> c, const InCell& ray) {
  const auto x = splineCurves(ray.at.x(), ray.velocity.x());
  const auto y = splineCurves(ray.at.y(), ray.velocity.y());
  const auto z = splineCurves(ray.at.z(), ray.velocity.z());
  Polynomial sum;
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<double, 7> plane{};
    for (std::size_t j = 0; j < 4; ++j) {
      Cubic row;
      for (std::size_t i = 0; i < 4; ++i) row += x[i] * c[16 * k + 4 * j + i];
      for (std::size_t p = 0; p < 4; ++p) {
        for (std::size_t q = 0; q < 4; ++q) plane[p + q] += y[j].c[p] * row.c[q];
      }
    }
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = 0; q < 7; ++q) sum.c[p + q] += z[k].c[p] * plane[q];
    }
  }
  return sum;
}

}  // namespace volute::voxels
