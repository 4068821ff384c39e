// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/prior.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "volute/tomography/variation_kernels.hpp"

namespace volute {
namespace {

std::shared_ptr<const Support> wholeCube(int side) {
  const VolumeGeometry geometry{{Vec3(0, 0, 0), Vec3(1, 1, 1)}, {side, side, side}};
  return std::make_shared<const Support>(geometry, Basis::kTrilinear,
                                         std::span<const std::uint8_t>{});
}

std::vector<float> noisy(std::size_t unknowns, float mean, float sigma) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal(mean, sigma);
  std::vector<float> a(4 * unknowns);
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = i % 4 == 3 ? 0 : normal(random);
  return a;
}

/// The total nuclear variation, straight from its definition, of a cube in zeros.
double totalVariation(const std::vector<float>& a, int side) {
  auto at = [&](int x, int y, int z, int c) -> double {
    const bool inside = std::min({x, y, z}) >= 0 && std::max({x, y, z}) < side;
    return inside ? a[4 * ((static_cast<std::size_t>(z) * side + y) * side + x) + c] : 0;
  };
  double sum = 0;
  for (int z = -1; z < side; ++z)
    for (int y = -1; y < side; ++y)
      for (int x = -1; x < side; ++x) {
        Eigen::Matrix3d slopes;
        for (int c = 0; c < 3; ++c)
          slopes.col(c) << at(x + 1, y, z, c) - at(x, y, z, c), at(x, y + 1, z, c) - at(x, y, z, c),
              at(x, y, z + 1, c) - at(x, y, z, c);
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares(slopes.transpose() * slopes,
                                                                     Eigen::EigenvaluesOnly);
        for (int k = 0; k < 3; ++k) sum += std::sqrt(std::max(squares.eigenvalues()[k], 0.0));
      }
  return sum;
}

TEST(SingularValues, LargeOnesBecomeOne) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  std::vector<Eigen::Matrix3f> matrices(1001);
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    // Any, of nearly one direction, of one direction, turned by a rotation times 1.3, small.
    const std::size_t kind = i % 5;
    Eigen::Matrix3f& m = matrices[i];
    for (float& value : m.reshaped()) value = normal(random);
    if (kind == 1)
      m.rightCols<2>() *= 1e-3F;
    if (kind == 2)
      m = (m.col(0) * Eigen::RowVector3f(1, 0.5F, 0.2F)).eval();
    if (kind == 3)
      m = 1.3F * Eigen::Quaternionf(m(0, 0), m(1, 0), m(2, 0), m(0, 1)).normalized().matrix();
    if (kind == 4)
      m *= 0.1F;
    if (i < 16)  // grey
      m.rightCols<2>().colwise() = m.col(0);
  }
  SlopePlanes slopes;
  for (Eigen::Index k = 0; k < 9; ++k)
    for (const auto& m : matrices) slopes[static_cast<std::size_t>(k)].push_back(m(k / 3, k % 3));
  clipSingularValues(slopes);
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    Eigen::Matrix3f after;
    for (Eigen::Index k = 0; k < 9; ++k)
      after(k / 3, k % 3) = slopes[static_cast<std::size_t>(k)][i];
    if (i < 16) {
      EXPECT_TRUE(after.col(0) == after.col(1) && after.col(1) == after.col(2));
    }
    const Eigen::Matrix3f& before = matrices[i];
    const Eigen::JacobiSVD<Eigen::Matrix3f> svd(before, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3f expected = svd.matrixU() *
                                     svd.singularValues().cwiseMin(1.0F).asDiagonal() *
                                     svd.matrixV().transpose();
    EXPECT_LT((after - expected).norm(), 2e-5 * (1 + before.norm())) << i;
  }
}

TEST(NoPrior, ClampsIfAsked) {
  std::vector<float> a{1, -2, 3, 0};
  const std::vector<float> step{1};
  makeNoPrior(false)->proximal(a, step);
  EXPECT_EQ(a[1], -2);
  makeNoPrior(true)->proximal(a, step);
  EXPECT_EQ(a, (std::vector<float>{1, 0, 3, 0}));
}

TEST(TotalVariation, ProximalPointIsBetterThanItsNeighbours) {
  constexpr int kSide = 5;
  constexpr double kStrength = 0.3;
  const auto support = wholeCube(kSide);
  const std::vector<float> x = noisy(support->size(), 0.5F, 0.5F);
  std::vector<float> step(support->size());
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = 0.2F + 0.1F * static_cast<float>(i % 5);
  const auto prior = makeTotalVariation(support, kStrength, {}, true);
  std::vector<float> a;
  for (int k = 0; k < 60; ++k) {  // the dual goes on from call to call
    a = x;
    prior->proximal(a, step);
  }
  auto objective = [&](const std::vector<float>& v) {
    double sum = kStrength * totalVariation(v, kSide);
    for (std::size_t i = 0; i < v.size(); ++i)
      sum += 0.5 * std::pow(static_cast<double>(v[i]) - x[i], 2) / step[i / 4];
    return sum;
  };
  const double best = objective(a);
  EXPECT_LT(best, objective(x));
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  for (float value : a) EXPECT_GE(value, 0);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<float> other = a;
    for (std::size_t i = 0; i < other.size(); ++i)
      if (i % 4 != 3)
        other[i] = std::max(0.0F, other[i] + 0.003F * normal(random));
    EXPECT_GT(objective(other), best * (1 - 1e-5));
  }
}

