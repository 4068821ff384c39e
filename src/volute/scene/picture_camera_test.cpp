// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/picture_camera.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/base/program.hpp"
#include "volute/io/npy.hpp"

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

TEST(PictureCamera, PartsOfAViewChangeThemAlone) {
  const auto camera = [](const nlohmann::ordered_json& more, const ViewParts& parts) {
    return pictureCamera(sceneOf(more), std::nullopt, Pixels{64, 48}, parts);
  };
  const nlohmann::ordered_json own = {
      {"camera", {{"eye", {5, 0, 0}}, {"target", {5, 1, 0}}, {"fov", 40}}}};
  const auto wide = camera(own, {.fov = 60}).value();
  EXPECT_EQ(wide.description->view.eye, Vec3(5, 0, 0));
  EXPECT_EQ(wide.description->fov, 60);
  const auto flat = camera(own, {.target = Vec3(0, 0, 0), .ortho = 2}).value();
  EXPECT_EQ(flat.description->view.target, Vec3(0, 0, 0));
  EXPECT_FALSE(flat.description->fov);
  const auto same = camera(own, {.target = Vec3(5, 0, 0)});
  ASSERT_FALSE(same);
  EXPECT_EQ(same.error().code, ErrorCode::kInvalidArgument);

  // A block of 10 x 10 x 2 m without a camera.
  VolumeInfo info;
  info.frames = 1, info.x = info.y = info.z = 2;
  info.fillDefaults();
  const ScratchFolder folder;
  const std::string file = (folder.path() / "block.npy").string();
  auto sink = NpySink::create(file, info);
  ASSERT_TRUE(sink && (*sink)->writeFrame(std::vector<float>(8, 1)) && (*sink)->finish());
  const nlohmann::ordered_json block = {
      {"kind", "volume"}, {"file", file}, {"bounds", {{0, 0, 0}, {10, 10, 2}}}};
  const nlohmann::ordered_json none = {{"media", nlohmann::ordered_json::array({block})}};
  const auto framed = camera(none, {}).value().camera;
  const auto eye = camera(none, {.eye = Vec3(0, -9, 1)}).value();
  EXPECT_EQ(eye.description->view.target, Vec3(5, 5, 1));
  EXPECT_EQ(eye.description->fov, Camera::kUsualFov);
  const auto target = camera(none, {.target = Vec3(1, 5, 1)}).value();
  EXPECT_LT((target.camera.eye() - framed.eye() - Vec3(-4, 0, 0)).norm(), 1e-9);
  const auto fov = camera(none, {.fov = 20}).value();
  EXPECT_GT((fov.camera.eye() - Vec3(5, 5, 1)).norm(), 1.5 * (framed.eye() - Vec3(5, 5, 1)).norm());
}

TEST(PictureCamera, NothingToFrameIsSaid) {
  const auto none =
      pictureCamera(sceneOf(nlohmann::ordered_json::object()), std::nullopt, std::nullopt);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kInvalidData);
}

}  // namespace
}  // namespace volute
