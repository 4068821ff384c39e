// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "volute/camera/camera.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

Calibration someCalibration() {
  Calibration calibration;
  calibration.width = 180;
  calibration.height = 144;
  calibration.K = Mat3(187.5, 1.25, 92.3, 0, 191.25, 70.1, 0, 0, 1);
  calibration.R = turnAbout(Vec3(1, -2, 0.5).normalized(), 0.7);
  calibration.t = Vec3(0.2, -0.1, 4.5);
  calibration.distortion = {-0.2, 0.05, 0.002, -0.003, 0.01};
  return calibration;
}

/// OpenCV's cv::projectPoints, written down from its documentation.
Vec2 projectAsOpenCv(const Calibration& c, const Vec3& world) {
  const Vec3 p = c.R * world + c.t;
  const double x = p.x() / p.z(), y = p.y() / p.z();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const auto& d = c.distortion;
  const double radial = 1 + d.k1 * r2 + d.k2 * r4 + d.k3 * r6;
  const double xd = x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x);
  const double yd = y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y;
  return (c.K * Vec3(xd, yd, 1)).head<2>();
}

double coordinate() {
  return *rc::gen::inRange(-1000, 1000) / 1000.0;
}

std::string messageOf(const Calibration& calibration) {
  const auto camera = Camera::calibrated(calibration);
  return camera ? "" : camera.error().message;
}

RC_GTEST_PROP(CalibratedCamera, ProjectsAsOpenCvDoes, ()) {
  const Calibration calibration = someCalibration();
  const Camera camera = Camera::calibrated(calibration).value();
  const Vec3 point(coordinate(), coordinate(), coordinate());
  const auto pixel = camera.project(point);
  RC_ASSERT(pixel.has_value());
  RC_ASSERT((*pixel - projectAsOpenCv(calibration, point)).norm() < 1e-10);
}

RC_GTEST_PROP(CalibratedCamera, RayPassesThroughThePointSeenAtItsPixel, ()) {
  const Camera camera = Camera::calibrated(someCalibration()).value();
  const double px = *rc::gen::inRange(0, 1801) / 10.0, py = *rc::gen::inRange(0, 1441) / 10.0;
  const Segment ray = camera.ray(px, py);
  RC_ASSERT(!ray.empty());
  RC_ASSERT(std::abs(ray.direction.norm() - 1) < 1e-14);
  const auto back = camera.project(ray.at(3.7));
  RC_ASSERT(back.has_value());
  RC_ASSERT((*back - Vec2(px, py)).norm() < 1e-9);
}

TEST(CalibratedCamera, HonoursTheConventionOfPixelCentres) {
  Calibration colmap = someCalibration();
  Calibration openCv = colmap;
  openCv.pixelCentre = 0;
  openCv.K(0, 2) -= 0.5;
  openCv.K(1, 2) -= 0.5;
  const Camera a = Camera::calibrated(colmap).value(), b = Camera::calibrated(openCv).value();
  for (const auto& [x, y] : {std::pair(0.5, 0.5), std::pair(179.5, 30.25), std::pair(60.0, 143.5)})
    EXPECT_NEAR((a.ray(x, y).direction - b.ray(x, y).direction).norm(), 0, 1e-14);
  // The same K means another camera, by half a pixel.
  openCv.K = colmap.K;
  const Camera c = Camera::calibrated(openCv).value();
  EXPECT_NEAR((a.ray(20, 30).direction - c.ray(20.5, 30.5).direction).norm(), 0, 1e-14);
}

TEST(CalibratedCamera, IsThePinholeThatItDescribes) {
  const Camera plain = Camera::pinhole({{0.3, -2, 0.4}, {0, 0, 0}, {0, 0, 1}}, 60, 200, 100);
  Calibration calibration;
  calibration.width = 200;
  calibration.height = 100;
  calibration.K = plain.intrinsics();
  calibration.R = plain.rotation();
  calibration.t = -calibration.R * plain.eye();
  const Camera camera = Camera::calibrated(calibration).value();
  EXPECT_NEAR((camera.eye() - plain.eye()).norm(), 0, 1e-14);
  EXPECT_NEAR((camera.ray(13, 77).direction - plain.ray(13, 77).direction).norm(), 0, 1e-14);
  EXPECT_EQ(camera.intrinsics(), plain.intrinsics());
}

