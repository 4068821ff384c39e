// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "volute/base/program.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/scene.hpp"

// Level sets are opaque surfaces of a scene.

namespace volute {
namespace {

constexpr int kLevelSetSide = 24;
constexpr double kBallRadius = 0.3;

class SceneLevelSet : public testing::Test {
 protected:
  /// A ball in the middle of 1 m.
  void SetUp() override {
    GridTarget target;
    VolumeInfo& info = target.info;
    info.name = "hull";
    info.frames = 1;
    info.x = info.y = info.z = kLevelSetSide;
    info.fillDefaults();
    target.description.type = "float";
    target.description.gridClass = "level set";
    const double voxel = 1.0 / kLevelSetSide, band = 3 * voxel;
    target.description.background[0] = static_cast<float>(band);
    std::vector<float> values;
    for (int z = 0; z < kLevelSetSide; ++z)
      for (int y = 0; y < kLevelSetSide; ++y)
        for (int x = 0; x < kLevelSetSide; ++x) {
          const double far = voxel * Vec3(x - 11.5, y - 11.5, z - 11.5).norm();
          values.push_back(static_cast<float>(std::clamp(far - kBallRadius, -band, band)));
        }
    const auto background = static_cast<float>(band);
    auto sink = createCacheSink(folder_ / "ball.vdb", {target}, {});
    if (!sink)
      GTEST_SKIP() << sink.error().message;
    const Bricks bricks = Bricks::fromDense(info, values, {background, background, background});
    ASSERT_TRUE((*sink)->writeFrame(std::span(&bricks, 1)));
    ASSERT_TRUE((*sink)->finish());
  }

  SceneSnapshot at(const std::string& members) {
    const auto json =
        nlohmann::ordered_json::parse(R"({"format": "volute-scene-2", )" + members + "}");
    SceneOptions pictures;
    pictures.files.measured = false;
    auto scene = Scene::make(json, (folder_ / "scene.json").string(), pictures, remarks_);
    EXPECT_TRUE(scene) << scene.error().message;
    if (!scene)
      return {};
    auto snapshot = scene->at({}, remarks_);
    EXPECT_TRUE(snapshot) << snapshot.error().message;
    return snapshot.value_or(SceneSnapshot());
  }

  class Remarks : public Progress {
   public:
    void remark(const Remark& said) override { text += said.sentence + "\n"; }

    std::string text;
  };

  ScratchFolder folder_;
  Remarks remarks_;
};

TEST_F(SceneLevelSet, AreSurfacesInTheLightOfAStudioOrOfTheScene) {
  const SceneSnapshot alone = at(R"("media": [{"kind": "volume", "file": "ball.vdb"}])");
  EXPECT_THAT(remarks_.text, testing::HasSubstr("the surface of the level set"));
  EXPECT_THAT(remarks_.text, testing::Not(testing::HasSubstr("what glows")));
  ASSERT_FALSE(alone.geometry.empty());
  EXPECT_EQ(alone.lights.lamps.size(), 1u);
  const Segment down{Vec3(0.5, 0.5, 3), -Vec3::UnitZ(), 0, 10};
  const auto top = lookAtSurfaces({alone.geometry, alone.lights.lamps}, {&down, 1});
  EXPECT_NEAR(top[0].hit.distance, 2.5 - kBallRadius, 3e-3);
  EXPECT_GT(top[0].radiance.minCoeff(), 0.1);
  // What is left of it among the media holds nothing.
  std::vector<AnyMedium> media;
  alone.media[0]->addMedia(media);
  alone.media[0]->addExtinction(media);
  const auto through =
      lookAtSurfaces({alone.geometry, alone.lights.lamps, Rgb::Zero(), media}, {&down, 1});
  EXPECT_EQ(through[0].radiance[1], top[0].radiance[1]);

  const SceneSnapshot lit = at(R"("media": [{"kind": "volume", "file": "ball.vdb",
      "transform": [2,0,0,10, 0,2,0,0, 0,0,2,0, 0,0,0,1]}],
      "lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [3, 3, 3]}])");
  ASSERT_EQ(lit.lights.lamps.size(), 1u);
  const Segment moved{Vec3(11, 1, 6), -Vec3::UnitZ(), 0, 10};
  const auto there = lookAtSurfaces({lit.geometry, lit.lights.lamps}, {&moved, 1});
  EXPECT_NEAR(there[0].hit.distance, 5 - 2 * kBallRadius, 6e-3);
  EXPECT_NEAR(there[0].radiance[1] * std::numbers::pi / (0.7 * 3), 1, 0.02);
}

