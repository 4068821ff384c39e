// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/surfaces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "volute/fog/fog_medium.hpp"
#include "volute/render/render.hpp"

namespace volute {
namespace {

void addQuad(std::vector<Triangle>& triangles, const Vec3& corner, const Vec3& a, const Vec3& b,
             std::uint32_t material = 0) {
  triangles.push_back({{corner, corner + a, corner + a + b}, material});
  triangles.push_back({{corner, corner + a + b, corner + b}, material});
}

/// A floor of 20 x 20 m at z = 0, and perhaps a roof over x > 0 at z = 3.
TriangleScene floorAndRoof(bool roof) {
  std::vector<Triangle> triangles;
  addQuad(triangles, Vec3(-10, -10, 0), Vec3(20, 0, 0), Vec3(0, 20, 0), 1);
  if (roof)
    addQuad(triangles, Vec3(0, -10, 3), Vec3(10, 0, 0), Vec3(0, 20, 0));
  return *TriangleScene::build(triangles, {{}, {Rgb(0.2, 0.4, 0.6), Rgb(0, 0, 0.5)}});
}

Rgb seenFrom(const SurfaceScene& scene, const Vec3& eye, const Vec3& target) {
  const Segment ray{eye, (target - eye).normalized(), 0, 1e9};
  return lookAtSurfaces(scene, {&ray, 1})[0].radiance;
}

Lamp sun(const Vec3& direction) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = direction.normalized();
  lamp.intensity = Rgb(3, 3, 3);
  return lamp;
}

Lamp spot(const Vec3& position, double cone) {
  Lamp lamp;
  lamp.position = position;
  lamp.coneCosine = std::cos(cone);
  lamp.intensity = Rgb(10, 20, 30);
  return lamp;
}

/// Homogeneous fog up to z = 2.
AnyMedium slab(double extinction) {
  SplineGrid ones(40, 40);
  std::ranges::fill(ones.c, extinction);
  return AnyMedium(*FogMedium::make(*FogMap::fromCoefficients(ones, {Vec3(-20, -20, 0), 1, 1}),
                                    *FogProfile::slab(0, 2), {.degree = 0}));
}

TEST(Surfaces, SunsLightByLambert) {
  const TriangleScene geometry = floorAndRoof(false);
  const Lamp lamp = sun(Vec3(1, 0, -1));
  const Rgb seen = seenFrom({geometry, {&lamp, 1}}, Vec3(1, 2, 5), Vec3(-3, 1, 0));
  const double light = 3 * std::sqrt(0.5) / std::numbers::pi;
  EXPECT_NEAR(seen[0], 0.2 * light, 1e-12);
  EXPECT_NEAR(seen[2], 0.5 + 0.6 * light, 1e-12);
  // From below one sees the side that the sun does not meet.
  EXPECT_NEAR(seenFrom({geometry, {&lamp, 1}}, Vec3(1, 2, -5), Vec3(-3, 1, 0))[0], 0, 1e-12);
}

TEST(Surfaces, LampsThatShineAllAroundHaveNoRim) {
  Lamp lamp = spot(Vec3(0, 0, 4), std::numbers::pi);
  lamp.direction = Vec3::UnitZ(), lamp.coneCosine = -1, lamp.edge = 0.1;
  const TriangleScene geometry = floorAndRoof(false);
  const SurfaceScene scene{geometry, {&lamp, 1}};
  EXPECT_NEAR(seenFrom(scene, Vec3(1, 2, 5), Vec3::Zero())[1], 0.4 / std::numbers::pi * 20 / 16,
              1e-12);
}

TEST(Surfaces, LampsInThePlaneOfASurfaceShineToBothSidesAndNotOnIt) {
  const TriangleScene geometry = floorAndRoof(true);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 200; ++i) {
    const Lamp lamp = spot(Vec3(1 + 5 * uniform(random), 8 * uniform(random) - 4, 3), 3.2);
    const SurfaceScene lit{geometry, {&lamp, 1}};
    SurfaceScene clear = lit;
    clear.shadows = false;
    const Vec3 eye(2.1, 0.3, 2), floor(9 * uniform(random), 9 * uniform(random) - 4, 0);
    EXPECT_EQ(seenFrom(lit, eye, floor)[1], seenFrom(clear, eye, floor)[1]);
    EXPECT_GT(seenFrom(lit, eye, floor)[1], 0);
    const Vec3 roof = lamp.position + Vec3(0.02 * uniform(random), 0.01, 0);
    EXPECT_EQ(seenFrom(lit, eye, roof)[1], 0);
  }
}

