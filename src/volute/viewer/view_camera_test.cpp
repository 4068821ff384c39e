// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace volute {
namespace {

constexpr int kWidth = 64, kHeight = 48;

void expectNear(const Vec3& a, const Vec3& b) {
  EXPECT_LT((a - b).norm(), 1e-9) << a.transpose() << " and " << b.transpose();
}

TEST(ViewCamera, StartsWhereItIsTold) {
  ViewCamera camera;
  const StartView view{Vec3(1, -2, 0.5), Vec3(0, 3, 1), Vec3::UnitZ(), 55};
  camera.set(view);
  const Camera taken = camera.camera(kWidth, kHeight);
  expectNear(taken.eye(), view.eye);
  expectNear(taken.forward(), (view.target - view.eye).normalized());
  EXPECT_NEAR(taken.pixelSize(), 2 * std::tan(27.5 * std::numbers::pi / 180) / kHeight, 1e-12);
}

TEST(ViewCamera, FramesAsThePictureDoes) {
  const Box3 bounds{Vec3(-1, 0, 0), Vec3(2, 1, 4)};
  ViewCamera camera;
  camera.frame(bounds, kWidth, kHeight);
  const Camera expected = Camera::framing(bounds, kWidth, kHeight);
  expectNear(camera.camera(kWidth, kHeight).eye(), expected.eye());
  expectNear(camera.camera(kWidth, kHeight).forward(), expected.forward());
}

TEST(ViewCamera, OrbitKeepsItsTargetInTheMiddle) {
  ViewCamera camera;
  const Vec3 target(0, 3, 1);
  camera.set({Vec3(1, -2, 0.5), target, Vec3::UnitZ(), 55});
  const double distance = camera.distance();
  camera.drag(120, -35);
  const Camera turned = camera.camera(kWidth, kHeight);
  const auto place = turned.project(target);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 0.5 * kWidth, 1e-6);
  EXPECT_NEAR(place->y(), 0.5 * kHeight, 1e-6);
  EXPECT_NEAR((turned.eye() - target).norm(), distance, 1e-9);
  camera.drag(0, 1e6);
  EXPECT_LT(camera.camera(kWidth, kHeight).forward().z(), 1) << "never upside down";
  camera.zoom(2);
  EXPECT_LT(camera.distance(), distance);
}

TEST(ViewCamera, PanFollowsTheMouse) {
  ViewCamera camera;
  const Vec3 target(0, 3, 1);
  camera.set({Vec3(1, -2, 0.5), target, Vec3::UnitZ(), 55});
  camera.pan(10, 6, kHeight);
  const auto place = camera.camera(kWidth, kHeight).project(target);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 0.5 * kWidth + 10, 1e-6);
  EXPECT_NEAR(place->y(), 0.5 * kHeight + 6, 1e-6);
}

TEST(ViewCamera, WalkingStaysAtTheHeightOfTheEye) {
  ViewCamera camera;
  camera.set({Vec3(0, 0, 1.7), Vec3(0, 5, 0), Vec3::UnitZ(), 55});
  camera.setMode(ViewCamera::Mode::kWalk);
  camera.walk(2, 0.5, 0);
  expectNear(camera.eye(), Vec3(0.5, 2, 1.7));
  const Vec3 before = camera.eye();
  camera.drag(50, 20);
  expectNear(camera.eye(), before);
}

}  // namespace
}  // namespace volute
