// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/bspline.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

double psi(int degree, const std::vector<double>& q, double x) {
  double sum = 0;
  for (std::size_t n = 0; n < q.size(); ++n) sum += q[n] * bspline(degree, 2 * x - double(n));
  return sum;
}

/// The integral of f over [0, end], exact for splines with knots at half integers.
template <class F>
double splineIntegral(double end, F&& f) {
  double sum = 0;
  for (double a = 0; a < end; a += 0.5) sum += gaussIntegral(8, a, a + 0.5, f);
  return sum;
}

class Degrees : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Spline, Degrees, ::testing::Values(0, 1, 2, 3));

TEST_P(Degrees, ShiftsSumToOneAndTheIntegralIsOne) {
  const int d = GetParam();
  for (double x = 0.003; x < 1; x += 0.0931) {
    double sum = 0;
    for (int k = 0; k <= d; ++k) sum += bspline(d, x + k);
    EXPECT_NEAR(sum, 1, 1e-15);
  }
  EXPECT_NEAR(splineIntegral(d + 1, [&](double x) { return bspline(d, x); }), 1, 1e-14);
  EXPECT_EQ(bspline(d, -1e-9), 0);
  EXPECT_EQ(bspline(d, d + 1), 0);
}

TEST_P(Degrees, TwoScaleRelation) {
  const int d = GetParam();
  const auto p = twoScale(d);
  for (double x = -0.5; x < 5; x += 0.00457) {
    double sum = 0;
    for (int k = 0; k <= d + 1; ++k) sum += p[k] * bspline(d, 2 * x - k);
    EXPECT_NEAR(bspline(d, x), sum, 4e-15);
  }
}

TEST_P(Degrees, PiecesAndWeightsAreTheSplines) {
  const int d = GetParam();
  for (double u = 0; u < 1; u += 0.0711) {
    const auto weights = splineWeights(d, u);
    for (int i = 0; i <= d; ++i) EXPECT_NEAR(weights[i], bspline(d, u + d - i), 1e-15);
  }
}

TEST(Bspline, KnownValues) {
  EXPECT_DOUBLE_EQ(bspline(2, 1.5), 0.75);
  EXPECT_DOUBLE_EQ(bspline(1, 1), 1);
  EXPECT_DOUBLE_EQ(bspline(3, 2), 2 / 3.0);
  EXPECT_EQ(twoScale(1), (std::vector<double>{0.5, 1, 0.5}));
  EXPECT_EQ(twoScale(2), (std::vector<double>{0.25, 0.75, 0.75, 0.25}));
  EXPECT_EQ(twoScale(3), (std::vector<double>{0.125, 0.5, 0.75, 0.5, 0.125}));
}

TEST(Bspline, GramRows) {
  const auto expect = [](int degree, double by, std::vector<double> row) {
    const auto gram = splineGram(degree);
    for (std::size_t s = 0; s < row.size(); ++s) EXPECT_NEAR(gram[s], row[s] / by, 1e-15);
  };
  expect(0, 1, {1});
  expect(1, 6, {4, 1});
  expect(2, 120, {66, 26, 1});
  expect(3, 5040, {2416, 1191, 120, 1});
}

TEST(ChuiWang, Sequences) {
  const auto expect = [](int degree, double by, std::vector<double> q) {
    const auto found = chuiWangWavelet(degree);
    ASSERT_EQ(found.size(), q.size());
    for (std::size_t n = 0; n < q.size(); ++n) EXPECT_NEAR(found[n], q[n] / by, 1e-15);
  };
  expect(0, 1, {1, -1});
  expect(1, 12, {1, -6, 10, -6, 1});
  expect(2, 480, {1, -29, 147, -303, 303, -147, 29, -1});
  expect(3, 40320, {1, -124, 1677, -7904, 18482, -24264, 18482, -7904, 1677, -124, 1});
}

TEST_P(Degrees, ChuiWangIsOrthogonalToTheSplinesAndHasItsMoments) {
  const int d = GetParam(), m = d + 1;
  const auto q = chuiWangWavelet(d);
  for (int k = -d; k < 2 * m - 1; ++k) {
    EXPECT_NEAR(
        splineIntegral(2 * m - 1, [&](double x) { return psi(d, q, x) * bspline(d, x - k); }), 0,
        1e-16)
        << k;
  }
  for (int r = 0; r < m; ++r) {
    EXPECT_NEAR(splineIntegral(2 * m - 1, [&](double x) { return psi(d, q, x) * std::pow(x, r); }),
                0, 1e-14);
  }
}

