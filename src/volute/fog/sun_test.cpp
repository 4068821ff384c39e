// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/fog/fog_testing.hpp"
#include "volute/fog/sunlit_fog.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/medium/conformance.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// A map that is smooth on the scale of its cells.
FogMedium smoothFog(const FogProfile& profile, FogOptions options = {.degree = 2}) {
  SplineGrid map(24, 20);
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 24; ++i)
      map.at(i, j) = std::pow(std::sin(0.25 * i + 0.1 * j) * std::sin(0.2 * j), 2);
  return fogtest::fog(map, profile, options);
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

TEST(HenyeyGreenstein, IntegratesToOneWithItsMeanCosine) {
  for (double g : {-0.5, 0.0, 0.3, 0.8}) {
    const auto moment = [&](int power) {
      double sum = 0;
      for (int i = 0; i < 200; ++i)
        sum += gaussIntegral(8, -1 + i / 100.0, -1 + (i + 1) / 100.0, [&](double c) {
          return 2 * std::numbers::pi * henyeyGreenstein(g, c) * std::pow(c, power);
        });
      return sum;
    };
    EXPECT_NEAR(moment(0), 1, 1e-12);
    EXPECT_NEAR(moment(1), g, 1e-12);
  }
}

/// Fog without structure, lit from above, seen from above: a closed form.
TEST(SunlitFog, HomogeneousSlabLookingDown) {
  SplineGrid ones(40, 40);
  std::ranges::fill(ones.c, 0.3);
  const FogMedium fog = *FogMedium::make(*FogMap::fromCoefficients(ones, {}),
                                         *FogProfile::slab(0, 5), {.color = Rgb::Zero()});
  const Sun sun{Vec3::UnitZ(), Rgb(2, 3, 4)};
  const SunlitFog lit = *SunlitFog::make(fog, {&sun, 1}, {.albedo = Rgb(1, 0.5, 0)});
  const Segment down{Vec3(20, 20, 9), -Vec3::UnitZ(), 0, 100};
  Radiance radiance;
  lit.radiance({&down, 1}, {&radiance, 1});
  // Both ways absorb alike: integral of 0.3 exp(-2 * 0.3 d) over the depth d.
  const double share = 0.5 * (1 - std::exp(-2 * 0.3 * 5)) / (4 * std::numbers::pi);
  EXPECT_NEAR(radiance.emitted[0], 2 * share, 2e-4);
  EXPECT_NEAR(radiance.emitted[1], 1.5 * share, 2e-4);
  EXPECT_EQ(radiance.emitted[2], 0);
  EXPECT_NEAR(radiance.transmittance, std::exp(-1.5), 1e-6);
}

TEST_P(SunProfiles, FastPathAgreesWithPieces) {
  for (int degree = 1; degree <= 3; ++degree) {
    const FogMedium fog = smoothFog(profile(), {.degree = degree, .color = Rgb::Zero()});
    const Sun sun{Vec3(1, -0.4, 0.8), Rgb::Ones()};
    const SunlitFog lit = *SunlitFog::make(fog, {&sun, 1});
    const auto segments = fogtest::rays(fog, 60);
    std::vector<Radiance> fast(segments.size()), reference(segments.size());
    lit.radiance(segments, fast);
    radianceByPieces(lit, segments, reference);
    double brightest = 0;
    for (const Radiance& light : reference) brightest = std::max(brightest, light.emitted[0]);
    for (std::size_t i = 0; i < segments.size(); ++i)
      EXPECT_NEAR(fast[i].emitted[0], reference[i].emitted[0], 2e-3 * brightest);
  }
}

TEST(SunlitFog, PhaseIsAFactor) {
  const FogMedium fog = smoothFog(*FogProfile::exponential(1, 3), {.color = Rgb::Zero()});
  const Sun sun{Vec3(1, 0, 1), Rgb::Ones()};
  const SunlitFog plain = *SunlitFog::make(fog, {&sun, 1});
  const SunlitFog forward = *SunlitFog::make(fog, {&sun, 1}, {.asymmetry = 0.7});
  for (const Segment& segment : fogtest::rays(fog, 30)) {
    const auto light = [&](const SunlitFog& lit) {
      Radiance radiance;
      lit.radiance({&segment, 1}, {&radiance, 1});
      return radiance.emitted[0];
    };
    const double phase = henyeyGreenstein(0.7, Vec3(1, 0, 1).normalized().dot(segment.direction));
    EXPECT_NEAR(light(forward), light(plain) * 4 * std::numbers::pi * phase,
                1e-9 * light(forward) + 1e-15);
  }
}

/// Poles, a roof and a wall in smooth fog.
TriangleScene obstacles() {
  std::vector<Triangle> triangles;
  const auto quad = [&](const Vec3& corner, const Vec3& a, const Vec3& b) {
    triangles.push_back({{corner, corner + a, corner + a + b}});
    triangles.push_back({{corner, corner + a + b, corner + b}});
  };
  quad(Vec3(5, 5, 3), Vec3(6, 0, 1), Vec3(0, 7, 0));
  quad(Vec3(14, 2, 0), Vec3(0, 12, 0), Vec3(0, 0, 4));
  for (int i = 0; i < 12; ++i)
    quad(Vec3(2 + 1.5 * i, 9 + 0.3 * i, -1), Vec3(0.2, 0.1, 0), Vec3(0, 0, 7));
  return *TriangleScene::build(std::move(triangles));
}

