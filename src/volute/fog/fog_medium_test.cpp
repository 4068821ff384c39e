// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_medium.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <limits>

#include "bench/baselines/uniform_steps.hpp"
#include "volute/fog/fog_testing.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

using fogtest::depthOf;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Case {
  int degree;
  fogtest::NamedProfile profile;
};

void PrintTo(const Case& value, std::ostream* stream) {
  *stream << value.profile.name << " of degree " << value.degree;
}

std::vector<Case> allCases() {
  std::vector<Case> cases;
  for (int degree = 0; degree <= 3; ++degree)
    for (const auto& profile : fogtest::profiles()) cases.push_back({degree, profile});
  return cases;
}

class FogCases : public ::testing::TestWithParam<Case> {
 protected:
  FogMedium make(const SplineGrid& map, FogOptions options = {}) const {
    options.degree = GetParam().degree;
    return fogtest::fog(map, GetParam().profile.profile, options);
  }
};

INSTANTIATE_TEST_SUITE_P(Every, FogCases, ::testing::ValuesIn(allCases()), [](const auto& info) {
  return info.param.profile.name + std::to_string(info.param.degree);
});

/// Where a ray crosses cells and zones: between them quadrature of the values at points is smooth.
std::vector<double> kinks(const FogMedium& fog, const Segment& segment) {
  std::vector<double> out;
  const Interval inside = fog.bounds()
                              .intersect(segment.origin, segment.direction)
                              .intersect({segment.begin, segment.end});
  if (inside.empty())
    return out;
  const auto add = [&](int axis, double plane) {
    const double s = (plane - segment.origin[axis]) / segment.direction[axis];
    if (s > inside.begin && s < inside.end)
      out.push_back(s);
  };
  const Box3 box = fog.bounds();
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; box.min[axis] + i * fog.cell() < box.max[axis]; ++i)
      add(axis, box.min[axis] + i * fog.cell());
  }
  for (const auto& zone : fog.profile().zones()) {
    add(2, fog.domainCorner().z() + zone.bottom);
    add(2, fog.domainCorner().z() + zone.top);
  }
  out.insert(out.end(), {inside.begin, inside.end});
  std::ranges::sort(out);
  return out;
}

TEST_P(FogCases, AgreesWithAdaptiveQuadrature) {
  const FogMedium fog = make(fogtest::map(23, 17));
  // In a plane where the density jumps, points say nothing.
  for (const Segment& segment : fogtest::rays(fog, 200, 3, GetParam().degree > 0)) {
    const std::vector<double> cuts = kinks(fog, segment);
    double expected = 0;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      // Nudged off the borders, where a jump belongs to one side.
      const double nudge = 1e-13 * (cuts[i + 1] - cuts[i]);
      expected += adaptiveIntegral([&](double s) { return fog.extinction(segment.at(s)); },
                                   cuts[i] + nudge, cuts[i + 1] - nudge, 1e-13);
    }
    EXPECT_NEAR(depthOf(fog, segment), expected, 1e-10);
  }
}

TEST_P(FogCases, FastPathAgreesWithTheReference) {
  for (double share : {0.6, 0.05}) {  // the second one jumps over empty parts
    for (double mu : {1.0, 0.5, 0.0}) {
      const FogMedium fog =
          make(fogtest::map(90, 70, 5, share), {.levels = 3, .detail = {.mu = mu}});
      const auto segments = fogtest::rays(fog, 600);
      std::vector<Radiance> fast(segments.size());
      fog.radiance(segments, fast);
      for (std::size_t i = 0; i < segments.size(); ++i) {
        const double expected = std::exp(-depthOf(fog, segments[i]));
        EXPECT_NEAR(fast[i].transmittance, expected, 2e-6) << i;
        EXPECT_NEAR(fast[i].emitted[0], 1 - expected, 2e-6);
      }
    }
  }
}

