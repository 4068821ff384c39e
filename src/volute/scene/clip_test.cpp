// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/clip.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/program.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/npy.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_edits.hpp"
#include "volute/scene/scene_renderer.hpp"

// What of the media a scene shows, and values as colours: in pictures of the CPU and the reference.

namespace volute {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;

constexpr int kHalvesSide = 16;
constexpr int kClipPixels = 8;

/// 1 m of the value 2 where x < 0.5, and 1 beyond.
class ClippedScene : public ::testing::Test {
 protected:
  void SetUp() override {
    VolumeInfo info;
    info.frames = 1, info.x = info.y = info.z = kHalvesSide;
    info.fillDefaults();
    std::vector<float> values;
    for (int i = 0; i < kHalvesSide * kHalvesSide * kHalvesSide; ++i)
      values.push_back(i % kHalvesSide < kHalvesSide / 2 ? 2 : 1);
    auto sink = NpySink::create((folder_ / "halves.npy").string(), info);
    ASSERT_TRUE(sink && (*sink)->writeFrame(values) && (*sink)->finish());
  }

  Result<Scene> scene(const Json& look, const Json& clip) {
    Json volume = {{"kind", "volume"}, {"file", "halves.npy"}, {"bounds", {{0, 0, 0}, {1, 1, 1}}}};
    volume.update(look);
    const Json json = {{"format", "volute-scene-2"}, {"media", {volume}}, {"clip", clip}};
    SceneOptions options;
    options.files.measured = false;
    return Scene::make(json, (folder_ / "scene.json").string(), options, quiet_);
  }

  /// Along y; the first column is at the smallest x.
  Image picture(Scene& scene, Renderer method, Aov aov = Aov::kNone) {
    auto snapshot = scene.at({}, quiet_);
    EXPECT_TRUE(snapshot) << snapshot.error().message;
    const Camera camera = Camera::orthographic(
        {Vec3(0.5, -4, 0.5), Vec3(0.5, 0, 0.5), Vec3::UnitZ()}, 1, kClipPixels, kClipPixels);
    CpuRenderer renderer(method);
    auto image = renderer.render(*snapshot, camera, {.aov = aov}, quiet_);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }

  /// Through the first column and the last one.
  void expectDepths(const Json& clip, double first, double last) {
    auto made = scene({{"emission", 0}, {"extinction", 3}, {"basis", "box"}}, clip);
    ASSERT_TRUE(made) << made.error().message;
    for (const Renderer method : {Renderer::kCpu, Renderer::kReference}) {
      const Image depth = picture(*made, method, Aov::kOpticalDepth);
      EXPECT_NEAR(depth.at(0, kClipPixels / 2), first, 1e-5) << clip;
      EXPECT_NEAR(depth.at(kClipPixels - 1, kClipPixels / 2), last, 1e-5) << clip;
    }
  }

  std::string message(const Json& clip) {
    const auto made = scene(Json::object(), clip);
    return made ? "no error" : made.error().message;
  }