TEST(CalibratedCamera, PointsBehindItAreNotSeen) {
  const Camera camera = Camera::calibrated(someCalibration()).value();
  EXPECT_FALSE(camera.project(camera.eye() - camera.forward()));
  EXPECT_FALSE(camera.project(camera.eye()));
  EXPECT_TRUE(camera.project(camera.eye() + camera.forward()));
}

TEST(CalibratedCamera, RefusesWhatIsNoRotation) {
  Calibration mirrored = someCalibration();
  mirrored.R = Vec3(1, -1, 1).asDiagonal() * mirrored.R;
  EXPECT_THAT(messageOf(mirrored), HasSubstr("R is mirrored (determinant -1)"));
  Calibration scaled = someCalibration();
  scaled.R *= 1.01;
  EXPECT_THAT(messageOf(scaled), HasSubstr("R is no rotation: R R' is off the identity by 0.0201"));
  Calibration notANumber = someCalibration();
  notANumber.R(0, 0) = std::nan("");
  EXPECT_THAT(messageOf(notANumber), HasSubstr("R is not finite"));
}

TEST(CalibratedCamera, RepairsRoundedDigits) {
  Calibration rounded = someCalibration();
  rounded.R = (rounded.R * 1e4).unaryExpr([](double x) { return std::round(x); }) / 1e4;
  const Camera camera = Camera::calibrated(rounded).value();
  EXPECT_NEAR((camera.rotation() * camera.rotation().transpose() - Mat3::Identity()).norm(), 0,
              1e-14);
  EXPECT_NEAR((camera.rotation() - someCalibration().R).norm(), 0, 2e-4);
}

TEST(CalibratedCamera, RefusesImpossibleIntrinsics) {
  Calibration c = someCalibration();
  c.K(0, 0) = -1;
  EXPECT_THAT(messageOf(c), HasSubstr("focal lengths are -1 and 191.25"));
  c = someCalibration();
  c.K(2, 2) = 2;
  EXPECT_THAT(messageOf(c), HasSubstr("K has entries"));
  c = someCalibration();
  c.pixelCentre = 0.25;
  EXPECT_THAT(messageOf(c), HasSubstr("centre is at 0.25"));
}

TEST(Lens, UndoesWhatItDid) {
  for (const Distortion& lens : {Distortion{-0.3, 0.1, 0, 0, 0}, Distortion{0.4, 0, 0.01, -0.02, 0},
                                 Distortion{-0.28, 0.09, 1e-3, 2e-4, -0.012}}) {
    for (double x = -0.8; x <= 0.8; x += 0.1) {
      for (double y = -0.6; y <= 0.6; y += 0.1) {
        const Vec2 point(x, y);
        if (!beforeFold(lens, point))
          continue;
        const auto back = undistort(lens, distort(lens, point));
        ASSERT_TRUE(back.has_value()) << x << " " << y;
        EXPECT_NEAR((*back - point).norm(), 0, 1e-11);
        EXPECT_NEAR((distort(lens, *back) - distort(lens, point)).norm(), 0, 1e-12);
      }
    }
  }
}

TEST(Lens, SaysWhenItCannot) {
  // x (1 - x^2) is at most 2 / (3 sqrt 3) = 0.385, at 0.577.
  const Distortion strong{-1, 0, 0, 0, 0};
  EXPECT_TRUE(undistort(strong, Vec2(0.38, 0)));
  EXPECT_FALSE(undistort(strong, Vec2(0.39, 0)));
  EXPECT_TRUE(beforeFold(strong, Vec2(0.57, 0)));
  EXPECT_FALSE(beforeFold(strong, Vec2(0.6, 0)));
  Calibration c = someCalibration();
  c.distortion = strong;
  EXPECT_THAT(messageOf(c), HasSubstr("the lens distortion cannot be undone at image point (0.0, "
                                      "0.0)"));
  c.K(0, 0) *= 4, c.K(1, 1) *= 4;  // a long lens uses the middle of the polynomial alone
  EXPECT_EQ(messageOf(c), "");
}

}  // namespace
}  // namespace volute
