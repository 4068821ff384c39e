// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/uncertainty.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

struct Estimated {
  Reconstruction solved;
  VoxelUncertainty bars;
};

Estimated estimated(const TestScene& scene, std::span<const TomographyView> views,
                    const TomographyOptions& options = {}) {
  Progress progress;
  auto solved = reconstruct(views, scene.geometry, options, {}, progress);
  EXPECT_TRUE(solved) << (solved ? "" : solved.error().message);
  auto bars = estimateUncertainty(views, scene.geometry, options, *solved, progress);
  EXPECT_TRUE(bars) << (bars ? "" : bars.error().message);
  return {std::move(*solved), std::move(*bars)};
}

/// The share of lit values whose truth is within `times` standard deviations.
double covered(const TestScene& scene, const Estimated& found, double times) {
  const float top = *std::ranges::max_element(scene.truth);
  double inside = 0, count = 0;
  for (std::size_t i = 0; i < scene.truth.size(); ++i) {
    if (!(scene.truth[i] > 0.05F * top))
      continue;
    ++count;
    inside += std::abs(scene.truth[i] - found.solved.volume[i]) <= times * found.bars.sigma[i];
  }
  return inside / count;
}

double lengthOf(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value) * value;
  return std::sqrt(sum);
}

class UncertaintyOf : public testing::TestWithParam<std::pair<int, double>> {};

TEST_P(UncertaintyOf, CoversTheTruth) {
  const TestScene scene(GetParam().first, GetParam().second);
  const auto found = estimated(scene, scene.views);
  EXPECT_GT(covered(scene, found, 1), 0.55);
  EXPECT_LT(covered(scene, found, 1), 0.80);
  EXPECT_GT(covered(scene, found, 2), 0.85);
  EXPECT_LE(covered(scene, found, 2), 0.98);
  const double error = scene.error(found.solved.volume);
  EXPECT_GT(found.bars.expectedError, 0.6 * error);
  EXPECT_LT(found.bars.expectedError, 1.8 * error);
  EXPECT_NEAR(found.bars.priorShare,
              std::pow(found.bars.expectedError, 2) / (1 + std::pow(found.bars.expectedError, 2)),
              1e-3);
  EXPECT_EQ(found.bars.heldOut.size(), GetParam().first > 5 ? 1U : 2U);
}

INSTANTIATE_TEST_SUITE_P(CamerasAndNoise, UncertaintyOf,
                         testing::Values(std::pair{6, 0.02}, std::pair{5, 0.01},
                                         std::pair{9, 0.02}));

TEST(Uncertainty, GrowsWithNoiseAndWithFewerCameras) {
  const TestScene quiet(9, 0.01), noisy(9, 0.08);
  const auto some = estimated(quiet, quiet.views);
  EXPECT_GT(lengthOf(estimated(noisy, noisy.views).bars.sigma), 1.3 * lengthOf(some.bars.sigma));
  std::vector<TomographyView> few;
  for (const std::size_t v : {0, 2, 4, 6}) few.push_back(quiet.views[v]);
  EXPECT_GT(lengthOf(estimated(quiet, few).bars.sigma), 1.3 * lengthOf(some.bars.sigma));
}

TEST(Uncertainty, IsNoSmallerThanWhatNoiseDoes) {
  // Where many cameras determine the volume, repeated noise is the whole of it
  // but for the prior.
  TestScene scene(12);
  TomographyOptions options;
  options.noiseSigma = 0.1;
  const auto pictures = scene.views;
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  constexpr int kTimes = 5;
  std::vector<double> sum(scene.truth.size()), squares(sum.size());
  std::vector<float> sigma;
  Progress progress;
  for (int k = 0; k < kTimes; ++k) {
    for (std::size_t v = 0; v < pictures.size(); ++v)
      for (std::size_t i = 0; i < pictures[v].radiance.pixels.size(); ++i)
        scene.views[v].radiance.pixels[i] = pictures[v].radiance.pixels[i] + 0.1F * normal(random);
    const auto solved = reconstruct(scene.views, scene.geometry, options, {}, progress);
    ASSERT_TRUE(solved);
    options.choice = solved->choice;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += solved->volume[i];
      squares[i] += std::pow(solved->volume[i], 2);
    }
    if (k == 0) {
      auto bars = estimateUncertainty(scene.views, scene.geometry, options, *solved, progress);
      ASSERT_TRUE(bars);
      sigma = std::move(bars->sigma);
    }
  }
  double repeated = 0;
  for (std::size_t i = 0; i < sum.size(); ++i)
    repeated += (squares[i] - sum[i] * sum[i] / kTimes) / (kTimes - 1);
  EXPECT_GT(lengthOf(sigma), std::sqrt(repeated));
  EXPECT_LT(lengthOf(sigma), 4 * std::sqrt(repeated));
}

TEST(Uncertainty, KnowsThatSightsAreOff) {
  const TestScene scene(8, 0.005);
  const auto exact = estimated(scene, scene.views);
  auto off = scene.views;
  for (TomographyView& view : off) view.sightError = 2;
  Progress progress;
  const auto bars = estimateUncertainty(off, scene.geometry, {}, exact.solved, progress);
  ASSERT_TRUE(bars);
  EXPECT_GT(lengthOf(bars->sigma), lengthOf(exact.bars.sigma));
}

TEST(Uncertainty, OfThreeCamerasIsMeasuredAndOfTwoIsNot) {
  const TestScene scene(3, 0.02);
  const auto found = estimated(scene, scene.views);
  EXPECT_EQ(found.bars.heldOut.size(), 2U);
  EXPECT_GT(covered(scene, found, 1), 0.5);
  EXPECT_GT(covered(scene, found, 2), 0.8);
  const auto two = estimated(scene, std::span(scene.views).first(2));
  EXPECT_TRUE(two.bars.heldOut.empty());
  EXPECT_GT(lengthOf(two.bars.sigma), 0);
}

}  // namespace
}  // namespace volute
