// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/baselines/paper_walk.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/fog/fog_testing.hpp"

namespace volute {
namespace {

struct FlatRay {
  PlaneRay plane;
  double distance;
};

/// Over a map of n^2 coefficients; s is longer than the way seen from above.
std::vector<FlatRay> flatRays(int n, int count) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  std::vector<FlatRay> rays;
  for (int i = 0; i < count; ++i) {
    const double x = n * uniform(random), y = n * uniform(random);
    const double dx = n * uniform(random) - x, dy = n * uniform(random) - y;
    const double length = 1.2 * std::hypot(dx, dy);
    rays.push_back({{x, y, dx / length, dy / length}, length});
  }
  return rays;
}

TEST(PaperFog, ThreeWalksAgree) {
  for (int degree = 0; degree <= 3; ++degree) {
    for (int levels = 1; levels <= 3; ++levels) {
      const SplineGrid map = fogtest::map(24, 24);
      const PaperFog fog(map, degree, levels);
      const PaperFog plain(map, degree, 0);
      for (const auto& [ray, distance] : flatRays(24, 60)) {
        const double expected = plain.merged(ray, distance, 1);
        EXPECT_NEAR(fog.merged(ray, distance, 1), expected, 1e-12);
        EXPECT_NEAR(fog.deconstructed(ray, distance, 1), expected, 1e-12);
        EXPECT_NEAR(fog.undeconstructed(ray, distance, 1), expected, 1e-12) << degree;
        for (double mu : {0.0, 0.3, 0.8}) {
          const double dropped = fog.merged(ray, distance, mu);
          EXPECT_NEAR(fog.deconstructed(ray, distance, mu), dropped, 1e-12);
          EXPECT_NEAR(fog.undeconstructed(ray, distance, mu), dropped, 1e-12) << degree << mu;
        }
      }
    }
  }
}

TEST(PaperFog, IsTheMediumsWalk) {
  const SplineGrid map = fogtest::map(20, 20);
  for (int degree = 0; degree <= 3; ++degree) {
    const PaperFog paper(map, degree, 2);
    const FogMedium fog = *FogMedium::make(
        *FogMap::fromCoefficients(map, {}), {},
        {.degree = degree, .levels = 2, .detail = {.mu = 1}, .restriction = Restriction::kCdf});
    for (const auto& [ray, distance] : flatRays(20, 40)) {
      const double up = std::sqrt(1 - ray.dx * ray.dx - ray.dy * ray.dy);
      const Segment segment{Vec3(ray.ox, ray.oy, 3), Vec3(ray.dx, ray.dy, up), 0, distance};
      double depth = 0;
      fog.opticalDepth({&segment, 1}, {&depth, 1});
      EXPECT_NEAR(paper.merged(ray, distance, 1), depth, 1e-12);
    }
  }
}

TEST(PathTable, ErrorFallsWithTheSamples) {
  const SplineGrid map = fogtest::map(20, 20);
  const PaperFog exact(map, 1, 0);
  double worst[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    const PathTable table(k == 0 ? 16 : 64);
    for (const auto& [ray, distance] : flatRays(20, 200)) {
      const double error = table.depth(map, ray, distance) - exact.merged(ray, distance, 1);
      worst[k] = std::max(worst[k], std::abs(error));
    }
  }
  EXPECT_LT(worst[0], 0.2);
  EXPECT_GT(worst[0], 1e-4);  // sampled, not exact
  EXPECT_LT(worst[1], worst[0] / 2.5);
}

}  // namespace
}  // namespace volute