TEST(Cdf, WaveletsHaveTheirVanishingMoments) {
  for (const CdfFilters& filters : cdfFilters()) {
    for (int r = 0; r <= filters.vanishingMoments; ++r) {
      double sum = 0;
      for (std::size_t n = 0; n < filters.wavelet.size(); ++n)
        sum += filters.wavelet[n] * std::pow(double(n), r);
      if (r < filters.vanishingMoments) {
        EXPECT_NEAR(sum, 0, 1e-12);
      } else {
        EXPECT_GT(std::abs(sum), 0.1);
      }
    }
  }
}

/// [P Q] on a periodic line of n coefficients.
Eigen::MatrixXd synthesis(int degree, const std::vector<double>& q, int qFirst, int n) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  const auto p = twoScale(degree);
  for (int k = 0; k < n / 2; ++k) {
    for (std::size_t i = 0; i < p.size(); ++i) matrix((2 * k + int(i)) % n, k) += p[i];
    for (std::size_t i = 0; i < q.size(); ++i)
      matrix((2 * k + int(i) + qFirst + n) % n, n / 2 + k) += q[i];
  }
  return matrix;
}

TEST(Cdf, AnalysisIsTheInverseOfSynthesis) {
  constexpr int n = 64;
  for (const CdfFilters& f : cdfFilters()) {
    Eigen::MatrixXd analysis = Eigen::MatrixXd::Zero(n, n);
    for (int k = 0; k < n / 2; ++k) {
      for (std::size_t i = 0; i < f.low.size(); ++i)
        analysis(k, (2 * k + int(i) + f.lowFirst + n) % n) += f.low[i];
      for (std::size_t i = 0; i < f.high.size(); ++i)
        analysis(n / 2 + k, (2 * k + int(i) + f.highFirst + n) % n) += f.high[i];
    }
    const Eigen::MatrixXd product = analysis * synthesis(f.degree, f.wavelet, f.waveletFirst, n);
    EXPECT_LT((product - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-14)
        << f.degree << " " << f.vanishingMoments;
  }
}

double condition(const Eigen::MatrixXd& matrix) {
  const auto values = Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues();
  return values[0] / values[values.size() - 1];
}

TEST(Cdf, ConditionAndNegativeMassOfTheLowPass) {
  const double negative[] = {0, 0.25, 0.5, 0.5, 0.75}, conditions[] = {1, 2, 2, 2, 4};
  for (std::size_t f = 0; f < cdfFilters().size(); ++f) {
    const CdfFilters& filters = cdfFilters()[f];
    double mass = 0;
    for (double tap : filters.low) mass -= std::min(tap, 0.0);
    EXPECT_NEAR(mass, negative[f], 1e-15);
    EXPECT_NEAR(condition(synthesis(filters.degree, filters.wavelet, filters.waveletFirst, 64)),
                conditions[f], 5e-3);
  }
}

TEST(ChuiWang, AnalysisIsNotFirAndUndershoots) {
  struct Expected {
    int degree, taps, detailTaps;
    double condition, negative;
  };

  for (const Expected& e : {Expected{0, 2, 2, 1, 0}, Expected{1, 61, 61, 2.12, 0.433},
                            Expected{2, 92, 96, 3.75, 0.661}, Expected{3, 126, 128, 6.55, 1.41}}) {
    const Eigen::MatrixXd matrix = synthesis(e.degree, chuiWangWavelet(e.degree), 0, 128);
    const Eigen::MatrixXd inverse = matrix.inverse();
    const Eigen::RowVectorXd a = inverse.row(20), b = inverse.row(64 + 20);
    EXPECT_NEAR(condition(matrix), e.condition, 5e-3);
    EXPECT_EQ((a.array().abs() > 1e-9).count(), e.taps) << e.degree;
    EXPECT_EQ((b.array().abs() > 1e-9).count(), e.detailTaps) << e.degree;
    EXPECT_NEAR(-a.cwiseMin(0.0).sum(), e.negative, 5e-3);
    EXPECT_NEAR(a.sum(), 1, 1e-12);
    if (e.degree == 1) {
      EXPECT_NEAR(a.maxCoeff(), (1 + std::sqrt(3.0)) / 4, 1e-12);
      Eigen::Index centre;
      a.maxCoeff(&centre);
      EXPECT_NEAR(std::abs(a[centre + 4] / a[centre + 2]), 2 - std::sqrt(3.0), 1e-9);
    }
  }
}

}  // namespace
}  // namespace volute
