// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/camera/camera.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where a point appears in the image, in pixels: the inverse of Camera::ray.
Vec2 pixelOf(const Camera& camera, const Vec3& point) {
  const Vec3 offset = point - camera.eye();
  const double scale =
      (camera.isOrthographic() ? 1 : 1 / offset.dot(camera.forward())) / camera.pixelSize();
  return {0.5 * camera.width() + scale * offset.dot(camera.right()),
          0.5 * camera.height() + scale * offset.dot(camera.down())};
}

TEST(Camera, ARectangleOfAPictureHasItsRays) {
  const View3 view{{1, -2, 0.5}, {0.2, 0, 0}, {0, 0.1, 1}};
  for (const Camera& whole :
       {Camera::pinhole(view, 50, 200, 100), Camera::orthographic(view, 3, 200, 100)}) {
    const Camera part = whole.cropped(40, 25, 64, 32);
    EXPECT_EQ(part.width(), 64);
    EXPECT_EQ(part.height(), 32);
    const Segment expected = whole.ray(40 + 7.5, 25 + 30.5), ray = part.ray(7.5, 30.5);
    EXPECT_NEAR((ray.origin - expected.origin).norm(), 0, 1e-14);
    EXPECT_NEAR((ray.direction - expected.direction).norm(), 0, 1e-14);
    const auto place = part.project(expected.at(4));
    ASSERT_TRUE(place);
    EXPECT_NEAR((*place - Vec2(7.5, 30.5)).norm(), 0, 1e-9);
  }
}

TEST(Camera, PinholeRaysSpanTheVerticalFieldOfView) {
  const Camera camera = Camera::pinhole({{0, -2, 0}, {0, 0, 0}, {0, 0, 1}}, 60, 200, 100);
  EXPECT_NEAR((camera.ray(100, 50).direction - Vec3::UnitY()).norm(), 0, 1e-15);
  const Vec3 top = camera.ray(100, 0).direction;
  EXPECT_NEAR(std::atan2(top.z(), top.y()), std::numbers::pi / 6, 1e-12);
  const Vec3 left = camera.ray(0, 50).direction;
  EXPECT_NEAR(left.x() / left.y(), -2 * std::tan(std::numbers::pi / 6), 1e-12);
  EXPECT_EQ(camera.ray(3, 4).begin, 0);
  EXPECT_EQ(camera.ray(3, 4).end, kInfinity);
  EXPECT_EQ(camera.ray(3, 4).origin, Vec3(0, -2, 0));
}

TEST(Camera, OrthographicRaysAreParallelAndReachBothWays) {
  const Camera camera = Camera::orthographic({{0, -2, 0}, {0, 0, 0}, {0, 0, 1}}, 4, 200, 100);
  const Segment corner = camera.ray(0, 0);
  EXPECT_NEAR((corner.origin - Vec3(-4, -2, 2)).norm(), 0, 1e-12);
  EXPECT_NEAR((corner.direction - Vec3::UnitY()).norm(), 0, 1e-15);
  EXPECT_EQ(corner.begin, -kInfinity);
  EXPECT_EQ(corner.end, kInfinity);
}

TEST(Camera, DegenerateViewsStillGiveARightHandedFrame) {
  const Vec3 eye(1, 2, 3);
  for (const View3& view :
       {View3{eye, eye, Vec3::UnitZ()}, View3{eye, eye + Vec3::UnitZ(), Vec3::UnitZ()},
        View3{eye, eye - Vec3::UnitX(), Vec3::UnitX()}, View3{eye, Vec3::Zero(), Vec3::Zero()}}) {
    const Camera camera = Camera::pinhole(view, 40, 5, 5);
    EXPECT_NEAR(camera.right().norm(), 1, 1e-12);
    EXPECT_NEAR((camera.right().cross(camera.down()) - camera.forward()).norm(), 0, 1e-12);
  }
}

RC_GTEST_PROP(Camera, RayPassesThroughThePointSeenAtItsPixel, ()) {
  const auto coordinate = [] { return *rc::gen::inRange(-1000, 1000) / 300.0; };
  const View3 view{Vec3(coordinate(), coordinate(), coordinate()),
                   Vec3(9, coordinate(), coordinate()), Vec3::UnitZ()};
  const Camera camera = *rc::gen::arbitrary<bool>() ? Camera::pinhole(view, 50, 33, 21)
                                                    : Camera::orthographic(view, 3, 33, 21);
  const double px = *rc::gen::inRange(0, 330) / 10.0;
  const double py = *rc::gen::inRange(0, 210) / 10.0;
  const Vec2 back = pixelOf(camera, camera.ray(px, py).at(2.5));
  RC_ASSERT(std::abs(back.x() - px) < 1e-9);
  RC_ASSERT(std::abs(back.y() - py) < 1e-9);
}

TEST(Camera, FramingShowsEveryCornerAndWastesLittle) {
  const Box3 bounds{Vec3(-1, 2, 0), Vec3(3, 2.5, 7)};
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(100, 400), std::pair(1, 1)}) {
    const Camera camera = Camera::framing(bounds, width, height);
    double reach = 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner(i & 1 ? -1 : 3, i & 2 ? 2 : 2.5, i & 4 ? 0 : 7);
      const Vec2 pixel = pixelOf(camera, corner);
      reach = std::max(
          {reach, std::abs(2 * pixel.x() / width - 1), std::abs(2 * pixel.y() / height - 1)});
    }
    EXPECT_LT(reach, 1);
    EXPECT_GT(reach, 0.9);
  }
  EXPECT_TRUE(Camera::framing(Box3{}, 4, 4).eye().allFinite());
}

TEST(Camera, ShiftedSeesTheSameElsewhere) {
  for (const Camera& camera :
       {Camera::pinhole({}, 40, 64, 48), Camera::orthographic({}, 2, 64, 48)}) {
    const Segment there = camera.ray(10.75, 20.2),
                  here = camera.shifted(0.25, -0.3).ray(10.5, 20.5);
    EXPECT_LT((there.origin - here.origin).norm(), 1e-12);
    EXPECT_LT((there.direction - here.direction).norm(), 1e-12);
  }
}

TEST(Camera, TurnedSeesWhatTurnsWithIt) {
  const Camera camera = Camera::pinhole({Vec3(1, -3, 1), Vec3(0, 0, 0.5)}, 40, 64, 48);
  const Vec3 middle(0.1, 0.2, 0.3);
  const Camera other = camera.turned(middle, 2 * Vec3::UnitZ(), 0.7);
  const Vec3 seen(0.3, 0.1, 0.4);
  const Mat3 turn = turnAbout(Vec3::UnitZ(), 0.7);
  const auto before = camera.project(seen), after = other.project(middle + turn * (seen - middle));
  ASSERT_TRUE(before && after);
  EXPECT_LT((*before - *after).norm(), 1e-9);
}

TEST(Camera, ResizedSeesTheSame) {
  const Camera camera = Camera::pinhole({Vec3(1, -3, 1), Vec3(0, 0, 0.5)}, 40, 64, 48);
  const Camera small = camera.resized(32, 24);
  const Segment there = camera.ray(20, 30), here = small.ray(10, 15);
  EXPECT_LT((there.direction - here.direction).norm(), 1e-12);
}

}  // namespace
}  // namespace volute
