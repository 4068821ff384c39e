// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "volute/math/box.hpp"
#include "volute/math/cubic.hpp"
#include "volute/math/polynomial.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

TEST(GaussRule, IsExactForItsDegree) {
  for (int n : {2, 3, 4, 5, 8}) {
    for (int degree = 0; degree < 2 * n; ++degree) {
      const double value =
          gaussIntegral(n, 0.0, 2.0, [&](double x) { return std::pow(x, degree); });
      EXPECT_NEAR(value / (std::pow(2.0, degree + 1) / (degree + 1)), 1, 1e-13)
          << n << " points, degree " << degree;
    }
  }
}

TEST(AdaptiveIntegral, MeetsItsToleranceOnASmoothPeakAndAJump) {
  EXPECT_NEAR(adaptiveIntegral([](double x) { return std::exp(-1000 * (x - 0.3) * (x - 0.3)); }, 0,
                               1, 1e-10),
              std::sqrt(M_PI / 1000), 1e-9);
  EXPECT_NEAR(adaptiveIntegral([](double x) { return x < M_PI / 4 ? 1.0 : 0.0; }, 0, 1, 1e-9),
              M_PI / 4, 1e-7);
}

TEST(Box3, IntersectsFromInsideOutsideAndAlongAFace) {
  const Box3 box{Vec3(0, 0, 0), Vec3(1, 2, 3)};
  const Interval through = box.intersect(Vec3(-1, 1, 1), Vec3(1, 0, 0));
  EXPECT_DOUBLE_EQ(through.begin, 1);
  EXPECT_DOUBLE_EQ(through.end, 2);
  EXPECT_TRUE(box.intersect(Vec3(-1, 3, 1), Vec3(1, 0, 0)).empty());
  EXPECT_DOUBLE_EQ(box.intersect(Vec3(0.5, 0, 0), Vec3(0, 0, 1)).length(), 3);  // in a face
  EXPECT_DOUBLE_EQ(box.intersect(Vec3(0.5, 1, 1), Vec3(0, 1, 0)).begin, -1);
}

RC_GTEST_PROP(Cubic, ShiftKeepsTheCurve, ()) {
  auto number = [] { return *rc::gen::inRange(-1000, 1000) / 500.0; };
  const Cubic cubic{{number(), number(), number(), number()}};
  const double shift = number(), s = number();
  RC_ASSERT(std::abs(cubic.shifted(shift)(s) - cubic(s + shift)) < 1e-10);
  const double byGauss = gaussIntegral(2, 0.0, s, [&](double x) { return cubic(x); });
  RC_ASSERT(std::abs(cubic.integral(s) - byGauss) < 1e-10);
}

RC_GTEST_PROP(Polynomial, ShiftIntegralAndProductKeepTheCurve, ()) {
  auto number = [] { return *rc::gen::inRange(-1000, 1000) / 500.0; };
  Polynomial curve;
  for (int i = 0; i < 7; ++i) curve.c[i] = number();
  const double shift = number(), s = number(), a = number(), b = number();
  RC_ASSERT(std::abs(curve.shifted(shift)(s) - curve(s + shift)) < 1e-8);
  RC_ASSERT(std::abs(curve.timesLine(a, b)(s) - curve(s) * (a + b * s)) < 1e-9);
  const double byGauss = gaussIntegral(4, 0.0, s, [&](double x) { return curve(x); });
  RC_ASSERT(std::abs(curve.integral(s) - byGauss) < 1e-10);
}

TEST(Polynomial, TermsAndConversion) {
  const Polynomial line = Cubic{{1, 2, 0, 0}};
  EXPECT_EQ(line.terms(), 2);
  EXPECT_FALSE(line.isConstant());
  EXPECT_TRUE(Polynomial{}.isZero());
  EXPECT_DOUBLE_EQ(line(3), 7);
}

RC_GTEST_PROP(Rotation, TurnsZUprightAndIsTheNearest, ()) {
  const auto any = [] { return *rc::gen::inRange(-1000, 1001) / 1000.0; };
  const Vec3 up(any(), any(), *rc::gen::element(-1.0, 0.0, 1.0));
  RC_PRE(up.norm() > 0);
  const Mat3 turn = turnOfZ(up);
  RC_ASSERT((turn * Vec3::UnitZ() - up.normalized()).norm() < 1e-12);
  RC_ASSERT((turn * turn.transpose() - Mat3::Identity()).norm() < 1e-12);
  RC_ASSERT(std::abs(turn.determinant() - 1) < 1e-12);
  // S is symmetric and positive: turn S has `turn` as its rotation.
  Mat3 lower = Mat3::Zero();
  lower << 1 + any() / 2, 0, 0, any(), 1 + any() / 2, 0, any(), any(), 1 + any() / 2;
  const Mat3 matrix = 100 * turn * lower * lower.transpose();
  RC_ASSERT((nearestRotation(matrix) - turn).norm() < 1e-9);
}

}  // namespace
}  // namespace volute
