// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/first_sight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "volute/base/program.hpp"
#include "volute/io/npy.hpp"
#include "volute/volume_files/grid_compression.hpp"

namespace volute {
namespace {

constexpr int kSide = 20;  ///< voxels of 5 cm

/// A folder with a blob of some 20 cm in a corner of 1 m, whose frames are as bright as they say.
class FirstSights : public testing::Test {
 protected:
  /// @param around  of what is within 40 cm of it, as a share
  std::string blob(const std::vector<float>& brightness, float around = 0) const {
    VolumeInfo info;
    info.frames = static_cast<int>(brightness.size());
    info.x = info.y = info.z = kSide;
    info.fillDefaults();
    const std::string path = (folder_ / "blob.npy").string();
    auto sink = NpySink::create(path, info);
    EXPECT_TRUE(sink);
    for (const float bright : brightness) {
      std::vector<float> values;
      for (int z = 0; z < kSide; ++z) {
        for (int y = 0; y < kSide; ++y) {
          for (int x = 0; x < kSide; ++x) {
            const double far = std::hypot(x - 3, y - 3, z - 3);
            values.push_back(far < 2.5 ? bright : far < 8 ? around * bright : 0);
          }
        }
      }
      EXPECT_TRUE((*sink)->writeFrame(values));
    }
    EXPECT_TRUE((*sink)->finish());
    return path;
  }

  static FirstSight sightOf(const std::string& path, const char* preset = "none") {
    Progress quiet;
    SceneOptions options{.assume = true};
    options.members = nlohmann::ordered_json{{"preset", preset}};
    auto scene = Scene::open(path, options, quiet);
    EXPECT_TRUE(scene) << scene.error().message;
    auto sight = firstSight(*scene, quiet);
    EXPECT_TRUE(sight);
    return sight.value_or(FirstSight());
  }

