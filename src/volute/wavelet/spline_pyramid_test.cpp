// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/spline_pyramid.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace volute {
namespace {

constexpr Restriction kAll[] = {Restriction::kFullWeighting, Restriction::kCdf};

/// Noise with empty areas and hard edges, 0..1.
SplineGrid noise(int columns, int rows, unsigned seed = 1) {
  std::mt19937 random(seed);
  SplineGrid grid(columns, rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double value = static_cast<double>(random()) / 4294967296.0;
      grid.at(i, j) = (i / 9 + j / 7) % 2 ? value : 0;
    }
  }
  return grid;
}

double largest(const SplineGrid& grid) {
  double most = 0;
  for (double value : grid.c) most = std::max(most, std::abs(value));
  return most;
}

/// The value at x, y in cells of level `level`.
double value(const SplineGrid& grid, int degree, double x, double y) {
  double sum = 0;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i)
      sum += grid.at(i, j) * bspline(degree, x - i) * bspline(degree, y - j);
  }
  return sum;
}

RC_GTEST_PROP(SplinePyramid, DetailsReconstructPerfectly, ()) {
  const int degree = *rc::gen::inRange(0, 4), levels = *rc::gen::inRange(1, 4);
  const int columns = *rc::gen::inRange(1, 40), rows = *rc::gen::inRange(1, 40);
  const Restriction restriction =
      *rc::gen::elementOf(std::vector<Restriction>(std::begin(kAll), std::end(kAll)));
  const SplinePyramid pyramid(noise(columns, rows), degree, levels, restriction);
  SplineGrid grid = pyramid.level(levels);
  for (int i = levels - 1; i >= 0; --i) {
    grid = prolonged(grid, degree);
    const SplineGrid detail = pyramid.detail(i);
    for (std::size_t k = 0; k < grid.c.size(); ++k) grid.c[k] += detail.c[k];
  }
  RC_ASSERT(largest(difference(grid, pyramid.level(0))) < 1e-15);
}

RC_GTEST_PROP(SplinePyramid, EveryLevelKeepsTheMass, ()) {
  const int degree = *rc::gen::inRange(0, 4), levels = *rc::gen::inRange(1, 4);
  const SplineGrid grid = noise(*rc::gen::inRange(10, 40), *rc::gen::inRange(1, 40));
  const SplinePyramid pyramid(grid, degree, levels, Restriction::kFullWeighting);
  for (int i = 0; i <= levels; ++i) {
    const double mass = pyramid.level(i).sum() * std::pow(4.0, i);
    RC_ASSERT(std::abs(mass / grid.sum() - 1) < 1e-12);
    for (double c : pyramid.level(i).c) RC_ASSERT(c >= 0);
  }
}

TEST(SplinePyramid, FullWeightingWithoutMarginLosesMass) {
  SplineGrid grid(63, 63);  // 64 cells of degree 1, none to spare
  std::ranges::fill(grid.c, 1.0);
  SplineGrid coarse = grid;
  for (int i = 0; i < 3; ++i) coarse = restricted(coarse, 1, Restriction::kFullWeighting);
  EXPECT_LT(coarse.sum() * 64 / grid.sum(), 0.99);
}

TEST(SplinePyramid, ProlongedIsTheSameFunction) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int degree = 0; degree <= 3; ++degree) {
    const SplineGrid coarse = noise(7, 5, 11);
    const SplineGrid fine = prolonged(coarse, degree);
    ASSERT_EQ(fine.columns, 2 * (7 + degree) - degree);
    for (int k = 0; k < 50; ++k) {
      const double x = uniform(random) * (7 + degree), y = uniform(random) * (5 + degree);
      EXPECT_NEAR(value(fine, degree, 2 * x, 2 * y), value(coarse, degree, x, y), 1e-14);
    }
  }
}

TEST(SplinePyramid, CdfGivesBackWhatTheCoarseGridHolds) {
  for (int degree = 0; degree <= 3; ++degree) {
    SplineGrid coarse(40, 40);  // zero at the border, where FIR filters reach outside
    const SplineGrid middle = noise(24, 24, 5);
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) coarse.at(i + 8, j + 8) = middle.at(i, j);
    const SplineGrid back = restricted(prolonged(coarse, degree), degree, Restriction::kCdf);
    EXPECT_LT(largest(difference(back, coarse)), 1e-13) << degree;
  }
}

TEST(SplinePyramid, CdfUndershootsAndFullWeightingDoesNot) {
  SplineGrid grid(64, 64);  // a block with hard edges
  for (int j = 20; j < 45; ++j)
    for (int i = 10; i < 31; ++i) grid.at(i, j) = 1;
  const auto least = [&](int degree, Restriction restriction) {
    return std::ranges::min(SplinePyramid(grid, degree, 3, restriction).level(3).c);
  };
  for (int degree = 1; degree <= 3; ++degree) {
    EXPECT_LT(least(degree, Restriction::kCdf), -0.02);
    EXPECT_EQ(least(degree, Restriction::kFullWeighting), 0);
  }
  for (Restriction restriction : kAll) EXPECT_GE(least(0, restriction), 0);
}

TEST(SplinePyramid, SixtyFourLinearCoefficientsNeed88Cells) {
  const SplinePadding padding(64, 1, 3);
  EXPECT_EQ(padding.cells, 88);
  EXPECT_EQ(padding.offset, 11);
  EXPECT_EQ(SplinePadding(64, 1, 0).cells, 65);
  EXPECT_EQ(SplinePadding(64, 1, 0).offset, 0);
  EXPECT_EQ(SplinePadding(64, 0, 3).cells, 64);
  EXPECT_EQ(SplinePadding(64, 2, 3).cells, 72 + 32);
}

TEST(SplinePyramid, MixedIsLinear) {
  const SplineGrid a = noise(20, 13, 1), b = noise(20, 13, 2);
  SplineGrid mean(20, 13);
  for (std::size_t i = 0; i < mean.c.size(); ++i) mean.c[i] = 0.75 * a.c[i] + 0.25 * b.c[i];
  const auto make = [](const SplineGrid& g) {
    return SplinePyramid(g, 2, 2, Restriction::kFullWeighting);
  };
  const SplinePyramid mixed = make(a).mixed(make(b), 0.25), expected = make(mean);
  for (int i = 0; i <= 2; ++i)
    EXPECT_LT(largest(difference(mixed.level(i), expected.level(i))), 1e-15);
}

}  // namespace
}  // namespace volute
