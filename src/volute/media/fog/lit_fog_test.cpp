// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/lit_fog.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/fog/fog_testing.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/math/phase_function.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/scene_lights.hpp"
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
TEST(LitFog, HomogeneousSlabLookingDown) {
  SplineGrid ones(40, 40);
  std::ranges::fill(ones.c, 0.3);
  const FogMedium fog = *FogMedium::make(*FogMap::fromCoefficients(ones, {}),
                                         *FogProfile::slab(0, 5), {.color = Rgb::Zero()});
  const Lamp sun = lampOf({Vec3::UnitZ(), Rgb(2, 3, 4)});
  const LitMedium lit = litFog(fog, {&sun, 1}, {{Rgb(1, 0.5, 0)}});
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

/// Without a profile fog has no end: all that a ray meets of it is lit from the side, evenly.
TEST(LitFog, EndlessFogIsLitAsFarAsItIsSeen) {
  SplineGrid even(40, 40);
  std::ranges::fill(even.c, 0.02);
  const FogMedium fog =
      *FogMedium::make(*FogMap::fromCoefficients(even, {}), FogProfile(), {.color = Rgb::Zero()});
  const Vec3 eye(20, 20, 9), toSun = Vec3(1, 0, 1).normalized();
  const Lamp sun = lampOf({toSun, Rgb::Ones()});
  const LitMedium lit = litFog(fog, {&sun, 1}, {{Rgb::Ones()}});
  const Segment down{eye, -Vec3::UnitZ(), 0, 1e6}, way{eye, toSun, 0, 1e6};
  double depth = 0;
  fog.opticalDepth({&way, 1}, {&depth, 1});
  Radiance radiance;
  lit.radiance({&down, 1}, {&radiance, 1});
  const double expected = std::exp(-depth) / (4 * std::numbers::pi);
  EXPECT_NEAR(radiance.emitted[0], expected, 2e-3 * expected);
}

/// @param tolerance  of the brightest ray
void expectFastPathAsPieces(const LitMedium& lit, const std::vector<Segment>& segments,
                            double tolerance) {
  std::vector<Radiance> fast(segments.size()), reference(segments.size());
  lit.radiance(segments, fast);
  radianceByPieces(lit, segments, reference);
  double brightest = 0;
  for (const Radiance& light : reference) brightest = std::max(brightest, light.emitted[0]);
  for (std::size_t i = 0; i < segments.size(); ++i)
    EXPECT_NEAR(fast[i].emitted[0], reference[i].emitted[0], tolerance * brightest);
}

TEST_P(SunProfiles, FastPathAgreesWithPieces) {
  for (int degree = 1; degree <= 3; ++degree) {
    const FogMedium fog = smoothFog(profile(), {.degree = degree, .color = Rgb::Zero()});
    const Lamp sun = lampOf({Vec3(1, -0.4, 0.8), Rgb::Ones()});
    expectFastPathAsPieces(litFog(fog, {&sun, 1}, {}), fogtest::rays(fog, 60), 2e-3);
  }
}

/// Where a cell alone swallows half of the light, and begins at once.
TEST(LitFog, FastPathAgreesWithPiecesWhereFogIsDense) {
  SplineGrid block(16, 16);
  for (int j = 4; j < 12; ++j)
    for (int i = 4; i < 12; ++i) block.at(i, j) = 1;
  const FogProfile::Layer layers[] = {{0, 3, 0.5}, {2, 6, 0.75}};
  const FogMedium fog = fogtest::fog(block, *FogProfile::layers(layers),
                                     {.degree = 1, .color = Rgb::Zero()}, 0.75, 1);
  const Lamp sun = lampOf({Vec3(-0.22, -0.43, 0.77), Rgb::Ones()});
  expectFastPathAsPieces(litFog(fog, {&sun, 1}, {}), fogtest::rays(fog, 400), 2.5e-3);
}

TEST(LitFog, PhaseIsAFactor) {
  const FogMedium fog = smoothFog(*FogProfile::exponential(1, 3), {.color = Rgb::Zero()});
  const Lamp sun = lampOf({Vec3(1, 0, 1), Rgb::Ones()});
  const LitMedium plain = litFog(fog, {&sun, 1}, {});
  const LitMedium forward = litFog(fog, {&sun, 1}, {{Rgb::Ones(), 0.7}});
  for (const Segment& segment : fogtest::rays(fog, 30)) {
    const auto light = [&](const LitMedium& lit) {
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
double sunlightByRays(const FogMedium& fog, std::span<const AnyMedium> others,
                      const TriangleScene& scene, const Vec3& sun, const Segment& segment,
                      int steps) {
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
    for (const AnyMedium& other : others) {
      double more = 0;
      other.opticalDepth({&toSun, 1}, {&more, 1});
      above += more;
    }
    if (!blocked)
      light += passed * (1 - std::exp(-depth)) * std::exp(-above);
    passed *= std::exp(-depth);
  }
  return light / (4 * std::numbers::pi);
}

TEST_P(SunProfiles, SurfacesShadowTheLightInTheFog) {
  const FogMedium fog = smoothFog(profile(), {.degree = 2, .color = Rgb::Zero()});
  const TriangleScene scene = obstacles();
  const Vec3 towards = Vec3(1, -0.4, 0.8).normalized();
  const Lamp sun = lampOf({towards, Rgb::Ones()});
  const LitMedium open = litFog(fog, {&sun, 1}, {});
  const LitMedium lit = litFog(fog, {&sun, 1}, {{}, shadowsOf(scene)});
  double brightest = 0, darkened = 0, fastError = 0, pieceError = 0;
  int judged = 0;
  for (const Segment& segment : fogtest::rays(fog, 60)) {
    Radiance unshadowed, fast, pieces;
    open.radiance({&segment, 1}, {&unshadowed, 1});
    lit.radiance({&segment, 1}, {&fast, 1});
    if (!(unshadowed.emitted[0] > 1.01 * fast.emitted[0]) || ++judged > 8)
      continue;
    radianceByPieces(lit, {&segment, 1}, {&pieces, 1});
    const double rays = sunlightByRays(fog, {}, scene, towards, segment, 4000);
    brightest = std::max(brightest, rays);
    darkened = std::max(darkened, unshadowed.emitted[0] - fast.emitted[0]);
    fastError = std::max(fastError, std::abs(fast.emitted[0] - rays));
    pieceError = std::max(pieceError, std::abs(pieces.emitted[0] - rays));
  }
  EXPECT_LT(fastError, 2e-3 * brightest);
  EXPECT_LT(pieceError, 2e-3 * brightest);
  EXPECT_GE(judged, 8);
  EXPECT_GT(darkened, 0.03 * brightest);
}

/// A ball of smoke in the fog, and one before it, against steps with a ray from each.
TEST_P(SunProfiles, VolumesShadowTheLightInTheFog) {
  const FogMedium fog = smoothFog(profile(), {.degree = 2, .color = Rgb::Zero()});
  std::vector<AnyMedium> puffs;
  for (const Vec3& corner : {Vec3(8, 6, 0), Vec3(16, 2, 9)}) {
    constexpr int kSide = 24;
    VolumeInfo info;
    info.x = info.y = info.z = kSide, info.channels = 1;
    info.bounds = {corner, corner + Vec3::Constant(6)};
    std::vector<float> values;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const Vec3 voxel(i % kSide, i / kSide % kSide, i / kSide / kSide);
      const double far = (voxel - Vec3::Constant(0.5 * kSide - 0.5)).norm() / (0.5 * kSide);
      values.push_back(static_cast<float>(std::max(0.0, 1 - far * far)));
    }
    puffs.emplace_back(
        VoxelMedium(std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values)), 0, 2));
  }
  const Vec3 towards = Vec3(1, -0.4, 0.8).normalized();
  const Lamp sun = lampOf({towards, Rgb::Ones()});
  const LitMedium open = litFog(fog, {&sun, 1}, {});
  const LitMedium lit = litFog(fog, {&sun, 1}, {.between = puffs});
  double brightest = 0, darkened = 0, fastError = 0, pieceError = 0;
  for (const Segment& segment : fogtest::rays(fog, 40)) {
    Radiance unshadowed, fast, pieces;
    open.radiance({&segment, 1}, {&unshadowed, 1});
    lit.radiance({&segment, 1}, {&fast, 1});
    radianceByPieces(lit, {&segment, 1}, {&pieces, 1});
    const double rays = sunlightByRays(fog, puffs, {}, towards, segment, 2000);
    brightest = std::max(brightest, rays);
    darkened = std::max(darkened, unshadowed.emitted[0] - fast.emitted[0]);
    fastError = std::max(fastError, std::abs(fast.emitted[0] - rays));
    pieceError = std::max(pieceError, std::abs(pieces.emitted[0] - rays));
  }
  EXPECT_LT(fastError, 5e-3 * brightest);
  EXPECT_LT(pieceError, 5e-3 * brightest);
  EXPECT_GT(darkened, 0.05 * brightest);
}

