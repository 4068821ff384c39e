// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/gltf_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "volute/io/testing.hpp"

namespace volute {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// A camera that looks along x, its picture's upper side along glTF's y, below a node that moves
/// it.
json simple() {
  const double s = std::numbers::sqrt2 / 2;
  return {
      {"asset", {{"version", "2.0"}}},
      {"scene", 0},
      {"scenes", json::array({{{"nodes", json::array({1})}}})},
      {"nodes", json::array({{{"camera", 0}, {"name", "Shot"}, {"rotation", {0, -s, 0, s}}},
                             {{"children", json::array({0})}, {"translation", {-100, 5, 7}}}})},
      {"cameras",
       json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}})}};
}

class GltfCamera : public ::testing::Test {
 protected:
  Result<CameraDescription> read(const std::string& text, const char* name = "a.gltf") {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return readCamera(folder_ / name);
  }

  testing::TempFolder folder_;
};

TEST_F(GltfCamera, IsTurnedAsItsGeometryIs) {
  const auto camera = read(simple().dump());
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_LT((camera->view.eye - Vec3(-100, -7, 5)).norm(), 1e-12);
  EXPECT_LT((camera->view.target - Vec3(-99, -7, 5)).norm(), 1e-12);
  EXPECT_LT((camera->view.up - Vec3(0, 0, 1)).norm(), 1e-12);
  EXPECT_NEAR(*camera->fov, 0.5 * 180 / std::numbers::pi, 1e-12);
  EXPECT_FALSE(camera->ortho);
  EXPECT_FALSE(camera->aspect);
}

TEST_F(GltfCamera, StatesTheShapeOfItsPictures) {
  json gltf = simple();
  gltf["cameras"][0]["perspective"]["aspectRatio"] = 1.5;
  EXPECT_EQ(read(gltf.dump())->aspect, 1.5);
}

TEST_F(GltfCamera, WhatIsThereTwiceIsRefused) {
  std::string twice = simple().dump();
  twice.insert(twice.find("\"yfov\""), "\"yfov\":0.2,");
  EXPECT_THAT(read(twice).error().message, HasSubstr("'yfov' is there twice"));
  json other = simple();
  other["asset"]["version"] = "1.0";
  EXPECT_THAT(read(other.dump()).error().message, HasSubstr("/asset/version is 1.0"));
}

TEST_F(GltfCamera, OfABinaryFileIsTheSame) {
  const std::string text = simple().dump();
  const auto size = static_cast<std::uint32_t>(text.size());
  const std::uint32_t header[] = {0x46546C67, 2, 20 + size, size, 0x4E4F534A};
  const auto camera =
      read(std::string(reinterpret_cast<const char*>(header), sizeof header) + text, "a.glb");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_LT((camera->view.eye - Vec3(-100, -7, 5)).norm(), 1e-12);
  EXPECT_FALSE(read(std::string(reinterpret_cast<const char*>(header), sizeof header), "a.glb"));
}

TEST_F(GltfCamera, OfParallelRays) {
  json gltf = simple();
  gltf["cameras"][0] = {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 3}}}};
  const auto camera = read(gltf.dump());
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(*camera->ortho, 6);
  EXPECT_NEAR(*camera->aspect, 4 / 3.0, 1e-12);
}

TEST_F(GltfCamera, WhatIsNotOneCameraThatStandsIsRefused) {
  const auto message = [&](const json& gltf) { return read(gltf.dump()).error().message; };
  json gltf = simple();
  gltf["nodes"].push_back({{"camera", 0}, {"name", "Other"}});
  gltf["scenes"][0]["nodes"] = {1, 2};
  EXPECT_THAT(message(gltf), HasSubstr("the cameras Shot, Other; expected one"));
  gltf["scenes"][0]["nodes"] = json::array();
  EXPECT_THAT(message(gltf), HasSubstr("no camera"));
  gltf = simple();
  gltf["animations"] = {{{"channels", {{{"target", {{"node", 1}, {"path", "translation"}}}}}}}};
  EXPECT_THAT(message(gltf), HasSubstr("moves"));
  gltf = simple();
  gltf["nodes"][0]["children"] = {1};
  EXPECT_THAT(message(gltf), HasSubstr("contain each other"));
  gltf = simple();
  gltf["nodes"][0]["camera"] = 9;
  EXPECT_THAT(message(gltf), HasSubstr("a.gltf: not a whole glTF 2.0 file"));
  gltf = simple();
  gltf["cameras"][0]["perspective"]["yfov"] = 0;
  EXPECT_THAT(message(gltf), HasSubstr("field of view"));
  EXPECT_THAT(read("{").error().message, HasSubstr("not a whole glTF 2.0 file"));
}

}  // namespace
}  // namespace volute