TEST(Surfaces, SpotsFadeWithDistanceAndEndAtTheirCone) {
  const TriangleScene geometry = floorAndRoof(false);
  const Lamp lamp = spot(Vec3(0, 0, 4), std::numbers::pi / 6);
  const auto seen = [&](const Vec3& target) {
    return seenFrom({geometry, {&lamp, 1}}, Vec3(1, 2, 5), target)[1];
  };
  EXPECT_NEAR(seen(Vec3::Zero()), 0.4 / std::numbers::pi * 20 / 16, 1e-12);
  const Vec3 aside(1, 0.5, 0);
  const double distance = (lamp.position - aside).norm();
  EXPECT_NEAR(seen(aside), 0.4 / std::numbers::pi * 20 / (distance * distance) * (4 / distance),
              1e-12);
  EXPECT_EQ(seen(Vec3(2.4, 0, 0)), 0);  // 4 tan(30 degrees) = 2.31
}

TEST(Surfaces, SurfacesAndMediaStandInTheLight) {
  const TriangleScene geometry = floorAndRoof(true);
  const Lamp lamp = sun(Vec3(0, 0, -1));
  const AnyMedium fog = slab(0.3);
  const auto seen = [&](const Vec3& target, std::span<const AnyMedium> media) {
    return seenFrom({geometry, {&lamp, 1}, Rgb::Constant(0.25), media}, target + Vec3(-0.3, 0.2, 1),
                    target)[0];
  };
  const double lit = 0.2 * 3 / std::numbers::pi, ambient = 0.2 * 0.25;
  EXPECT_NEAR(seen(Vec3(-1, 0, 0), {}), lit + ambient, 1e-12);
  EXPECT_NEAR(seen(Vec3(1, 0, 0), {}), ambient, 1e-12);
  EXPECT_NEAR(seen(Vec3(-1e-4, 0, 0), {}), lit + ambient, 1e-12);
  EXPECT_NEAR(seen(Vec3(1e-4, 0, 0), {}), ambient, 1e-12);
  EXPECT_NEAR(seen(Vec3(-1, 0, 0), {&fog, 1}), lit * std::exp(-0.6) + ambient, 1e-6);
}

/// The whole chain: a picture of media that end at the surfaces, over the surfaces' picture.
TEST(Surfaces, MediaEndAtThem) {
  const TriangleScene geometry = floorAndRoof(false);
  const AnyMedium fog = slab(0.3);
  const Camera camera =
      Camera::pinhole({Vec3(0.3, -4, 1.5), Vec3(0, 0, 0.5), Vec3::UnitZ()}, 60, 40, 30);
  Progress progress;
  const SurfaceScene scene{geometry, {}, Rgb::Constant(1)};
  const SurfacePicture surfaces = *renderSurfaces(camera, scene, Rgb(7, 7, 7), progress);
  RenderOptions options;
  options.behind = &surfaces.color;
  const Image image = *render(camera, {&fog, 1}, options, progress, nullptr, surfaces.depth);
  int floorPixels = 0;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      const double toFloor = -ray.origin.z() / ray.direction.z();
      const Vec3 foot = ray.at(toFloor);
      if (toFloor < 0 || std::abs(foot.x()) > 9.9 || std::abs(foot.y()) > 9.9)
        continue;
      ++floorPixels;
      EXPECT_NEAR(surfaces.depth[40 * y + x], toFloor, 1e-6 * toFloor);
      const double passed = std::exp(-0.3 * toFloor);
      EXPECT_NEAR(image.at(x, y, 0), 0.2 * passed + (1 - passed), 1e-5);
    }
  }
  EXPECT_GT(floorPixels, 400);
  EXPECT_EQ(surfaces.color.at(0, 0, 0), 7);
  EXPECT_TRUE(std::isinf(surfaces.depth[0]));
}

}  // namespace
}  // namespace volute