TEST(TotalVariation, SharedEdgesOfChannelsAreKept) {
  constexpr int kSide = 8;
  const auto support = wholeCube(kSide);
  // A step in x in all channels, and noise in the second alone.
  std::mt19937 random(9);
  std::normal_distribution<float> normal;
  std::vector<float> truth(4 * support->size()), a;
  for (std::size_t i = 0; i < support->size(); ++i) {
    const float value = support->voxels()[i] % kSide < kSide / 2 ? 1.0F : 2.0F;
    for (std::size_t c = 0; c < 3; ++c) truth[4 * i + c] = value;
  }
  std::vector<float> noisy = truth;
  for (std::size_t i = 1; i < noisy.size(); i += 4) noisy[i] += 0.2F * normal(random);
  const std::vector<float> step(support->size(), 1.0F);
  const auto prior = makeTotalVariation(support, 0.1, {}, true);
  for (int k = 0; k < 60; ++k) {
    a = noisy;
    prior->proximal(a, step);
  }
  double before = 0, after = 0;
  for (std::size_t i = 0; i < support->size(); ++i) {
    const int x = support->voxels()[i] % kSide, y = support->voxels()[i] / kSide % kSide,
              z = support->voxels()[i] / kSide / kSide;
    if (std::min({x, y, z}) < 1 || std::max({x, y, z}) > kSide - 2)
      continue;
    before += std::pow(noisy[4 * i + 1] - truth[4 * i + 1], 2);
    after += std::pow(a[4 * i + 1] - truth[4 * i + 1], 2);
    EXPECT_NEAR(a[4 * i], truth[4 * i], 0.2);
  }
  EXPECT_LT(after, 0.3 * before);
}

TEST(Smoothness, GradientIsThatOfSquaredDifferences) {
  const auto support = wholeCube(4);
  const auto prior = makeSmoothness(support, 0.7, true);
  const std::vector<float> a = noisy(support->size(), 0, 1);
  std::vector<float> gradient(a.size());
  prior->addGradient(a, gradient);
  // <a, gradient> is twice the penalty of a quadratic form, and zeros stand around the cube.
  double both = 0, penalty = 0;
  for (std::size_t i = 0; i < a.size(); ++i) both += static_cast<double>(a[i]) * gradient[i];
  auto at = [&](int x, int y, int z, int c) -> double {
    const bool inside = std::min({x, y, z}) >= 0 && std::max({x, y, z}) < 4;
    return inside ? a[4 * ((z * 4 + y) * 4 + x) + c] : 0;
  };
  for (int z = -1; z < 4; ++z)
    for (int y = -1; y < 4; ++y)
      for (int x = -1; x < 4; ++x)
        for (int c = 0; c < 3; ++c)
          penalty += std::pow(at(x + 1, y, z, c) - at(x, y, z, c), 2) +
                     std::pow(at(x, y + 1, z, c) - at(x, y, z, c), 2) +
                     std::pow(at(x, y, z + 1, c) - at(x, y, z, c), 2);
  EXPECT_NEAR(both, 0.7 * penalty, 1e-4 * penalty);
  EXPECT_GE(prior->curvature(), 12 * 0.7 - 1e-9);
}

class WaveletTest : public testing::TestWithParam<Wavelet> {};

TEST_P(WaveletTest, TakesNoiseAndLeavesConstants) {
  const auto support = wholeCube(16);
  const std::vector<float> step(support->size(), 1.0F);
  std::vector<float> a = noisy(support->size(), 1, 0.1F);
  const auto prior = makeWaveletSparsity(support, GetParam(), 0.5, true, 1);
  prior->proximal(a, step);
  double variance = 0, mean = 0;
  int count = 0;
  for (int z = 4; z < 12; ++z)
    for (int y = 4; y < 12; ++y)
      for (int x = 4; x < 12; ++x, ++count) {
        const double value = a[4 * ((z * 16 + y) * 16 + x)];
        mean += value;
        variance += (value - 1) * (value - 1);
      }
  EXPECT_NEAR(mean / count, 1, 0.05);
  EXPECT_LT(std::sqrt(variance / count), 0.07);
}

TEST_P(WaveletTest, StrengthZeroChangesNothing) {
  const auto support = wholeCube(6);
  const std::vector<float> step(support->size(), 1.0F);
  const std::vector<float> x = noisy(support->size(), 5, 0.1F);
  std::vector<float> a = x;
  makeWaveletSparsity(support, GetParam(), 1e-9, true, 1)->proximal(a, step);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], x[i], 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Wavelets, WaveletTest,
                         testing::Values(Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97));

}  // namespace
}  // namespace volute
