// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/volume_flow.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace volute {
namespace {

constexpr int kSide = 32;
constexpr std::array<int, 3> kSize{kSide, kSide, kSide};
constexpr double kMiddle = (kSide - 1) / 2.0;

using Point = std::array<double, 3>;

/// A cloud of sixty puffs within two thirds of the volume; `at` is measured from its middle.
double cloud(const Point& at) {
  struct Puff {
    Point centre;
    double weight;
  };

  static const std::vector<Puff> puffs = [] {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Puff> all;
    while (all.size() < 60) {
      const Point p{uniform(random), uniform(random), uniform(random)};
      if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 1)
        all.push_back({{0.27 * kSide * p[0], 0.27 * kSide * p[1], 0.27 * kSide * p[2]},
                       0.3 + std::abs(uniform(random))});
    }
    return all;
  }();
  constexpr double kRadius = kSide / 16.0;
  double sum = 0;
  for (const Puff& puff : puffs) {
    double r2 = 0;
    for (int a = 0; a < 3; ++a) r2 += std::pow((at[a] - puff.centre[a]) / kRadius, 2);
    if (r2 < 4)
      sum += puff.weight * std::pow(1 - r2 / 4, 2);
  }
  return sum;
}

/// The cloud after a time: moved by `shift` and turned about z by `turn` [radians] in a time of 1.
struct Motion {
  Point shift{};
  double turn = 0;

  double at(double time, double x, double y, double z) const {
    const Point p{x - kMiddle - time * shift[0], y - kMiddle - time * shift[1],
                  z - kMiddle - time * shift[2]};
    const double c = std::cos(time * turn), s = std::sin(time * turn);
    return cloud({c * p[0] + s * p[1], -s * p[0] + c * p[1], p[2]});
  }

  /// How far what is at a point at half-time moves from time -1/2 to 1/2.
  Point displacement(double x, double y) const {
    const double t = 2 * std::tan(turn / 2);
    return {shift[0] - t * (y - kMiddle), shift[1] + t * (x - kMiddle), shift[2]};
  }
};

template <class Body>
void forAll(Body&& body) {
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        body((static_cast<std::size_t>(z) * kSide + y) * kSide + x, x, y, z);
}

std::vector<float> volumeAt(const Motion& motion, double time, double noise = 0) {
  std::vector<float> values(kSide * kSide * kSide);
  std::mt19937 random(static_cast<unsigned>(100 * time + 1000));
  std::normal_distribution<double> normal;
  forAll([&](std::size_t i, int x, int y, int z) {
    const double value = motion.at(time, x, y, z);
    values[i] = static_cast<float>(value > 0 ? std::max(0.0, value + noise * normal(random)) : 0);
  });
  return values;
}

/// The mean length of found minus true displacement, and of the true one, where the medium is.
std::pair<double, double> endPointError(const VoxelFlow& flow, const Motion& motion) {
  double error = 0, length = 0, count = 0;
  forAll([&](std::size_t i, int x, int y, int z) {
    if (motion.at(0, x, y, z) < 0.05)
      return;
    const Point truth = motion.displacement(x, y);
    double off = 0, all = 0;
    for (int a = 0; a < 3; ++a) {
      off += std::pow(flow.along[a][i] - truth[a], 2);
      all += std::pow(truth[a], 2);
    }
    error += std::sqrt(off), length += std::sqrt(all), ++count;
  });
  return {error / count, length / count};
}

VoxelFlow found(const std::vector<float>& before, const std::vector<float>& after,
                const FlowOptions& options = {}) {
  Progress progress;
  auto flow = flowBetween(before, after, kSize, options, progress);
  EXPECT_TRUE(flow) << (flow ? "" : flow.error().message);
  return flow ? *flow : VoxelFlow{};
}

TEST(VolumeFlow, FindsHowACloudMovesAndTurns) {
  struct Case {
    const char* name;
    Motion motion;
    double most;  // voxels
  };

  for (const Case& one : {Case{"a third of a voxel", {{0.3, -0.2, 0.1}, 0}, 0.05},
                          Case{"two and a half voxels", {{1.5, -1, 1.7}, 0}, 0.12},
                          Case{"six voxels", {{4, 3, -3.5}, 0}, 0.12},
                          Case{"turned by 5 degrees", {{}, 5 * std::numbers::pi / 180}, 0.08},
                          Case{"turned by 15 degrees", {{}, 15 * std::numbers::pi / 180}, 0.2},
                          Case{"both", {{2, 0, 1}, 8 * std::numbers::pi / 180}, 0.12}}) {
    for (const double noise : {0.0, 0.05}) {
      const auto flow = found(volumeAt(one.motion, -0.5, noise), volumeAt(one.motion, 0.5, noise));
      const auto [error, length] = endPointError(flow, one.motion);
      EXPECT_LT(error, one.most + noise)
          << one.name << " of " << length << " voxels, noise " << noise;
    }
  }
}