TEST_P(FogCases, EveryTargetGivesTheSameBitsWhateverTheBatch) {
  const FogMedium fog = make(fogtest::map(60, 50, 6, 0.3), {.levels = 2, .detail = {.mu = 0.4}});
  const auto segments = fogtest::rays(fog, 150);
  std::vector<Radiance> first(segments.size());
  fog.radiance(segments, first);
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    std::vector<Radiance> other(segments.size());
    for (std::size_t i = 0; i < segments.size(); i += 13) {
      const std::size_t count = std::min<std::size_t>(13, segments.size() - i);
      fog.radiance(std::span(segments).subspan(i, count), std::span(other).subspan(i, count));
    }
    for (std::size_t i = 0; i < segments.size(); ++i)
      ASSERT_EQ(first[i].transmittance, other[i].transmittance) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// Levels integrated one by one over nested distances, as the paper does it, from details alone.
TEST_P(FogCases, MergedLevelsAreTheSumOfNestedDetails) {
  constexpr int kLevels = 3;
  constexpr double kDistance = 20;
  const SplineGrid map = fogtest::map(18, 15);
  std::mt19937 random(3);
  for (Restriction restriction : {Restriction::kFullWeighting, Restriction::kCdf}) {
    const FogMedium full = make(map, {.levels = kLevels, .restriction = restriction});
    std::vector<FogMedium> bands;  // the coarsest approximation, then details to the finest
    for (int l = 0; l <= kLevels; ++l) {
      const int level = kLevels - l;
      const SplinePyramid& pyramid = full.levels().pyramid();
      const FogMap band{l == 0 ? pyramid.level(level) : pyramid.detail(level), full.domainCorner(),
                        std::ldexp(full.cell(), level)};
      bands.push_back(
          *FogMedium::make(band, GetParam().profile.profile, {.degree = GetParam().degree}));
    }
    for (Segment segment : fogtest::rays(full, 100)) {
      const double mu = static_cast<double>(random()) / 4294967296.0;
      segment.end = kDistance;
      double sum = 0;
      for (int l = 0; l <= kLevels; ++l) {
        Segment part = segment;
        part.end = kDistance * std::pow(mu, l);
        sum += depthOf(bands[l], part);
      }
      FogOptions options = full.options();
      options.detail.mu = mu;
      const FogMedium merged = make(map, options);
      EXPECT_NEAR(depthOf(merged, segment), sum, 1e-12);
    }
  }
}

TEST(FogMedium, HomogeneousFogIsLengthTimesExtinction) {
  for (int degree = 0; degree <= 3; ++degree) {
    SplineGrid map(20, 20);
    std::ranges::fill(map.c, 1.0);
    const FogMedium fog = fogtest::fog(map, {}, {.degree = degree}, 0.3, 1);
    const Vec3 centre = fog.bounds().min.cwiseMax(-5) + Vec3(10, 10, 7);
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.6, 0.8, 0), Vec3(0.36, 0.48, 0.8)})
      EXPECT_NEAR(depthOf(fog, {centre, direction, -4, 3}), 0.3 * 7, 1e-12);
    EXPECT_NEAR(depthOf(fog, {centre, Vec3::UnitZ(), 0, 5}), 1.5, 1e-12);
    EXPECT_NEAR(depthOf(fog, {centre, -Vec3::UnitZ(), 0, 5}), 1.5, 1e-12);
  }
}

FogMedium single(int degree) {
  SplineGrid map(1, 1);
  map.c = {1};
  return *FogMedium::make(*FogMap::fromCoefficients(map, {}), {}, {.degree = degree});
}

TEST(FogMedium, SingleCoefficients) {
  EXPECT_NEAR(depthOf(single(1), {Vec3(-1, 1, 0), Vec3::UnitX(), 0, 9}), 1, 1e-15);
  EXPECT_NEAR(depthOf(single(1), {Vec3(0, 0, 0), Vec3(1, 1, 0).normalized(), 0, 9}),
              2 * std::sqrt(2.0) / 3, 1e-15);
  EXPECT_NEAR(depthOf(single(2), {Vec3(-1, 1.5, 0), Vec3::UnitX(), 0, 9}), 0.75, 1e-15);
}

