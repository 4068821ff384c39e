// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/sign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "volute/image/text.hpp"

namespace volute {
namespace {

/// 0.6 x 0.3 m, 2 m before the eye; red is on its left, green on its right, blue adds to the top.
Sign testSign() {
  Sign sign;
  sign.position = Vec3(2, 0, 1);
  sign.normal = Vec3(-3, 0, 0);
  sign.picture = Image(2, 2, 3);
  sign.picture.at(0, 0, 0) = sign.picture.at(0, 1, 0) = 1;
  sign.picture.at(1, 0, 1) = sign.picture.at(1, 1, 1) = 1;
  sign.picture.at(0, 0, 2) = sign.picture.at(1, 0, 2) = 1;
  return sign;
}

/// Looks along +x; pixels of 1 cm at the sign.
Camera testCamera() {
  return Camera::orthographic({Vec3(0, 0, 1), Vec3(2, 0, 1), Vec3::UnitZ()}, 0.4, 80, 40);
}

TEST(Sign, StandsWhereItIs) {
  const Sign sign = testSign();
  const auto pixels = signPixels(testCamera(), {&sign, 1}, {});
  EXPECT_EQ(pixels.size(), 60 * 30u);
  for (const SignPixel& seen : pixels) {
    EXPECT_NEAR(seen.distance, 2, 1e-6);
    EXPECT_NEAR(seen.pixel % 80, 39.5, 30);
    EXPECT_NEAR(seen.pixel / 80, 19.5, 15);
  }
}

TEST(Sign, ShowsItsPictureUprightAndNotMirrored) {
  const Sign sign = testSign();
  const auto pixels = signPixels(testCamera(), {&sign, 1}, {});
  const SignPixel& topLeft = pixels.front();
  const SignPixel& bottomRight = pixels.back();
  EXPECT_NEAR(topLeft.radiance[0], 1, 1e-6);
  EXPECT_NEAR(topLeft.radiance[1], 0, 1e-6);
  EXPECT_NEAR(topLeft.radiance[2], 1, 1e-6);
  EXPECT_NEAR(bottomRight.radiance[0], 0, 1e-6);
  EXPECT_NEAR(bottomRight.radiance[1], 1, 1e-6);
  EXPECT_NEAR(bottomRight.radiance[2], 0, 1e-6);
  double sum = 0;  // bilinear: the mean stays
  for (const SignPixel& seen : pixels) sum += seen.radiance[0];
  EXPECT_NEAR(sum / static_cast<double>(pixels.size()), 0.5, 1e-3);
}

/// Near borders, partly outside of the picture, partly behind the eye, from very close.
TEST(Sign, IsFoundInEveryPixelThatMeetsIt) {
  const Sign sign = testSign();
  std::size_t seen = 0;
  for (int view = 0; view < 200; ++view) {
    const double turn = 0.61 * view, way = 0.05 + 0.01 * view;
    const Vec3 eye(2 - way, 0.4 * std::sin(turn), 1 + 0.3 * std::cos(1.7 * turn));
    const Camera camera = Camera::pinhole(
        {eye, eye + Vec3(1, 1.5 * std::sin(2.3 * turn), std::cos(turn)), Vec3::UnitZ()}, 70, 40,
        30);
    std::vector<std::int32_t> expected, found;
    for (int pixel = 0; pixel < 40 * 30; ++pixel) {
      const Segment ray = camera.ray(pixel % 40 + 0.5, pixel / 40 + 0.5);
      const double s = (2 - ray.origin.x()) / ray.direction.x();
      const Vec3 at = ray.at(s);
      if (ray.direction.x() > 0 && std::abs(at.y()) < 0.3 - 1e-9 &&
          std::abs(at.z() - 1) < 0.15 - 1e-9)
        expected.push_back(pixel);
    }
    for (const SignPixel& pixel : signPixels(camera, {&sign, 1}, {})) found.push_back(pixel.pixel);
    EXPECT_EQ(found, expected) << view;
    seen += found.size();
  }
  EXPECT_GT(seen, 10000u);
}

TEST(Sign, IsHiddenByWhatIsBefore) {
  const Sign sign = testSign();
  std::vector<float> opaque(80 * 40, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < opaque.size(); ++i) opaque[i] = i % 80 < 40 ? 1.9F : 2.0F;
  const auto pixels = signPixels(testCamera(), {&sign, 1}, opaque);
  EXPECT_EQ(pixels.size(), 30 * 30u);  // on the wall it is seen
  for (const SignPixel& seen : pixels) EXPECT_GE(seen.pixel % 80, 40);
}

TEST(Sign, HidesThoseBehind) {
  std::vector<Sign> signs = {testSign(), testSign()};
  signs[0].position.x() = 3;
  const auto pixels = signPixels(testCamera(), signs, {});
  EXPECT_EQ(pixels.size(), 60 * 30u);
  for (const SignPixel& seen : pixels) EXPECT_EQ(seen.sign, 1);
}

TEST(Sign, HasNoBack) {
  Sign sign = testSign();
  sign.normal = Vec3::UnitX();
  EXPECT_TRUE(signPixels(testCamera(), {&sign, 1}, {}).empty());
  sign.normal = Vec3::UnitY();
  EXPECT_TRUE(signPixels(testCamera(), {&sign, 1}, {}).empty());
}

TEST(Sign, IsFoundFromAnyDirection) {
  for (const Vec3& normal : {Vec3(1, 2, 0.3), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(-1, 0.1, -2)}) {
    Sign sign = testSign();
    sign.normal = normal;
    const Vec3 eye = sign.position + 4 * normal.normalized();
    const Camera camera = Camera::pinhole({eye, sign.position, Vec3::UnitZ()}, 10, 64, 64);
    const auto pixels = signPixels(camera, {&sign, 1}, {});
    const double expected = 0.18 / std::pow(4 * camera.pixelSize(), 2);
    EXPECT_NEAR(static_cast<double>(pixels.size()), expected, 0.05 * expected);
    EXPECT_NEAR(sign.right().dot(normal), 0, 1e-12);
    EXPECT_NEAR(sign.right().cross(sign.down()).dot(normal.normalized()), -1, 1e-12);
    EXPECT_LE(sign.down().z(), 0);
  }
}

TEST(Sign, HasAPictureOfItsOwn) {
  const Image picture = exitPicture();
  EXPECT_EQ(picture.channels, 3);
  double ink = 0;
  for (const float value : picture.pixels) ink += value == 1;
  EXPECT_GT(ink, 0.05 * static_cast<double>(picture.pixels.size()));
  EXPECT_LT(ink, 0.5 * static_cast<double>(picture.pixels.size()));
}

TEST(Sign, HasLettersWithSmoothEdges) {
  if (textSize("EXIT", {.size = 100}).height < 100)
    GTEST_SKIP() << "this machine has no letters but those of dots";
  const Image picture = exitPicture();
  int between = 0, dark = picture.width, light = 0;  // between green and white; where letters are
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float red = picture.at(x, y, 0);
      between += red > 0.02F && red < 0.98F;
      if (red > 0.5F)
        dark = std::min(dark, x), light = std::max(light, x);
    }
  }
  EXPECT_GT(between, 300);  // the slopes of the X at least; letters of dots have none
  EXPECT_NEAR(dark, picture.width - 1 - light, 20);  // in the middle
  for (const int y : {0, picture.height - 1}) {
    for (int x = 0; x < picture.width; ++x) EXPECT_EQ(picture.at(x, y, 0), picture.at(0, 0, 0));
  }
}

}  // namespace
}  // namespace volute