  ScratchFolder folder_;
};

TEST_F(FirstSights, AFileIsOfNoOtherKindThanItIs) {
  Progress quiet;
  SceneOptions options{.assume = true};
  const std::string path = blob({1, 1});
  for (const char* kind : {"volume", "fog"}) {
    options.members = nlohmann::ordered_json{{"kind", kind}};
    const auto scene = Scene::open(path, options, quiet);
    EXPECT_EQ(scene.has_value(), std::string_view(kind) == "volume");
    if (!scene) {
      EXPECT_THAT(scene.error().message, ::testing::HasSubstr("of kind \"volume\"; leave it out"));
    }
  }
}

TEST_F(FirstSights, IsAroundTheContentNotTheBounds) {
  const FirstSight sight = sightOf(blob({1, 1}));
  EXPECT_EQ(sight.time, 0);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(sight.content.min[axis], 0.0 - 1e-9);
    EXPECT_LE(sight.content.min[axis], 0.05 + 1e-9);
    EXPECT_NEAR(sight.content.max[axis], 0.3, 0.051);
  }
}

TEST_F(FirstSights, TakesInThinSmokeAroundDenseSmoke) {
  const std::string path = blob({1}, 0.02F);
  EXPECT_LT(sightOf(path).content.max.x(), 0.36);
  EXPECT_GT(sightOf(path, "smoke").content.max.x(), 0.49);
}

TEST_F(FirstSights, IsWhenThereIsSomethingToSee) {
  const FirstSight sight = sightOf(blob({0, 0.01F, 0.02F, 1, 1, 1, 1, 1, 1}));
  EXPECT_GE(sight.time, 3 / 25.0 - 1e-9);
  EXPECT_THAT(sight.reason, ::testing::HasSubstr("half of the most"));
  EXPECT_LT(sight.content.max.x(), 0.4);
}

TEST_F(FirstSights, OfAVoluteReadsTheFrameThatItChooses) {
  const std::string path = blob({0, 0.01F, 0.02F, 1, 1, 1, 1, 1, 1}),
                    packed = (folder_ / "blob.volute").string();
  Progress quiet;
  Reading reading{quiet, std::uint64_t{1} << 30};
  Team alone;
  ASSERT_TRUE(compressVolume(path, packed, {}, {}, reading, alone));
  auto scene = Scene::open(packed, {.assume = true}, quiet);
  ASSERT_TRUE(scene);
  const auto read = [&] {
    return scene->media().front()->counts().at("blocks_decoded").get<std::uint64_t>();
  };
  const std::uint64_t before = read();
  const auto sight = firstSight(*scene, quiet);
  ASSERT_TRUE(sight);
  EXPECT_NEAR(sight->time, 3 / 25.0, 1e-9);
  EXPECT_THAT(sight->reason, ::testing::HasSubstr("the first of 9 with at least half of the most"));
  EXPECT_LT(sight->content.max.x(), 0.4);
  EXPECT_LE(read() - before, 8u) << "blocks of one frame";
}

TEST_F(FirstSights, IsTheFirstTimeWhereThatServes) {
  const FirstSight sight = sightOf(blob({0.5F, 1, 1, 1}));
  EXPECT_EQ(sight.time, 0);
  EXPECT_EQ(sight.reason, "");
}

TEST_F(FirstSights, OfNothingIsTheBounds) {
  const FirstSight sight = sightOf(blob({0, 0}));
  EXPECT_EQ(sight.time, 0);
  EXPECT_NEAR(sight.content.size().x(), 1, 0.11);
}

TEST_F(FirstSights, HasNearSurfacesAndFlatOnes) {
  blob({1});
  std::ofstream(folder_ / "ground.obj")
      << "v -90 -90 0\nv 90 -90 0\nv 90 90 0\nv -90 90 0\nf 1 2 3 4\n";
  std::ofstream(folder_ / "scene.json") << R"({"format": "volute-scene-1",
    "camera": {"eye": [0, -3, 1], "target": [0, 0, 0], "fov": 40}, "geometry": [{"file": "ground.obj"}],
    "media": [{"kind": "volume", "file": "blob.npy"}]})";
  const FirstSight near = sightOf((folder_ / "scene.json").string());
  EXPECT_LT(near.content.size().x(), 1.0) << "a large ground is no content";
  EXPECT_GT(near.content.size().x(), 0.3);
  std::ofstream(folder_ / "bare.json") << R"({"format": "volute-scene-1",
    "camera": {"eye": [0, -3, 1], "target": [0, 0, 0], "fov": 40}, "geometry": [{"file": "ground.obj"}]})";
  const FirstSight flat = sightOf((folder_ / "bare.json").string());
  EXPECT_EQ(flat.content.size().x(), 180);
  EXPECT_GT(flat.content.size().z(), 0);
}

/// Light in a medium at some places.
std::vector<Rgb> lightIn(const SceneSnapshot& snapshot) {
  std::vector<AnyMedium> media;
  snapshot.media[0]->addMedia(media);
  std::vector<Rgb> light;
  for (double x = 0.05; x < 0.5; x += 0.02) light.push_back(media[0].emission({x, 0.22, 0.19}));
  return light;
}

TEST_F(FirstSights, WhatMovesHasLessDetailAndNearlyTheSameLight) {
  Progress quiet;
  SceneOptions options{.assume = true};
  options.members = nlohmann::ordered_json{{"preset", "smoke"}};
  auto scene = Scene::open(blob({1, 2}, 0.4F), options, quiet);
  ASSERT_TRUE(scene) << scene.error().message;
  scene->setViews({Camera::framing(scene->bounds(), 400, 300)});  // close: splines
  const auto moving = scene->at({.time = 0, .moving = true}, quiet);
  ASSERT_TRUE(moving);
  EXPECT_TRUE(moving->media[0]->provisional());
  const auto whole = scene->at({.time = 0}, quiet);
  ASSERT_TRUE(whole);
  EXPECT_FALSE(whole->media[0]->provisional());
  const auto again = scene->at({.time = 0, .moving = true}, quiet);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->media[0]->provisional()) << "it is known already";
  const auto a = lightIn(*moving), b = lightIn(*whole);
  double most = 0, off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, b[i].maxCoeff());
    off += (a[i] - b[i]).abs().maxCoeff() / static_cast<double>(a.size());
  }
  EXPECT_GT(off, 0);
  EXPECT_LT(off, 0.1 * most);
}

}  // namespace
}  // namespace volute
