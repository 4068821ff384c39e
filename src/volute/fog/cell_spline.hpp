// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/math/polynomial.hpp"
#include "volute/wavelet/spline_pyramid.hpp"

namespace volute {

/// A spline within one cell, as monomials: f(u, v) = sum of m[a][b] u^a v^b, 0 <= u, v <= 1.
struct CellSpline {
  int degree = 1;
  double m[4][4]{};

  /// Cell (x, y) of a grid; M = B' c B with B the pieces of the splines that touch it.
  CellSpline(const SplineGrid& grid, int degree, int x, int y);

  /// The product of the i-th and the j-th spline that touch a cell.
  static CellSpline basis(int degree, int i, int j);

  double operator()(double u, double v) const;

  /// f(u + du t, v + dv t) as a polynomial of t, of degree 2 * degree.
  Polynomial along(double u, double du, double v, double dv) const;

  /// The mean of f on the line from (um - du/2, vm - dv/2) to (um + du/2, vm + dv/2), exactly: the
  /// sum over k of D^2k f(um, vm) / ((2k + 1)! 4^k), D = du d/du + dv d/dv.
  double mean(double um, double vm, double du, double dv) const;

  /// The largest magnitude of the coefficients.
  double largest() const { return largest_; }

 private:
  CellSpline() = default;

  double largest_ = 0;
};

}  // namespace volute