TEST(FogMedium, MuOneIsTheFinestAndMuZeroTheCoarsestLevel) {
  const SplineGrid map = fogtest::map(40, 30);
  const FogProfile slab = *FogProfile::slab(0, 5);
  const FogMedium plain = fogtest::fog(map, slab, {});
  const FogMedium one = fogtest::fog(map, slab, {.levels = 3});
  const FogMedium zero = fogtest::fog(map, slab, {.levels = 3, .detail = {.mu = 0}});
  const FogMedium coarse = *FogMedium::make(
      FogMap{zero.levels().pyramid().level(3), zero.domainCorner(), 8 * zero.cell()}, slab);
  for (const Segment& segment : fogtest::rays(plain, 100)) {
    EXPECT_NEAR(depthOf(one, segment), depthOf(plain, segment), 1e-13);
    EXPECT_NEAR(depthOf(zero, segment), depthOf(coarse, segment), 1e-12);
  }
}

TEST(FogMedium, SaysWhetherTheEndOfASegmentDecides) {
  const SplineGrid map = fogtest::map(40, 30);
  const auto depends = [&](int levels, const FogDetail& detail) {
    return fogtest::fog(map, {}, {.levels = levels, .detail = detail}).dependsOnEnd();
  };
  EXPECT_TRUE(depends(3, {.mu = 0.6}));
  EXPECT_FALSE(depends(3, {.mu = 1}));
  EXPECT_FALSE(depends(3, {.mu = 0}));
  EXPECT_FALSE(depends(0, {.mu = 0.6}));
  EXPECT_FALSE(depends(3, {.mu = 0.6, .cellAngle = 0.3}));
}

/// Dropping details changes the depth by no more than what they hold on the dropped distances.
TEST(FogMedium, DroppedDetailBoundsTheError) {
  const SplineGrid map = fogtest::map(40, 30);
  const FogMedium full = fogtest::fog(map, {}, {.levels = 3});
  const FogMedium dropped = fogtest::fog(map, {}, {.levels = 3, .detail = {.mu = 0.6}});
  for (Segment segment : fogtest::rays(full, 50)) {
    segment.end = 30;
    double bound = 0;
    for (int level = 0; level < 3; ++level) {
      SplineGrid detail = full.levels().pyramid().detail(level);
      for (double& c : detail.c) c = std::abs(c);
      const FogMedium band =
          *FogMedium::make(FogMap{detail, full.domainCorner(), std::ldexp(full.cell(), level)}, {});
      bound +=
          depthOf(band, {segment.origin, segment.direction, 30 * std::pow(0.6, 3 - level), 30});
    }
    EXPECT_LE(std::abs(depthOf(full, segment) - depthOf(dropped, segment)), bound + 1e-12);
  }
}

TEST(FogMedium, CellAngleDependsOnTheDistanceAlone) {
  const SplineGrid map = fogtest::map(40, 30);
  const FogMedium fog =
      fogtest::fog(map, *FogProfile::slab(0, 5), {.levels = 3, .detail = {.cellAngle = 0.3}});
  for (const Segment& segment : fogtest::rays(fog, 50)) {
    const double end = std::min(segment.end, 60.0);
    Segment front = segment, back = segment, whole = segment;
    whole.end = end, front.end = back.begin = 0.4 * end, back.end = end;
    EXPECT_NEAR(depthOf(fog, whole), depthOf(fog, front) + depthOf(fog, back), 1e-12);
  }
  const FogDetail::Ends ends = fog.options().detail.ends(3, 1.5, 100);
  EXPECT_DOUBLE_EQ(ends[0], 10);
  EXPECT_DOUBLE_EQ(ends[1], 20);
  EXPECT_EQ(ends[3], kInfinity);
}

TEST(FogMedium, MuEndsAreThoseOfThePaper) {
  const FogDetail detail{.mu = 0.5};
  const FogDetail::Ends ends = detail.ends(3, 1, 80);
  EXPECT_DOUBLE_EQ(ends[0], 10);
  EXPECT_DOUBLE_EQ(ends[1], 20);
  EXPECT_DOUBLE_EQ(ends[2], 40);
  EXPECT_EQ(ends[3], kInfinity);
  const FogDetail::Ends none = FogDetail{.mu = 0}.ends(2, 1, kInfinity);
  EXPECT_EQ(none[0], 0);
  EXPECT_EQ(none[1], 0);
  EXPECT_EQ(none[2], kInfinity);
}