/// The sun's light by many steps, with a ray to the sun from the middle of each: through the fog as
/// it is walked, and past the triangles.
double sunlightByRays(const FogMedium& fog, const TriangleScene& scene, const Vec3& sun,
                      const Segment& segment, int steps) {
  const Interval inside = fog.bounds()
                              .intersect(segment.origin, segment.direction)
                              .intersect({segment.begin, segment.end});
  if (inside.empty())
    return 0;
  const double length = inside.length() / steps;
  double light = 0, passed = 1;
  for (int i = 0; i < steps; ++i) {
    const double from = inside.begin + i * length;
    const Segment step{segment.origin, segment.direction, from, from + length};
    const Segment toSun{segment.at(from + 0.5 * length), sun, 0, kNoEnd};
    double depth = 0, above = 0;
    std::uint8_t blocked = 0;
    fog.opticalDepth({&step, 1}, {&depth, 1});
    scene.occluded({&toSun, 1}, {&blocked, 1});
    fog.opticalDepth({&toSun, 1}, {&above, 1});
    if (!blocked)
      light += passed * (1 - std::exp(-depth)) * std::exp(-above);
    passed *= std::exp(-depth);
  }
  return light / (4 * std::numbers::pi);
}

TEST_P(SunProfiles, SurfacesShadowTheLightInTheFog) {
  const FogMedium fog = smoothFog(profile(), {.degree = 2, .color = Rgb::Zero()});
  const TriangleScene scene = obstacles();
  const Sun sun{Vec3(1, -0.4, 0.8).normalized(), Rgb::Ones()};
  const auto shadows = [&](const Segment& segment, std::size_t, std::vector<Interval>& dark) {
    scene.shadows(segment, {sun.towards}, dark);
  };
  const SunlitFog open = *SunlitFog::make(fog, {&sun, 1}, {.samples = 4});
  const SunlitFog lit = *SunlitFog::make(fog, {&sun, 1}, {.shadows = shadows, .samples = 4});
  double brightest = 0, darkened = 0, fastError = 0, pieceError = 0;
  int judged = 0;
  for (const Segment& segment : fogtest::rays(fog, 60)) {
    Radiance unshadowed, fast, pieces;
    open.radiance({&segment, 1}, {&unshadowed, 1});
    lit.radiance({&segment, 1}, {&fast, 1});
    if (!(unshadowed.emitted[0] > 1.01 * fast.emitted[0]) || ++judged > 8)
      continue;
    radianceByPieces(lit, {&segment, 1}, {&pieces, 1});
    const double rays = sunlightByRays(fog, scene, sun.towards, segment, 4000);
    brightest = std::max(brightest, rays);
    darkened = std::max(darkened, unshadowed.emitted[0] - fast.emitted[0]);
    fastError = std::max(fastError, std::abs(fast.emitted[0] - rays));
    pieceError = std::max(pieceError, std::abs(pieces.emitted[0] - rays));
  }
  EXPECT_LT(fastError, 2e-3 * brightest);
  EXPECT_LT(pieceError, 2e-3 * brightest);
  EXPECT_GE(judged, 8);
  EXPECT_GT(darkened, 0.03 * brightest);
  RecordProperty("fast", std::to_string(fastError / brightest));
  RecordProperty("pieces", std::to_string(pieceError / brightest));
}

TEST(SunlitFog, BadScatteringIsNamed) {
  const FogMedium fog = smoothFog({});
  using ::testing::HasSubstr;
  EXPECT_THAT(SunlitFog::make(fog, {}, {.asymmetry = 1}).error().message, HasSubstr("asymmetry"));
  EXPECT_THAT(SunlitFog::make(fog, {}, {.albedo = Rgb(2, 0, 0)}).error().message,
              HasSubstr("albedo"));
}

conformance::MediumUnderTest sunlit(int degree, std::size_t profile) {
  const FogMedium fog = smoothFog(fogtest::profiles()[profile].profile,
                                  {.degree = degree, .color = Rgb(0.1, 0.2, 0.3)});
  const Sun suns[] = {{Vec3(1, 0.4, 0.7), Rgb(9, 8, 7)}, {Vec3(-1, 0, 2), Rgb(1, 2, 3)}};
  conformance::Traits traits;
  const CellRect cells = fog.levels().mapCells();
  const Vec3 corner = fog.domainCorner();
  for (int x = cells.x0; x <= cells.x1; ++x)
    traits.planes[0].push_back(corner.x() + x * fog.cell());
  for (int y = cells.y0; y <= cells.y1; ++y)
    traits.planes[1].push_back(corner.y() + y * fog.cell());
  traits.region = fog.bounds();
  traits.region.min.z() = std::max(traits.region.min.z(), -2.0);
  traits.region.max.z() = std::min(traits.region.max.z(), 8.0);
  // The light along a piece is a parabola to 1e-4 at two places; between them the shadow has kinks,
  // and a small jump where the way to the sun becomes steep.
  traits.tolerance = {.closedForm = 2e-3, .points = 1e-2, .quadrature = 5e-3, .fineSteps = 1e-2};
  return conformance::underTest(*SunlitFog::make(fog, suns), traits);
}

VOLUTE_CONFORMANCE(SunlitSlab1, sunlit(1, 0));
VOLUTE_CONFORMANCE(SunlitLinear2, sunlit(2, 1));
VOLUTE_CONFORMANCE(SunlitExponential1, sunlit(1, 2));
VOLUTE_CONFORMANCE(SunlitExponential3, sunlit(3, 2));

}  // namespace
}  // namespace volute