conformance::MediumUnderTest sunlit(int degree, std::size_t profile) {
  const FogMedium fog = smoothFog(fogtest::profiles()[profile].profile,
                                  {.degree = degree, .color = Rgb(0.1, 0.2, 0.3)});
  const Lamp suns[] = {lampOf({Vec3(1, 0.4, 0.7), Rgb(9, 8, 7)}),
                       lampOf({Vec3(-1, 0, 2), Rgb(1, 2, 3)})};
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
  // The light along a piece is a parabola to 2e-4 at two places, and between them it has kinks.
  traits.tolerance = {.closedForm = 2e-3, .points = 1e-2, .quadrature = 5e-3, .fineSteps = 1e-2};
  return conformance::underTest(litFog(fog, suns, {}), traits);
}

VOLUTE_CONFORMANCE(SunlitSlab1, sunlit(1, 0));
VOLUTE_CONFORMANCE(SunlitLinear2, sunlit(2, 1));
VOLUTE_CONFORMANCE(SunlitExponential3, sunlit(3, 2));

/// A spot behind a puff, and a wall of 10 cm, against steps with a ray from each.
TEST(LitFog, LampsComeThroughSmokeButNotThroughWalls) {
  const FogMedium fog = smoothFog(*FogProfile::exponential(1, 3), {.color = Rgb::Zero()});
  Lamp spot;
  spot.position = Vec3(16, 12, 6), spot.direction = Vec3(0.3, 0.1, -1).normalized();
  spot.coneCosine = 0.5, spot.edge = 0.2, spot.radius = 0.2;
  constexpr int kSide = 16;
  VolumeInfo info;
  info.x = info.y = info.z = kSide, info.channels = 1;
  info.bounds = {Vec3(15, 11, 3), Vec3(17, 13, 5)};
  const BrickSlice even = BrickSlice::fromDense(info, std::vector<float>(kSide * kSide * kSide, 1));
  const AnyMedium puff(VoxelMedium(std::make_shared<const BrickSlice>(even), 0, 0.6));
  std::vector<Triangle> wall;
  for (const double x : {18.0, 18.1}) {
    const Vec3 a(x, 0, -5), b(x, 30, -5), c(x, 30, 20), d(x, 0, 20);
    wall.push_back({{a, b, c}}), wall.push_back({{a, c, d}});
  }
  const TriangleScene scene = *TriangleScene::build(std::move(wall));
  const LitMedium lit = litFog(fog, {&spot, 1}, {{}, shadowsOf(scene), {puff}});
  double brightest = 0, worst = 0;
  for (int i = 0; i < 24; ++i) {
    const Vec3 eye(6, 6 + 0.5 * i, 4), target(16 + 0.2 * i, 12, 2 + 0.1 * i);
    const Segment ray{eye, (target - eye).normalized(), 0, 11};
    Radiance fast;
    lit.radiance({&ray, 1}, {&fast, 1});
    double sum = 0, before = 0;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps; ++k) {
      const double s = ray.end * (k + 0.5) / kSteps, step = ray.end / kSteps;
      const Vec3 point = ray.at(s);
      const Segment way = spot.towards(point);
      std::uint8_t blocked = 0;
      scene.occluded({&way, 1}, {&blocked, 1});
      double inFog = 0, inPuff = 0;
      fog.opticalDepth({&way, 1}, {&inFog, 1});
      puff.opticalDepth({&way, 1}, {&inPuff, 1});
      const double passed = std::exp(-before - 0.5 * step * fog.extinction(point));
      if (!blocked)
        sum += step * fog.extinction(point) * passed * spot.irradiance(point)[0] *
               std::exp(-inFog - inPuff) / (4 * std::numbers::pi);
      before += step * fog.extinction(point);
    }
    brightest = std::max(brightest, sum);
    worst = std::max(worst, std::abs(fast.emitted[0] - sum));
  }
  EXPECT_GT(brightest, 1e-4);
  EXPECT_LT(worst, 1e-2 * brightest) << "the puff's sides are sharp";
  const Segment behind{Vec3(18.11, 2, 3), Vec3::UnitY(), 0, 15};
  Radiance dark;
  lit.radiance({&behind, 1}, {&dark, 1});
  EXPECT_EQ(dark.emitted[0], 0) << "1 cm behind the wall";
}

}  // namespace
}  // namespace volute
