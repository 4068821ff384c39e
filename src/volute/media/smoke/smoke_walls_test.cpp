// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

/// A hall with columns, smoke and one lamp.
struct LitHall {
  SmokeState smoke;
  SceneLights lights;

  LitHall() {
    const auto mesh = hallMesh(0.8, 3);
    smoke.locator = std::make_shared<TetLocator>(mesh);
    smoke.extinction = plume(*mesh, 0, 1);
    for (float& k : smoke.extinction) k *= 0.2F;
    Lamp lamp;
    lamp.position = Vec3(10.1, 6.3, 4.5);
    lamp.intensity = Rgb::Constant(20);
    lights.lamps = {lamp};
    smoke.lampShares = {LampPaths(smoke.locator).shares(smoke.extinction, lamp)};
  }
};

const LitHall& hall() {
  static const LitHall hall;
  return hall;
}

/// Of the lamp's light on the wall in a pixel, what comes through; -1: no wall, or lit from behind.
double shareIn(const SurfaceView& view, const Camera& camera, int x, int y, Vec3& point) {
  const float depth = view.depth[static_cast<std::size_t>(y) * camera.width() + x];
  if (!std::isfinite(depth))
    return -1;
  point = camera.ray(x + 0.5, y + 0.5).at(depth);
  return view.color.at(x, y, 0) / hall().lights.lamps[0].irradiance(point)[0] * std::numbers::pi;
}

TEST(LookAtWalls, ShadowsHaveTheEdgesOfWhatCastsThem) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 64, 48);
  const auto view = lookAtWalls(camera, hall().smoke, hall().lights, Rgb::Constant(1));
  ASSERT_TRUE(view);
  int lit = 0, dark = 0, wrong = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      Vec3 point;
      const double seen = shareIn(*view, camera, x, y, point);
      if (seen < 0)
        continue;
      // From just before the wall: the cosine is not known here, but is at most 1.
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      const Segment way = hall().lights.lamps[0].towards(point - 1e-6 * ray.direction);
      const double expected =
          lampShareReference(*hall().smoke.locator, hall().smoke.extinction, way);
      (expected > 0 ? lit : dark) += 1;
      // What is dark is black, and what is lit is lit.
      wrong += expected > 0.02 ? seen > 1.02 * expected + 0.02 : seen > 0.02;
    }
  }
  EXPECT_GT(lit, 500);
  EXPECT_GT(dark, 200);
  EXPECT_LE(wrong, 6);
}

TEST(LookAtWalls, OtherThingsCastShadowsToo) {
  const Camera camera =
      Camera::pinhole({Vec3(2.3, 6.8, 2.7), Vec3(20, 5, 1), Vec3::UnitZ()}, 70, 64, 48);
  // What is beyond x = 12.3 is behind a screen; the vertices know.
  const Blocks screen = [](std::span<const Segment> ways, std::span<std::uint8_t> blocked) {
    for (std::size_t i = 0; i < ways.size(); ++i) blocked[i] = ways[i].origin.x() > 12.3;
  };
  SmokeState smoke = hall().smoke;
  smoke.lampShares = {
      LampPaths(smoke.locator).shares(smoke.extinction, hall().lights.lamps[0], screen)};
  const auto view = lookAtWalls(camera, smoke, hall().lights, Rgb::Constant(1), screen);
  ASSERT_TRUE(view);
  int behind = 0, before = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      Vec3 point;
      const double seen = shareIn(*view, camera, x, y, point);
      if (seen < 0)
        continue;
      if (point.x() > 12.3) {
        EXPECT_LE(seen, 0.011) << point.transpose();
        ++behind;
      } else {
        before += seen > 0.05;
      }
    }
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(before, 100);
}

}  // namespace
}  // namespace volute