TEST(UniformSteps, ConvergeToTheWalk) {
  const FogMedium fog = fogtest::fog(fogtest::map(40, 30), *FogProfile::slab(0, 6), {});
  const auto segments = fogtest::rays(fog, 100);
  std::vector<double> depths(segments.size());
  const auto worst = [&](int steps) {
    uniformStepDepths(fog, steps, segments, depths);
    double most = 0;
    for (std::size_t i = 0; i < segments.size(); ++i)
      most = std::max(most, std::abs(depths[i] - depthOf(fog, segments[i])));
    return most;
  };
  EXPECT_LT(worst(64), 0.05);
  EXPECT_LT(worst(4000), 2e-4);
}

TEST(FogMedium, LargeMapsAreWalkedAsExactly) {
  for (double share : {1.0, 0.1}) {
    const FogMedium fog =
        fogtest::fog(fogtest::map(1500, 1100, 2, share), *FogProfile::slab(-1000, 1000), {}, 2e-3);
    const auto segments = fogtest::rays(fog, 150);
    std::vector<Radiance> fast(segments.size());
    fog.radiance(segments, fast);
    for (std::size_t i = 0; i < segments.size(); ++i)
      EXPECT_NEAR(fast[i].transmittance, std::exp(-depthOf(fog, segments[i])), 2e-6);
  }
}

TEST(FogMedium, ThinLayersOfDenseMapsAreNotOpaque) {
  SplineGrid ones(40, 40);
  std::ranges::fill(ones.c, 1.0);
  const FogProfile::Layer layers[] = {{0, 1, 0.01}, {2, 3, 0.02}};
  const FogMedium fog = fogtest::fog(ones, *FogProfile::layers(layers), {}, 3);
  const Segment level{fog.bounds().centre() + Vec3(-20, 0, 0), Vec3::UnitX(), 0, 40};
  for (double height : {0.5, 2.5}) {
    Segment segment = level;
    segment.origin.z() = 0.5 + height;
    Radiance radiance;
    fog.radiance({&segment, 1}, {&radiance, 1});
    EXPECT_NEAR(radiance.transmittance, std::exp(-depthOf(fog, segment)), 2e-6);
  }
}

TEST(FogMedium, WindMovesTheFog) {
  const FogMedium fog = fogtest::fog(fogtest::map(12, 9), *FogProfile::exponential(0, 3), {});
  const Vec3 by(1.7, -0.4, 0.3);
  const FogMedium moved = fog.shifted(by);
  for (Segment segment : fogtest::rays(fog, 40)) {
    const double before = depthOf(fog, segment);
    segment.origin += by;
    EXPECT_NEAR(depthOf(moved, segment), before, 1e-12);
  }
}

TEST(FogMedium, TopCutsTheFog) {
  SplineGrid ones(30, 30);
  std::ranges::fill(ones.c, 1.0);
  const FogMap map = *FogMap::fromCoefficients(ones, {});
  FogMap top = map;  // a roof that rises along x: height x - 1 between nodes 1..30
  for (int j = 0; j < 30; ++j)
    for (int i = 0; i < 30; ++i) top.coefficients.at(i, j) = i;
  const FogMedium fog = *FogMedium::make(map, *FogProfile::slab(0, 100), {}, top);
  // Level at height 4: under the roof from x = 5 on.
  EXPECT_NEAR(depthOf(fog, {Vec3(0, 15, 4), Vec3::UnitX(), 0, 20}), 15, 1e-12);
  // Straight down at x = 11: from height 10.
  EXPECT_NEAR(depthOf(fog, {Vec3(11, 15, 50), -Vec3::UnitZ(), 0, 100}), 10, 1e-12);
}

}  // namespace
}  // namespace volute
