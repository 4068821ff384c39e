// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/cell_spline.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

/// Which pieces a degree has, without making them each time.
const SplinePieces& piecesOf(int degree) {
  static const SplinePieces table[] = {splinePieces(0), splinePieces(1), splinePieces(2),
                                       splinePieces(3)};
  return table[degree];
}

}  // namespace

CellSpline::CellSpline(const SplineGrid& grid, int splineDegree, int x, int y)
    : degree(splineDegree) {
  const SplinePieces& pieces = piecesOf(degree);
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; j <= degree; ++j) {
      const double c = grid.orZero(x - degree + i, y - degree + j);
      if (c == 0)
        continue;
      largest_ = std::max(largest_, std::abs(c));
      for (int a = 0; a <= degree; ++a)
        for (int b = 0; b <= degree; ++b) m[a][b] += c * pieces[i][a] * pieces[j][b];
    }
  }
}

CellSpline CellSpline::basis(int degree, int i, int j) {
  CellSpline cell;
  cell.degree = degree;
  cell.largest_ = 1;
  const SplinePieces& pieces = piecesOf(degree);
  for (int a = 0; a <= degree; ++a)
    for (int b = 0; b <= degree; ++b) cell.m[a][b] = pieces[i][a] * pieces[j][b];
  return cell;
}

double CellSpline::operator()(double u, double v) const {
  double sum = 0;
  for (int a = degree; a >= 0; --a) {
    double row = 0;
    for (int b = degree; b >= 0; --b) row = row * v + m[a][b];
    sum = sum * u + row;
  }
  return sum;
}

Polynomial CellSpline::along(double u, double du, double v, double dv) const {
  Polynomial sum;
  for (int a = degree; a >= 0; --a) {
    Polynomial row;
    for (int b = degree; b >= 0; --b) {
      row = row.timesLine(v, dv);
      row.c[0] += m[a][b];
    }
    sum = sum.timesLine(u, du);
    sum += row;
  }
  return sum;
}

double CellSpline::mean(double um, double vm, double du, double dv) const {
  if (degree == 0)
    return m[0][0];
  if (degree == 1)
    return (*this)(um, vm) + m[1][1] * du * dv / 12;
  const Polynomial line = along(um, du, vm, dv);  // t from -1/2 to 1/2
  double sum = 0;
  double power = 1;
  for (int k = 0; 2 * k <= 2 * degree; ++k, power /= 4) sum += line.c[2 * k] * power / (2 * k + 1);
  return sum;
}

}  // namespace volute
