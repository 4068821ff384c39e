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

}  // namespace
}  // namespace volute
