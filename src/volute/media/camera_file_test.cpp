// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/camera_file.hpp"

#include <gtest/gtest.h>

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
      parse(R"({"eye": [0, -4, 1], "target": [0, 0, 0], "fov": 40, "lens": 3})").error().message,
      "scene.json: /camera/lens: this name is unknown");
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

}  // namespace
}  // namespace volute