  ScratchFolder folder_;
  Progress quiet_;
};

TEST_F(ClippedScene, IsCutExactlyWhateverTheVoxels) {
  const double x = 0.5 / kClipPixels;
  expectDepths(Json::array(), 6, 3);
  const Json level = {{"kind", "plane"}, {"point", {0, 0.33, 0}}, {"normal", {0, 5, 0}}};
  expectDepths(Json::array({level}), 6 * 0.33, 3 * 0.33);
  const Json slanted = {{"kind", "plane"}, {"point", {0, 0.7, 0}}, {"normal", {-1, -2, 0}}};
  expectDepths(Json::array({slanted}), 6 * (1 - 0.7 + x / 2), 3 * (1 - 0.7 + (1 - x) / 2));
  const Json box = {{"kind", "box"}, {"min", {0.5, 0.1, 0}}, {"max", {2, 0.42, 1}}};
  expectDepths(Json::array({box}), 0, 3 * 0.32);
  expectDepths(Json::array({box, level}), 0, 3 * 0.23);
  const Json across = {{"kind", "plane"}, {"point", {0.5, 0, 0}}, {"normal", {1, 0, 0}}};
  expectDepths(Json::array({box, across}), 0, 0);
}

TEST_F(ClippedScene, WhatIsWrongIsNamedWithItsPlace) {
  EXPECT_THAT(message(Json::array({{{"kind", "ball"}}})),
              HasSubstr("/clip/0/kind: expected box or plane"));
  EXPECT_THAT(message(Json::array({{{"kind", "box"}, {"min", {0, 0, 0}}}})),
              HasSubstr("/clip/0/max"));
  EXPECT_THAT(message(Json::array({{{"kind", "box"}, {"min", {0, 3, 0}}, {"max", {1, 1, 1}}}})),
              HasSubstr("larger than that of min"));
  EXPECT_THAT(
      message(Json::array({{{"kind", "plane"}, {"point", {0, 3, 0}}, {"normal", {0, 0, 0}}}})),
      HasSubstr("/clip/0/normal"));
  EXPECT_THAT(message(Json::object()), HasSubstr("/clip: expected a list"));
}

TEST_F(ClippedScene, IsAddedMovedAndRemovedByAPerson) {
  auto made = scene(Json::object(), Json::array());
  ASSERT_TRUE(made) << made.error().message;
  Json json = made->json();
  const Box3 bounds = made->bounds();
  ASSERT_TRUE(applyEdit(json, {.kind = SceneEdit::Kind::kAddClipBox, .bounds = bounds}));
  ASSERT_TRUE(applyEdit(json, {.kind = SceneEdit::Kind::kAddClipPlane, .position = {0, 1, 0}}));
  ASSERT_TRUE(made->change(json, quiet_));
  json = made->with("/clip/0/min", {7, 0.2, 0}).value();
  ASSERT_TRUE(made->change(json, quiet_)) << "its end stays beside the other";
  EXPECT_LT(json["clip"][0]["min"][0], 1);
  EXPECT_EQ(json["clip"][0]["min"][1], 0.2);
  json = made->with("/clip/1/normal", {0, 0, 1}).value();
  EXPECT_EQ(json["clip"][1]["normal"], Json({0.0, 0.0, 1.0}));
  ASSERT_TRUE(applyEdit(json, {.kind = SceneEdit::Kind::kDuplicate, .path = "/clip/1"}));
  EXPECT_EQ(json["clip"].size(), 3);
  const auto gone = applyEdit(json, {.kind = SceneEdit::Kind::kRemove, .path = "/clip/0"});
  ASSERT_TRUE(gone);
  EXPECT_EQ(*gone, "the clip is removed");
  EXPECT_EQ(json["clip"][0]["kind"], "plane");
}

TEST_F(ClippedScene, OpaqueValuesHaveTheColoursOfTheMap) {
  const Json transfer = {
      {"map", "plasma"}, {"range", {1, 2}}, {"points", {{0.5, 0}, {1, 900}, {2, 900}}}};
  auto made = scene({{"transfer", transfer}, {"emission", 70}}, Json::array());
  ASSERT_TRUE(made) << made.error().message;
  for (const Renderer method : {Renderer::kCpu, Renderer::kReference}) {
    const Image shown = picture(*made, method);
    const Rgb last = displayColor(ColorMap::kPlasma, 1), first = displayColor(ColorMap::kPlasma, 0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(srgbEncode(shown.at(0, 4, c)), last[c], 0.01) << c;
      EXPECT_NEAR(srgbEncode(shown.at(kClipPixels - 1, 4, c)), first[c], 0.01) << c;
    }
  }
  const auto all = made->parameters();
  EXPECT_NE(std::ranges::find(all, "/media/0/transfer/points/2", &Parameter::path), all.end());
  EXPECT_EQ(std::ranges::find(all, "/media/0/emission", &Parameter::path), all.end())
      << "it is not used";
  Json json = made->with("/media/0/transfer/map", {0}).value();
  EXPECT_FALSE(json["media"][0].contains("transfer")) << "off";
  ASSERT_TRUE(made->change(json, quiet_));
  json = made->with("/media/0/transfer/map", {1}).value();
  EXPECT_EQ(json["media"][0]["transfer"]["range"], Json({1.0, 2.0})) << "the values that are there";
}

}  // namespace
}  // namespace volute