/// As a volume of the scene it shadows smoke as its geometry does, until it is taken for matter.
TEST_F(SceneLevelSet, ShadowSmoke) {
  VolumeInfo info;
  info.frames = 1;
  info.x = info.y = info.z = 16;
  info.fillDefaults();
  auto sink = NpySink::create(folder_ / "smoke.npy", info);
  ASSERT_TRUE(sink && (*sink)->writeFrame(std::vector<float>(16 * 16 * 16, 1.0F)));
  ASSERT_TRUE((*sink)->finish());
  const std::string smoke =
      R"({"kind": "volume", "file": "smoke.npy", "bounds": [[0, 0, 0], [1, 1, 1]],
      "emission": 0, "extinction": 1, "albedo": [0.8, 0.8, 0.8]})";
  const std::string ball = R"({"kind": "volume", "file": "ball.vdb"})";
  const std::string sun =
      R"("lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [3, 3, 3]}])";
  const auto below = [&](const std::string& media, const std::string& more) {
    const SceneSnapshot lit = at(fmt::format(R"("media": [{}], {}{})", media, more, sun));
    std::vector<AnyMedium> parts;
    for (const auto& medium : lit.media) medium->addMedia(parts);
    const Segment ray{Vec3(0.4, 0.5, 0.05), Vec3::UnitX(), 0, 0.2};
    double light = 0;
    for (const AnyMedium& part : parts) {
      Radiance radiance;
      part.radiance({&ray, 1}, {&radiance, 1});
      light += radiance.emitted[1];
    }
    return light;
  };
  const std::string geometry = R"("geometry": [{"file": "ball.vdb"}], )";
  const double bare = below(smoke, ""), shadowed = below(smoke, geometry);
  EXPECT_GT(bare, 0.01);
  EXPECT_LT(shadowed, 0.01 * bare);
  EXPECT_DOUBLE_EQ(below(smoke + ", " + ball, ""), shadowed);
  EXPECT_DOUBLE_EQ(below(ball + ", " + smoke, ""), shadowed);
}

/// A ball in the sun is as bright as its normals say, up to where night begins.
TEST_F(SceneLevelSet, AreLitAsWhatTheyAre) {
  const Vec3 light = Vec3(1, -0.5, 0.8).normalized();
  const SceneSnapshot lit = at(fmt::format(
      R"("media": [{{"kind": "volume", "file": "ball.vdb"}}],
      "lights": [{{"kind": "sun", "direction": [{}, {}, {}], "radiance": [1, 1, 1]}}])",
      -light.x(), -light.y(), -light.z()));
  std::vector<Segment> rays;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x)
      rays.push_back({Vec3(0.2 + x * 0.01, -1, 0.2 + y * 0.01), Vec3::UnitY(), 0, 3});
  const auto points = lookAtSurfaces({lit.geometry, lit.lights.lamps}, rays);
  const double brightest = 0.7 / std::numbers::pi;
  double worst = 0;
  int seen = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vec3 out = rays[i].origin - Vec3(0.5, 0.5, 0.5);
    const double across = std::hypot(out.x(), out.z());
    if (across > 0.97 * kBallRadius)
      continue;
    ASSERT_TRUE(points[i].hit.found());
    const Vec3 normal =
        Vec3(out.x(), -std::sqrt(kBallRadius * kBallRadius - across * across), out.z()) /
        kBallRadius;
    const double expected = brightest * std::max(0.0, normal.dot(light));
    worst = std::max(worst, std::abs(points[i].radiance[1] - expected));
    ++seen;
  }
  EXPECT_GT(seen, 2000);
  EXPECT_LT(worst, 0.025 * brightest);
}

TEST_F(SceneLevelSet, AreDenseMatterWhereThatIsAskedFor) {
  const SceneSnapshot matter =
      at(R"("media": [{"kind": "volume", "file": "ball.vdb", "preset": "smoke"}])");
  EXPECT_THAT(remarks_.text, testing::HasSubstr("dense matter"));
  EXPECT_TRUE(matter.geometry.empty());
}

TEST_F(SceneLevelSet, AsGeometryTheyBlockLightForMedia) {
  const SceneSnapshot fixed = at(R"("geometry": [{"file": "ball.vdb"}])");
  ASSERT_FALSE(fixed.fixedGeometry.empty());
  const Segment through{Vec3(0.5, 0.5, 3), -Vec3::UnitZ(), 0, 10};
  std::uint8_t blocked = 0;
  fixed.fixedGeometry.occluded({&through, 1}, {&blocked, 1});
  EXPECT_EQ(blocked, 1);
}

}  // namespace
}  // namespace volute
