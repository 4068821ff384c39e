// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/camera_file.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace volute {
namespace {

Result<CameraDescription> parse(const char* text) {
  return parseCamera(nlohmann::json::parse(text), {"scene.json", "/camera"});
}

TEST(CameraFile, ReadsAScenesCamera) {
  const auto camera =
      parse(R"({"eye": [0, -4, 1], "target": [0, 0, 1.5], "fov": 40, "size": [64, 48]})");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->view.eye, Vec3(0, -4, 1));
  EXPECT_EQ(camera->view.up, Vec3::UnitZ());
  EXPECT_EQ(*camera->fov, 40);
  EXPECT_FALSE(camera->ortho);
  EXPECT_EQ(*camera->size, (Pixels{64, 48}));
}

TEST(CameraFile, UnknownNamesAreRefusedWithTheNearest) {
  EXPECT_EQ(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "sizE": [9, 9]})")
                .error()
                .message,
            "scene.json: /camera/sizE: this name is unknown; did you mean 'size'?");
  EXPECT_EQ(parse(R"({"eye": [0, -4, 1], "targte": [0, 0, 0], "fov": 40})").error().message,
            "scene.json: /camera/targte: this name is unknown; did you mean 'target'?");
  EXPECT_EQ(
      parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "xyzzy": 3})").error().message,
      "scene.json: /camera/xyzzy: this name is unknown");
}

TEST(CameraFile, ErrorsNameThePlace) {
  EXPECT_EQ(parse("[]").error().message, "scene.json: /camera: expected a camera object");
  EXPECT_EQ(parse(R"({"eye": [0, -4], "target": [0, 0, 0], "fov": 40})").error().message,
            "scene.json: /camera/eye: expected three numbers [m]");
  EXPECT_EQ(parse(R"({"eye": [0, -4, "x"], "target": [0, 0, 0], "fov": 40})").error().message,
            "scene.json: /camera/eye[2]: expected a number");
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "fov": 40})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0]})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "ortho": 2})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, -4, 1], "fov": 40})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 180})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "ortho": 0})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "size": [0, 48]})"));
  EXPECT_FALSE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "size": [1e99, 48]})"));
}

TEST(CameraFile, AnUpAlongTheViewIsRefused) {
  EXPECT_EQ(parse(R"({"eye": [0, -4, 1], "target": [0, 4, 1], "up": [0, -2, 0], "fov": 40})")
                .error()
                .message,
            "scene.json: /camera: up is along the view, from eye to target; expected another "
            "direction");
  EXPECT_FALSE(parse(R"({"eye": [1, 2, 3], "target": [2, 4, 5], "up": [2, 4, 4], "ortho": 4})"));
  EXPECT_TRUE(parse(R"({"eye": [1, 2, 3], "target": [2, 4, 5], "up": [2, 4, 4.1], "ortho": 4})"));
  // A plan from above: y is upwards where nothing else is stated.
  EXPECT_TRUE(parse(R"({"eye": [0, 0, 9], "target": [0, 0, 0], "ortho": 4})"));
  EXPECT_TRUE(parse(R"({"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 0, 1], "ortho": 4})"));
  EXPECT_FALSE(parse(R"({"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 0, -1], "ortho": 4})"));
}

TEST(CameraFile, KeysAreAWayThatIsSmoothInPlaceAndDirection) {
  const auto camera = parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "keys":
      [[0, 0, -4, 1, 0, 0, 0], [1, 3, -3, 2, 0, 0, 1], [4, 4, 1, 1, 1, 0, 0], [5, 0, 4, 1, 0, 0, 0]]})");
  ASSERT_TRUE(camera) << camera.error().message;
  for (const CameraKey& key : camera->keys) {
    EXPECT_LT((camera->viewAt(key.time).eye - key.eye).norm(), 1e-12);
    EXPECT_LT((camera->viewAt(key.time).target - key.target).norm(), 1e-12);
  }
  EXPECT_EQ(camera->viewAt(-3).eye, Vec3(0, -4, 1));
  EXPECT_EQ(camera->viewAt(9).eye, Vec3(0, 4, 1));
  // Velocities of the eye and of the direction have no jump, neither at keys nor between.
  constexpr double kStep = 1e-4;
  const auto direction = [&](double t) {
    const View3 view = camera->viewAt(t);
    return Vec3((view.target - view.eye).normalized());
  };
  Vec3 before = Vec3::Zero(), turned = Vec3::Zero();
  for (double t = 0.01; t < 4.99; t += 0.005) {
    const Vec3 velocity =
        (camera->viewAt(t + kStep).eye - camera->viewAt(t - kStep).eye) / (2 * kStep);
    const Vec3 turning = (direction(t + kStep) - direction(t - kStep)) / (2 * kStep);
    if (t > 0.02) {
      EXPECT_LT((velocity - before).norm(), 0.3) << t;
      EXPECT_LT((turning - turned).norm(), 0.3) << t;
    }
    before = velocity, turned = turning;
  }
  EXPECT_NE(parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "keys":
      [[1, 0, -4, 1, 0, 0, 0], [1, 3, -3, 2, 0, 0, 1]]})")
                .error()
                .message.find("ascending"),
            std::string::npos);
}

}  // namespace
}  // namespace volute