TEST(VolumeFlow, ADivergenceThatCostsIsSmaller) {
  const Motion motion{{1, 0.5, 0}, 0.1};
  const auto before = volumeAt(motion, -0.5, 0.1), after = volumeAt(motion, 0.5, 0.1);
  const auto divergence = [](const VoxelFlow& flow) {
    double sum = 0;
    forAll([&](std::size_t i, int x, int y, int z) {
      if (std::max({x, y, z}) + 1 < kSide)
        sum += std::abs(flow.along[0][i + 1] - flow.along[0][i] + flow.along[1][i + kSide] -
                        flow.along[1][i] + flow.along[2][i + kSide * kSide] - flow.along[2][i]);
    });
    return sum;
  };
  const auto free = found(before, after), kept = found(before, after, {.divergence = 100});
  EXPECT_LT(divergence(kept), 0.8 * divergence(free));
  EXPECT_LT(endPointError(kept, motion).first, 0.25);
}

TEST(VolumeFlow, GoesBackWhereVolumesAreExchanged) {
  const Motion motion{{2, -1, 0.5}, 0.1};
  const auto before = volumeAt(motion, -0.5), after = volumeAt(motion, 0.5);
  const auto there = found(before, after), back = found(after, before);
  float most = 0;
  for (int a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < there.along[a].size(); ++i)
      most = std::max(most, std::abs(there.along[a][i] + back.along[a][i]));
  EXPECT_LT(most, 1e-3F);
}

TEST(VolumeFlow, StillAndDarkVolumesDoNotMove) {
  const auto still = volumeAt({}, 0);
  for (const auto& one : found(still, still).along) EXPECT_THAT(one, ::testing::Each(0.0F));
  const std::vector<float> dark(still.size());
  for (const auto& one : found(dark, dark).along) EXPECT_THAT(one, ::testing::Each(0.0F));
  const auto lit = found(dark, still);
  for (const auto& one : lit.along)
    for (const float value : one) EXPECT_LT(std::abs(value), kSide);
}

TEST(VolumeFlow, CarriesAFrameOnAlongItsMotion) {
  const Motion motion{{2.5, -1, 1}, 0.12};
  const auto early = volumeAt(motion, -1), now = volumeAt(motion, 0), next = volumeAt(motion, 1);
  const auto distance = [&](const std::vector<float>& values) {
    double off = 0, all = 0;
    for (std::size_t i = 0; i < next.size(); ++i) {
      off += std::pow(values[i] - next[i], 2);
      all += std::pow(next[i], 2);
    }
    return std::sqrt(off / all);
  };
  EXPECT_LT(distance(carriedOn(now, 1, found(early, now))), 0.35 * distance(now));
}

TEST(VolumeFlow, AtAFrameIsBetweenTheIntervals) {
  // A constant acceleration along x: 1 and 2 voxels in two intervals.
  VoxelFlow before{kSize, {}}, after{kSize, {}};
  for (int a = 0; a < 3; ++a) {
    before.along[a].assign(kSide * kSide * kSide, a == 0 ? 1.0F : 0.0F);
    after.along[a].assign(kSide * kSide * kSide, a == 0 ? 2.0F : 0.0F);
  }
  EXPECT_THAT(flowAtFrame(&before, &after, 1).along[0], ::testing::Each(::testing::FloatEq(1.5F)));
  EXPECT_EQ(flowAtFrame(&before, nullptr, 1).along[0], before.along[0]);
  EXPECT_EQ(flowAtFrame(nullptr, &after, 1).along[0], after.along[0]);
  // An interval twice as long: 1 and 1 a time, whatever is nearer.
  EXPECT_THAT(flowAtFrame(&before, &after, 2).along[0], ::testing::Each(::testing::FloatEq(2)));
}

TEST(VolumeFlow, RefusesWhatMakesNoSense) {
  Progress progress;
  const std::vector<float> few(8);
  EXPECT_EQ(flowBetween(few, few, kSize, {}, progress).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(flowBetween(few, few, {2, 2, 2}, {.smoothness = 0}, progress).error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_TRUE(flowBetween(few, few, {2, 2, 2}, {}, progress));
  EXPECT_TRUE(flowBetween(few, few, {8, 1, 1}, {}, progress));
}

}  // namespace
}  // namespace volute
