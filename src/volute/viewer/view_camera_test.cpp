// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace volute {
namespace {

constexpr int kViewWidth = 64, kViewHeight = 48;

void expectNear(const Vec3& a, const Vec3& b) {
  EXPECT_LT((a - b).norm(), 1e-9) << a << " and " << b;
}

TEST(ViewCamera, StartsWhereItIsTold) {
  ViewCamera camera;
  const StartView view{Vec3(1, -2, 0.5), Vec3(0, 3, 1), Vec3::UnitZ(), 55};
  camera.set(view);
  const Camera taken = camera.camera(kViewWidth, kViewHeight);
  expectNear(taken.eye(), view.eye);
  expectNear(taken.forward(), (view.target - view.eye).normalized());
  EXPECT_NEAR(taken.pixelSize(), 2 * std::tan(27.5 * std::numbers::pi / 180) / kViewHeight, 1e-12);
}

TEST(ViewCamera, FramesAsThePictureDoes) {
  const Box3 bounds{Vec3(-1, 0, 0), Vec3(2, 1, 4)};
  ViewCamera camera;
  camera.frame(bounds, kViewWidth, kViewHeight, {});
  const Camera expected = Camera::framing(bounds, kViewWidth, kViewHeight);
  expectNear(camera.camera(kViewWidth, kViewHeight).eye(), expected.eye());
  expectNear(camera.camera(kViewWidth, kViewHeight).forward(), expected.forward());
}

TEST(ViewCamera, OrbitKeepsItsTargetInTheMiddle) {
  ViewCamera camera;
  const Vec3 target(0, 3, 1);
  camera.set({Vec3(1, -2, 0.5), target, Vec3::UnitZ(), 55});
  const double distance = camera.distance();
  camera.drag(120, -35);
  const Camera turned = camera.camera(kViewWidth, kViewHeight);
  const auto place = turned.project(target);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 0.5 * kViewWidth, 1e-6);
  EXPECT_NEAR(place->y(), 0.5 * kViewHeight, 1e-6);
  EXPECT_NEAR((turned.eye() - target).norm(), distance, 1e-9);
  camera.drag(0, 1e6);
  EXPECT_LT(camera.camera(kViewWidth, kViewHeight).forward().z(), 1) << "never upside down";
  camera.zoom(2, camera.pivot());
  EXPECT_LT(camera.distance(), distance);
}

TEST(ViewCamera, PanFollowsTheMouse) {
  ViewCamera camera;
  const Vec3 target(0, 3, 1);
  camera.set({Vec3(1, -2, 0.5), target, Vec3::UnitZ(), 55});
  camera.pan(10, 6, kViewHeight);
  const auto place = camera.camera(kViewWidth, kViewHeight).project(target);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 0.5 * kViewWidth + 10, 1e-6);
  EXPECT_NEAR(place->y(), 0.5 * kViewHeight + 6, 1e-6);
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

TEST(ViewCamera, IsUprightAsItIsTold) {
  for (const Vec3& up : {Vec3(0, 1, 0), Vec3(0, -2, 0), Vec3(0, 0, -1), Vec3(1, 1, 1),
                         Vec3(0, 0, 0), Vec3(0.3, 2, -1)}) {
    SCOPED_TRACE(up);
    const View3 view{Vec3(1, -2, 0.5), Vec3(0, 3, 1), up};
    ViewCamera camera;
    camera.set({view.eye, view.target, up, 55});
    expectNear(camera.camera(kViewWidth, kViewHeight).right(),
               Camera::pinhole(view, 55, kViewWidth, kViewHeight).right());
    expectNear(camera.camera(kViewWidth, kViewHeight).down(),
               Camera::pinhole(view, 55, kViewWidth, kViewHeight).down());
    ViewCamera again;
    again.set(camera.view());
    expectNear(again.camera(kViewWidth, kViewHeight).right(),
               camera.camera(kViewWidth, kViewHeight).right());
    camera.drag(70, 20);  // turns around what is up
    EXPECT_NEAR(camera.camera(kViewWidth, kViewHeight).right().dot(camera.view().up), 0, 1e-12);
    const Vec3 eye = camera.eye();
    camera.walk(0, 0, 2);
    expectNear(camera.eye(), eye + 2 * camera.view().up);
  }
}

