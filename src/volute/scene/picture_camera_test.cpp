// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/picture_camera.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace volute {
namespace {

Scene sceneOf(const nlohmann::ordered_json& more) {
  Progress quiet;
  nlohmann::ordered_json json = {{"format", "volute-scene-1"}};
  json.update(more);
  return Scene::make(json, "made.json", {}, quiet).value();
}

CameraDescription described(double eyeX, std::optional<Pixels> size) {
  CameraDescription camera;
  camera.view.eye = Vec3(eyeX, 0, 0);
  camera.view.target = Vec3(eyeX, 1, 0);
  camera.fov = 40;
  camera.size = size;
  return camera;
}

TEST(PictureCamera, TheOneAskedForGoesBeforeTheScenes) {
  const Scene scene = sceneOf(
      {{"camera", {{"eye", {5, 0, 0}}, {"target", {5, 1, 0}}, {"fov", 40}, {"size", {64, 48}}}}});
  const auto own = pictureCamera(scene, std::nullopt, std::nullopt).value();
  EXPECT_EQ(own.description->view.eye.x(), 5);
  EXPECT_EQ(own.camera.width(), 64);
  const auto asked = pictureCamera(scene, described(2, std::nullopt), std::nullopt).value();
  EXPECT_EQ(asked.description->view.eye.x(), 2);
  EXPECT_EQ(asked.camera.width(), 800);
  EXPECT_EQ(asked.camera.height(), 600);
  const auto small = pictureCamera(scene, described(2, Pixels{64, 48}), Pixels{10, 20}).value();
  EXPECT_EQ(small.camera.width(), 10);
  EXPECT_EQ(small.camera.height(), 20);
}

TEST(PictureCamera, NothingToFrameIsSaid) {
  const auto none =
      pictureCamera(sceneOf(nlohmann::ordered_json::object()), std::nullopt, std::nullopt);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kInvalidData);
}

}  // namespace
}  // namespace volute
