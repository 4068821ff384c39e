// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/valley.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

const Valley& valley() {
  static const Valley made(1);
  return made;
}

TEST(Valley, DepthLiesOnTheGround) {
  const Camera camera = Camera::pinhole(valley().view(), 50, 64, 36);
  const Valley::Frame frame = valley().look(camera);
  int ground = 0, near = 0;
  for (int y = 0; y < 36; ++y) {
    for (int x = 0; x < 64; ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      const double s = frame.depth.at(x, y) / ray.direction.dot(camera.forward());
      if (!std::isfinite(s))
        continue;
      ++ground;
      const Vec3 point = ray.at(s);
      near += std::abs(point.z() - valley().height(point.x(), point.y())) < 0.3;
    }
  }
  EXPECT_GT(ground, 64 * 36 / 3);
  EXPECT_GT(near, 0.85 * ground);  // the others are on walls and trees
}

TEST(Valley, TheSameSeedGivesTheSamePicture) {
  const ThreadLimit one(1);
  const Camera camera = Camera::pinhole(valley().flight(0.3), 50, 32, 18);
  EXPECT_EQ(valley().look(camera).color.pixels, Valley(1).look(camera).color.pixels);
  EXPECT_NE(valley().look(camera).color.pixels, Valley(2).look(camera).color.pixels);
}

TEST(Valley, FlightsStayAboveTheGround) {
  for (int i = 0; i <= 100; ++i) {
    const Vec3 eye = valley().flight(i / 100.0).eye;
    EXPECT_GT(eye.z(), valley().height(eye.x(), eye.y()) + 1) << i;
  }
}

TEST(Valley, FogLiesAlongTheRiverOnly) {
  const Image map = valley().fogMap(64);
  const auto [least, most] = std::ranges::minmax(map.pixels);
  EXPECT_EQ(least, 0);
  EXPECT_GT(most, 0.9);
  for (const float value : map.pixels) EXPECT_EQ(value * 255, std::round(value * 255));
}

}  // namespace
}  // namespace volute
