// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "volute/math/box.hpp"
#include "volute/math/cubic.hpp"
#include "volute/math/eigen.hpp"
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
  lower = Mat3(1 + any() / 2, 0, 0, any(), 1 + any() / 2, 0, any(), any(), 1 + any() / 2);
  const Mat3 matrix = 100 * turn * lower * lower.transpose();
  RC_ASSERT((nearestRotation(matrix) - turn).norm() < 1e-9);
}

/// What Volute's vectors and Eigen's say of the same numbers.
template <class T, int N>
void expectAsEigen(const VecN<T, N>& v, const Eigen::Matrix<T, N, 1>& expected, T within = 0) {
  for (int i = 0; i < N; ++i)
    RC_ASSERT(std::abs(v[i] - expected[i]) <= within * (1 + std::abs(expected[i])));
}

RC_GTEST_PROP(Vectors, SayWhatEigenSays, ()) {
  const auto any = [] { return *rc::gen::inRange(-4000, 4001) / 1000.0; };
  const Vec3 a(any(), any(), any()), b(any(), any(), any());
  const double s = any();
  const auto ea = asEigen(a), eb = asEigen(b);
  expectAsEigen<double, 3>(a + s * b - b / 3.0, ea + s * eb - eb / 3.0);
  expectAsEigen<double, 3>(a.cross(b), ea.cross(eb));
  expectAsEigen<double, 3>(a.cwiseProduct(b), ea.cwiseProduct(eb));
  expectAsEigen<double, 3>(a.cwiseMin(b), ea.cwiseMin(eb));
  expectAsEigen<double, 3>(a.cwiseMax(b), ea.cwiseMax(eb));
  expectAsEigen<double, 3>(-a.cwiseAbs(), -ea.cwiseAbs());
  expectAsEigen<double, 3>(a.normalized(), ea.normalized());
  expectAsEigen<double, 2>(a.head<2>(), ea.head<2>());
  RC_ASSERT(a.dot(b) == ea.dot(eb));
  RC_ASSERT(a.norm() == ea.norm());
  RC_ASSERT(a.sum() == ea.sum() && a.prod() == ea.prod());
  RC_ASSERT(a.minCoeff() == ea.minCoeff() && a.maxCoeff() == ea.maxCoeff());
  RC_ASSERT((a.array() < b.array()).count() == (ea.array() < eb.array()).count());
  RC_ASSERT((a == b) == (ea == eb));
  RC_PRE(a.norm() > 0);
  int axis = 0;
  Eigen::Index expected = 0;
  RC_ASSERT(a.maxCoeff(&axis) == ea.maxCoeff(&expected) && axis == expected);
  RC_ASSERT(std::abs(a.unitOrthogonal().dot(a)) < 1e-12 * a.norm());
  RC_ASSERT(std::abs(a.unitOrthogonal().norm() - 1) < 1e-12);
}

RC_GTEST_PROP(Vectors, ColorsSayWhatEigenSays, ()) {
  const auto any = [] { return *rc::gen::inRange(1, 4001) / 1000.0; };
  const Rgb a(any(), any(), any()), b(any(), any(), any());
  const auto ea = asEigen(a), eb = asEigen(b);
  const auto same = [](const Rgb& is, const Eigen::Array3d& expected, double within = 0) {
    expectAsEigen<double, 3>(is.matrix(), expected.matrix(), within);
  };
  same(a * b + 2 - a / b, ea * eb + 2 - ea / eb);
  same(1 - a.min(b).max(0.5), 1 - ea.min(eb).max(0.5));
  same((-a).exp(), (-ea).exp(), 1e-15);
  same(a.log(), ea.log(), 1e-15);
  same(a.sqrt() + a.square(), ea.sqrt() + ea.square());
  same(a.pow(0.4), ea.pow(0.4), 1e-14);
  RC_ASSERT(a.mean() == ea.mean());
}

RC_GTEST_PROP(Vectors, MatricesSayWhatEigenSays, ()) {
  const auto any = [] { return *rc::gen::inRange(-4000, 4001) / 1000.0; };
  const Mat3 m(any(), any(), any(), any(), any(), any(), any(), any(), any());
  const Mat3 n(any(), any(), any(), any(), any(), any(), any(), any(), any());
  const Vec3 v(any(), any(), any());
  const auto em = asEigen(m), en = asEigen(n);
  const auto same = [](const Mat3& is, const Eigen::Matrix3d& expected, double within) {
    for (int c = 0; c < 3; ++c) expectAsEigen<double, 3>(is.col(c), expected.col(c), within);
  };
  same(m * n, em * en, 1e-14);
  same(m.transpose() - 2 * n, em.transpose() - 2 * en, 0);
  same(outerProduct(v, m.col(0)), asEigen(v) * em.col(0).transpose(), 0);
  same(v.asDiagonal(), asEigen(v).asDiagonal().toDenseMatrix(), 0);
  expectAsEigen<double, 3>(m * v, em * asEigen(v), 1e-14);
  expectAsEigen<double, 3>(m.row(1), em.row(1).transpose());
  expectAsEigen<double, 3>(m.columnNorms(), em.colwise().norm().transpose());
  RC_ASSERT(std::abs(m.determinant() - em.determinant()) < 1e-12);
  RC_ASSERT(std::abs(m.trace() - em.trace()) < 1e-14 * (1 + m.norm()));
  const Mat4 both = affine(m, v);
  same(linearPart(both), em, 0);
  expectAsEigen<double, 3>(offsetPart(both), asEigen(v));
  RC_ASSERT(both.row(3) == Vec4(0, 0, 0, 1));
  RC_PRE(std::abs(m.determinant()) > 0.1);
  same(m.inverse() * m, Eigen::Matrix3d::Identity(), 1e-9);
  const Mat2 corner(m(0, 0), m(0, 1), m(1, 0), m(1, 1));
  RC_PRE(std::abs(corner.determinant()) > 0.1);
  RC_ASSERT((corner.inverse() * corner).isApprox(Mat2::Identity(), 1e-9));
}

TEST(Vectors, AreNumbersAndNothingElse) {
  static_assert(sizeof(Vec3) == 24 && sizeof(Rgb) == 24 && sizeof(Mat3) == 72 &&
                alignof(Mat4) == 8);
  static_assert(std::is_trivially_copyable_v<Mat4> && std::is_standard_layout_v<Vec3>);
  EXPECT_EQ(Mat3(1, 2, 3, 4, 5, 6, 7, 8, 9),
            Mat3::ofRows(Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3(7, 8, 9)));
  EXPECT_EQ(::testing::PrintToString(Vec3(1, 2.5, -3)), "1 2.5 -3");
}

RC_GTEST_PROP(Rotation, AboutAnAxisAndByQuaternions, ()) {
  const auto any = [] { return *rc::gen::inRange(-1000, 1001) / 1000.0; };
  const Vec3 axis(any(), any(), any());
  const Vec4 q(any(), any(), any(), any());
  RC_PRE(axis.norm() > 0.01 && q.norm() > 0.01);
  const double angle = 3 * any();
  const Eigen::AngleAxisd turn(angle, asEigen(axis.normalized()));
  RC_ASSERT((turnAbout(axis.normalized(), angle) - Mat3(turn.toRotationMatrix())).norm() < 1e-14);
  const Eigen::Quaterniond unit = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized();
  RC_ASSERT((turnOfQuaternion(q) - Mat3(unit.toRotationMatrix())).norm() < 1e-14);
}

}  // namespace
}  // namespace volute
