// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/cell_spline.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

SplineGrid numbers(int side) {
  SplineGrid grid(side, side);
  for (double& value : grid.c) value = *rc::gen::inRange(0, 1000) / 1000.0;
  return grid;
}

double share() {
  return *rc::gen::inRange(0, 1001) / 1000.0;
}

TEST(CellSpline, BilinearChordOfTheTextbook) {
  SplineGrid grid(2, 2);
  grid.c = {1, 2, 3, 7};  // f00, f10, f01, f11
  const CellSpline cell(grid, 1, 1, 1);
  EXPECT_DOUBLE_EQ(cell.mean(0.625, 0.25, 0.75, 0.5), 2.6875);
  EXPECT_DOUBLE_EQ(cell.m[1][0], 1);
  EXPECT_DOUBLE_EQ(cell.m[0][1], 2);
  EXPECT_DOUBLE_EQ(cell.m[1][1], 3);
}

RC_GTEST_PROP(CellSpline, IsTheSumOfSplines, ()) {
  const int degree = *rc::gen::inRange(0, 4);
  const SplineGrid grid = numbers(6);
  const int x = *rc::gen::inRange(0, 6 + degree), y = *rc::gen::inRange(0, 6 + degree);
  const double u = share(), v = share();
  double sum = 0;
  const auto wu = splineWeights(degree, u), wv = splineWeights(degree, v);
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; j <= degree; ++j)
      sum += wu[i] * wv[j] * grid.orZero(x - degree + i, y - degree + j);
  RC_ASSERT(std::abs(CellSpline(grid, degree, x, y)(u, v) - sum) < 1e-14);
}

RC_GTEST_PROP(CellSpline, MeanAndLineAreExact, ()) {
  const int degree = *rc::gen::inRange(0, 4);
  const SplineGrid grid = numbers(4);
  const CellSpline cell(grid, degree, degree, degree);
  const double u0 = share(), v0 = share(), du = share() - u0, dv = share() - v0;
  const auto at = [&](double t) { return cell(u0 + t * du, v0 + t * dv); };
  const double expected = gaussIntegral(8, 0.0, 1.0, at);
  RC_ASSERT(std::abs(cell.mean(u0 + du / 2, v0 + dv / 2, du, dv) - expected) < 1e-14);
  const Polynomial along = cell.along(u0, du, v0, dv);
  RC_ASSERT(along.terms() <= 2 * degree + 1);
  RC_ASSERT(std::abs(along.integral(1) - expected) < 1e-14);
  const double t = share();
  RC_ASSERT(std::abs(along(t) - at(t)) < 1e-14);
}

RC_GTEST_PROP(CellSpline, QuadraticClosedForm, ()) {
  const SplineGrid grid = numbers(3);
  const CellSpline cell(grid, 2, 2, 2);
  const double um = share(), vm = share(), du = share(), dv = share();
  const auto& m = cell.m;
  double fuu = 0, fvv = 0, fuv = 0;
  for (int b = 0; b < 3; ++b) {
    fuu += 2 * m[2][b] * std::pow(vm, b);
    fvv += 2 * m[b][2] * std::pow(um, b);
  }
  for (int a = 1; a < 3; ++a)
    for (int b = 1; b < 3; ++b) fuv += a * b * m[a][b] * std::pow(um, a - 1) * std::pow(vm, b - 1);
  const double expected = cell(um, vm) + (fuu * du * du + 2 * fuv * du * dv + fvv * dv * dv) / 24 +
                          m[2][2] * du * du * dv * dv / 80;
  RC_ASSERT(std::abs(cell.mean(um, vm, du, dv) - expected) < 1e-14);
}

/// How many Gauss points a cell of each degree needs: one less is visibly wrong.
TEST(CellSpline, IsOfDegreeTwiceItsOwnAlongARay) {
  for (int degree = 1; degree <= 3; ++degree) {
    SplineGrid grid(4, 4);
    for (std::size_t k = 0; k < grid.c.size(); ++k) grid.c[k] = (k * 7919 % 101) / 101.0;
    const CellSpline cell(grid, degree, 3, 3);
    const auto at = [&](double t) { return cell(t, 1 - 0.9 * t); };
    const double exact = cell.mean(0.5, 0.55, 1, -0.9);
    EXPECT_NEAR(gaussIntegral(degree + 1, 0.0, 1.0, at), exact, 1e-15);
    if (degree > 1) {
      EXPECT_GT(std::abs(gaussIntegral(degree, 0.0, 1.0, at) / exact - 1), 1e-6);
    }
  }
}

}  // namespace
}  // namespace volute