TEST(ViewCamera, LooksAlongUpAsCamerasDo) {
  for (const Vec3& up : {Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(-1, 0, 0)}) {
    for (const double sign : {1.0, -1.0}) {
      const View3 view{sign * 4 * up, Vec3::Zero(), up};
      ViewCamera camera;
      camera.set({view.eye, view.target, up, 55});
      const Camera taken = camera.camera(kViewWidth, kViewHeight);
      const Camera expected = Camera::pinhole(view, 55, kViewWidth, kViewHeight);
      expectNear(taken.forward(), expected.forward());
      expectNear(taken.right(), expected.right());
    }
  }
}

TEST(ViewCamera, MovesWithoutTurningToWhereAllIsInView) {
  const Box3 bounds{Vec3(-1, 0, 0), Vec3(5, 4, 3)};
  const ViewCamera::Insets insets{.left = 200, .top = 0, .right = 100, .bottom = 60};
  constexpr int kWidth = 900, kHeight = 600;
  for (const double distance : {0.5, 300.0}) {
    ViewCamera camera;
    camera.set({Vec3(2, 2, 1) + distance * Vec3(1, -2, 0.6), Vec3(2, 2, 1), Vec3::UnitZ(), 30});
    const Vec3 forward = camera.forward();
    camera.fit(bounds, kWidth, kHeight, insets);
    expectNear(camera.forward(), forward);
    EXPECT_EQ(camera.fov(), 30);
    Vec2 from = Vec2::Constant(1e300), to = -from;
    for (int i = 0; i < 8; ++i) {
      const auto seen = camera.camera(kWidth, kHeight)
                            .project({i & 1 ? -1.0 : 5.0, i & 2 ? 0.0 : 4.0, i & 4 ? 0.0 : 3.0});
      ASSERT_TRUE(seen);
      from = from.cwiseMin(*seen), to = to.cwiseMax(*seen);
    }
    EXPECT_GT(from.x(), 200);
    EXPECT_LT(to.x(), 800);
    EXPECT_GT(from.y(), 0);
    EXPECT_LT(to.y(), 540);
    EXPECT_GT(std::max((to - from).x() / 600, (to - from).y() / 540), 0.85) << "it fills the room";
  }
}

TEST(ViewCamera, AParallelOneSeesItsHeight) {
  ViewCamera camera;
  camera.set({Vec3(1, -2, 0.5), Vec3(0, 3, 1), Vec3::UnitZ(), 55, 6});
  const Camera taken = camera.camera(kViewWidth, kViewHeight);
  ASSERT_TRUE(taken.isOrthographic());
  EXPECT_NEAR(taken.pixelSize() * kViewHeight, 6, 1e-12);
  const Vec3 target(0, 3, 1);
  camera.pan(10, 6, kViewHeight);
  const auto place = camera.camera(kViewWidth, kViewHeight).project(target);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 0.5 * kViewWidth + 10, 1e-6);
  EXPECT_NEAR(place->y(), 0.5 * kViewHeight + 6, 1e-6);
  camera.zoom(2, camera.pivot());
  EXPECT_LT(camera.ortho(), 6);
  EXPECT_EQ(camera.view().ortho, camera.ortho());
  const Box3 bounds{Vec3(-1, 0, 0), Vec3(2, 1, 4)};
  camera.frame(bounds, kViewWidth, kViewHeight, {});
  ASSERT_GT(camera.ortho(), 0);
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner(i & 1 ? -1 : 2, i & 2 ? 0 : 1, i & 4 ? 0 : 4);
    const auto seen = camera.camera(kViewWidth, kViewHeight).project(corner);
    ASSERT_TRUE(seen);
    EXPECT_LT(std::abs(seen->y() - 0.5 * kViewHeight), 0.6 * kViewHeight);
  }
}

}  // namespace
}  // namespace volute
