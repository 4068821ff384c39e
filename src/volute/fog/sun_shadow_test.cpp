// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sun_shadow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/fog/fog_testing.hpp"

namespace volute {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// A map that is smooth on the scale of its cells.
FogMedium smoothFog(const FogProfile& profile) {
  SplineGrid map(24, 20);
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 24; ++i)
      map.at(i, j) = std::pow(std::sin(0.25 * i + 0.1 * j) * std::sin(0.2 * j), 2);
  return fogtest::fog(map, profile, {.degree = 2});
}

class SunProfiles : public ::testing::TestWithParam<int> {
 protected:
  FogProfile profile() const { return fogtest::profiles()[GetParam()].profile; }
};

INSTANTIATE_TEST_SUITE_P(Every, SunProfiles, ::testing::Range(0, 4),
                         [](const auto& info) { return fogtest::profiles()[info.param].name; });

double worstShadow(const FogMedium& fog, const Vec3& towards, int samples) {
  const SunShadow shadow = *SunShadow::make(fog, towards, samples);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 1.2);
  const Box3 box = fog.bounds();
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    Vec3 point = box.min + Vec3(uniform(random), uniform(random), 0).cwiseProduct(box.size());
    point.z() = 10 * uniform(random);
    const Segment segment{point, towards.normalized(), 0, kNoEnd};
    double depth = 0;
    fog.opticalDepth({&segment, 1}, {&depth, 1});
    worst = std::max(worst, std::abs(std::exp(-depth) - std::exp(-shadow.opticalDepth(point))));
  }
  return worst;
}

TEST_P(SunProfiles, ShadowsAreThoseOfTheFog) {
  const FogMedium fog = smoothFog(profile());
  for (const Vec3& towards : {Vec3(1, 0.4, 0.7), Vec3(-2, 1, 0.5), Vec3(0, 0, 1)}) {
    const double coarse = worstShadow(fog, towards, 1), fine = worstShadow(fog, towards, 4);
    EXPECT_LT(coarse, 2.5e-2);
    EXPECT_LT(fine, 4e-3);
  }
}

TEST_P(SunProfiles, ManyPlacesAtOnceAreThoseOfEach) {
  const FogMedium fog = smoothFog(profile());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.3, 1.3);
  for (const Vec3& towards :
       {Vec3(1, 0.4, 0.7), Vec3(-2, 1, 0.05), Vec3(0, 1, 0.3), Vec3(0, 0, 1)}) {
    const SunShadow shadow = *SunShadow::make(fog, towards, 2);
    for (const std::size_t count : {0, 1, 16, 333}) {
      std::vector<Vec3> points;
      const Box3 box = fog.bounds();
      while (points.size() < count) {
        points.push_back(box.min +
                         Vec3(uniform(random), uniform(random), 0).cwiseProduct(box.size()));
        points.back().z() = 12 * uniform(random);
      }
      std::vector<double> shares(count);
      shadow.shares(points, shares);
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_NEAR(shares[i], std::exp(-shadow.opticalDepth(points[i])), 1e-4) << i;
    }
  }
}

TEST(SunShadow, AtSamplesAnExponentialIsExactAtEveryHeight) {
  const FogMedium fog = smoothFog(*FogProfile::exponential(0, 4));
  const Vec3 towards = Vec3(0.5, -0.3, 0.6).normalized();
  const SunShadow shadow = *SunShadow::make(fog, towards);
  for (double height : {0.0, 1.0, 7.0}) {
    for (int i = 3; i < 20; ++i) {
      const Vec3 point =
          fog.domainCorner() + Vec3(i * fog.cell(), (i % 7 + 4) * fog.cell(), height);
      const Segment segment{point, towards, 0, kNoEnd};
      double depth = 0;
      fog.opticalDepth({&segment, 1}, {&depth, 1});
      EXPECT_NEAR(shadow.opticalDepth(point), depth, 2e-6);
    }
  }
}

TEST(SunShadow, SunsBelowTheHorizonAreRefused) {
  const FogMedium fog = smoothFog({});
  EXPECT_FALSE(SunShadow::make(fog, Vec3(1, 0, 0)));
  EXPECT_FALSE(SunShadow::make(fog, Vec3(1, 0, -1)));
  EXPECT_FALSE(SunShadow::make(fog, Vec3(0, 0, 0)));
  EXPECT_FALSE(SunShadow::make(fog, Vec3(0, 0, 1), 0));
}

}  // namespace
}  // namespace volute
