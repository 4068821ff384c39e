// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "volute/base/program.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/npy.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/volume/volume_medium.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/scene.hpp"

// What glows in a volume lights the rest of a scene.

namespace volute {
namespace {

constexpr int kGlowSide = 20;  ///< voxels of 5 cm

/// A folder with a bright ball of 25 cm in the middle of 1 m, even smoke, and a ground.
class SceneGlow : public testing::Test {
 protected:
  void SetUp() override {
    power_ = write("fire.npy", 100);
    write("smoke.npy", 0);
    std::ofstream(folder_ / "ground.obj")
        << "v -90 -90 0\nv 90 -90 0\nv 90 90 0\nv -90 90 0\nf 1 2 3 4\n";
  }

  /// A ball of the value in 0; the value 0 stands for 1 everywhere. Returns the sum over voxels.
  double write(const std::string& name, float bright) const {
    VolumeInfo info;
    info.frames = 1;
    info.x = info.y = info.z = kGlowSide;
    info.fillDefaults();
    auto sink = NpySink::create((folder_ / name).string(), info);
    EXPECT_TRUE(sink);
    std::vector<float> values;
    double sum = 0;
    for (int z = 0; z < kGlowSide; ++z) {
      for (int y = 0; y < kGlowSide; ++y) {
        for (int x = 0; x < kGlowSide; ++x) {
          const bool inside = std::hypot(x - 9.5, y - 9.5, z - 9.5) < 5;
          values.push_back(bright == 0 ? 1 : inside ? bright : 0);
          sum += values.back();
        }
      }
    }
    EXPECT_TRUE((*sink)->writeFrame(values));
    EXPECT_TRUE((*sink)->finish());
    return sum / (kGlowSide * kGlowSide * kGlowSide);
  }

  /// The ball's middle is 8 m above the ground.
  std::string fire(const std::string& more) const {
    return R"({"kind": "volume", "file": "fire.npy", "transform": [1,0,0,-0.5, 0,1,0,-0.5, 0,0,1,7.5, 0,0,0,1])" +
           more + "}";
  }

  SceneSnapshot at(const std::string& media, const std::string& more = "") {
    const auto json = nlohmann::ordered_json::parse(
        R"({"format": "volute-scene-1", "camera": {"eye": [0, -30, 8], "target": [0, 0, 4], "fov": 40},
            "geometry": [{"file": "ground.obj"}], "media": [)" +
        media + "]" + more + "}");
    auto scene = Scene::make(json, (folder_ / "scene.json").string(), {}, remarks_);
    EXPECT_TRUE(scene) << scene.error().message;
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
  double power_ = 0;  ///< per solid angle
  Remarks remarks_;
};

TEST_F(SceneGlow, FarAwayABallIsAPointOfItsPower) {
  const SceneSnapshot snapshot = at(fire(R"(, "emission": 2, "lights_scene": "always")"));
  const auto& lamps = snapshot.lights.lamps;
  ASSERT_FALSE(lamps.empty());
  EXPECT_LE(lamps.size(), 8U);
  double power = 0;
  for (const Lamp& lamp : lamps) power += lamp.intensity[0];
  EXPECT_NEAR(power, 2 * power_, 1e-9 * power);
  EXPECT_THAT(remarks_.text, testing::HasSubstr("lights the rest of the scene"));
  // On the ground: base color / pi * power / r^2 * cosine.
  for (const double far : {0.0, 6.0, 15.0}) {
    const Segment down{Vec3(far, 0, 1), -Vec3::UnitZ(), 0, 10};
    const auto points = lookAtSurfaces({snapshot.geometry, lamps}, {&down, 1});
    const double r2 = 64 + far * far;
    const double expected = 0.8 / std::numbers::pi * 2 * power_ / r2 * 8 / std::sqrt(r2);
    EXPECT_NEAR(points[0].radiance[1] / expected, 1, 5e-3) << far;
  }
}

/// The integral over the ball's voxels, each a point, close to the ground.
TEST_F(SceneGlow, CloseByItIsTheSumOfItsVoxels) {
  const std::string low =
      R"({"kind": "volume", "file": "fire.npy", "emission": 2, "lights_scene": "always"})";
  const SceneSnapshot snapshot = at(low);
  for (const double far : {0.0, 0.4, 1.0}) {
    const Vec3 place(0.5 + far, 0.5, 0);
    const Segment down{place + Vec3::UnitZ() * 0.01, -Vec3::UnitZ(), 0, 10};
    const auto points = lookAtSurfaces({snapshot.geometry, snapshot.lights.lamps}, {&down, 1});
    double expected = 0;
    for (int i = 0; i < kGlowSide * kGlowSide * kGlowSide; ++i) {
      const Vec3 voxel(i % kGlowSide, i / kGlowSide % kGlowSide, i / kGlowSide / kGlowSide);
      if ((voxel - Vec3::Constant(9.5)).norm() >= 5)
        continue;
      const Vec3 way = (voxel + Vec3::Constant(0.5)) / kGlowSide - place;
      expected += 200.0 / std::pow(kGlowSide, 3) * way.z() / std::pow(way.norm(), 3);
    }
    expected *= 0.8 / std::numbers::pi;
    EXPECT_NEAR(points[0].radiance[1] / expected, 1, 0.06) << far;
  }
}

TEST_F(SceneGlow, OnlyWhatIsAskedToOrBurnsLights) {
  EXPECT_TRUE(at(fire(R"(, "emission": 2)")).lights.lamps.empty());
  EXPECT_TRUE(remarks_.text.empty()) << remarks_.text;
  const std::string burning = R"(, "emission": 0, "flames": {"field": "density", "brightness": 1})";
  EXPECT_FALSE(at(fire(burning)).lights.lamps.empty());
  EXPECT_TRUE(at(fire(burning + R"(, "lights_scene": "never")")).lights.lamps.empty());
}

TEST_F(SceneGlow, OtherVolumesScatterIt) {
  const std::string smoke =
      R"({"kind": "volume", "file": "smoke.npy", "emission": 0, "extinction": 0.1, "albedo": [0.9, 0.9, 0.9],
          "transform": [1,0,0,4, 0,1,0,-0.5, 0,0,1,7.5, 0,0,0,1]})";
  const SceneSnapshot snapshot =
      at(smoke + "," + fire(R"(, "emission": 2, "lights_scene": "always")"));
  std::vector<AnyMedium> media;
  snapshot.media[0]->addMedia(media);
  const double r2 = 4.5 * 4.5;  // from the ball's middle to the cube's
  const double expected =
      0.1 * 0.9 * 2 * power_ / r2 / (4 * std::numbers::pi) * std::exp(-0.1 * 0.5);
  EXPECT_NEAR(media[0].emission(Vec3(4.5, 0, 8))[0] / expected, 1, 0.03);
}

TEST_F(SceneGlow, FogScattersItAndTheGroundKeepsIt) {
  const std::string fog =
      R"({"kind": "fog", "map": "fog.png", "origin": [-80, -80, 0], "cell": 40, "degree": 1,
          "sigma_max": 0.01, "profile": {"kind": "slab", "bottom": -20, "top": 40}, "color": [0, 0, 0]})";
  Image white(4, 4, 1);
  std::ranges::fill(white.pixels, 1.0F);
  ASSERT_TRUE(writeImage((folder_ / "fog.png").string(), white));
  const SceneSnapshot snapshot =
      at(fog + "," + fire(R"(, "emission": 2, "lights_scene": "always")"));
  const auto* lit = dynamic_cast<const FogSnapshot*>(snapshot.media[0].get());
  ASSERT_TRUE(lit && lit->lit());
  std::vector<AnyMedium> media;
  lit->addMedia(media);
  const double r2 = 36;
  const double expected = 0.01 * 2 * power_ / r2 / (4 * std::numbers::pi) * std::exp(-0.01 * 6);
  EXPECT_NEAR(media[0].emission(Vec3(6, 0, 8))[0] / expected, 1, 0.03);
  const Segment below{Vec3(-5, 0, -15), Vec3::UnitX(), 0, 10};
  Radiance light;
  media[0].radiance({&below, 1}, {&light, 1});
  EXPECT_EQ(light.emitted[0], 0) << "below the ground";
}

/// A cube of smoke straight above another one, in the sun, and fog around both.
TEST_F(SceneGlow, MediaShadowVolumes) {
  const auto cube = [](double bottom, double extinction) {
    return R"({"kind": "volume", "file": "smoke.npy", "emission": 0, "albedo": [0.9, 0.9, 0.9], "extinction": )" +
           std::to_string(extinction) + R"(, "transform": [1,0,0,-0.5, 0,1,0,-0.5, 0,0,1,)" +
           std::to_string(bottom) + ", 0,0,0,1]}";
  };
  const std::string fog =
      R"({"kind": "fog", "map": "fog.png", "origin": [-80, -80, 0], "cell": 40, "degree": 1,
          "sigma_max": 0.01, "profile": {"kind": "slab", "bottom": -20, "top": 40}, "color": [0, 0, 0]})";
  Image white(4, 4, 1);
  std::ranges::fill(white.pixels, 1.0F);
  ASSERT_TRUE(writeImage((folder_ / "fog.png").string(), white));
  const std::string sun =
      R"(, "lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [2, 2, 2]}])";
  const auto lightAt = [&](const std::string& media, const Vec3& point) {
    const SceneSnapshot snapshot = at(media, sun);
    std::vector<AnyMedium> all;
    snapshot.media[0]->addMedia(all);
    return all[0].emission(point)[0];
  };
  const Vec3 point(0.1, -0.2, 8);
  const double open = lightAt(cube(7.5, 0.5), point);
  EXPECT_GT(open, 0);
  EXPECT_NEAR(lightAt(cube(7.5, 0.5) + "," + cube(12, 0.7), point) / open, std::exp(-0.7), 5e-3);
  EXPECT_NEAR(lightAt(cube(7.5, 0.5) + "," + cube(2, 0.7), point) / open, 1, 1e-6)
      << "what is below casts no shadow";
  EXPECT_NEAR(lightAt(cube(7.5, 0.5) + "," + fog, point) / open, std::exp(-0.01 * 32), 5e-3);
}

/// A cube of thick white smoke in the sun, seen from its lit side.
class SceneScattering : public SceneGlow {
 protected:
  double seen(const std::string& more, bool measured = false, std::optional<bool> multiple = {}) {
    const auto json = nlohmann::ordered_json::parse(
        R"({"format": "volute-scene-2", "lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [3, 3, 3]}],
            "media": [{"kind": "volume", "file": "smoke.npy", "emission": 0, "extinction": 20, "albedo": [0.95, 0.95, 0.95]}])" +
        more + "}");
    SceneOptions options;
    options.files.measured = measured;
    options.multiple = multiple;
    auto scene = Scene::make(json, (folder_ / "scene.json").string(), options, remarks_);
    if (!scene) {
      said_ = scene.error().message;
      return -1;
    }
    scattering_ = 0;
    for (const Parameter& one : scene->parameters()) {
      if (one.path == "/scattering")
        scattering_ = one.value.front();
    }
    auto snapshot = scene->at({}, remarks_);
    EXPECT_TRUE(snapshot) << snapshot.error().message;
    std::vector<AnyMedium> media;
    snapshot->media.front()->addMedia(media);
    const Segment ray{Vec3(0.5, 0.5, 3), -Vec3::UnitZ(), 0, 10};
    Radiance light;
    media.front().radiance({&ray, 1}, {&light, 1});
    return light.emitted[0];
  }

  std::string said_;
  double scattering_ = 0;
};

TEST_F(SceneScattering, MultipleIsBrighterInThickSmoke) {
  const double single = seen("");
  EXPECT_EQ(scattering_, 0);
  EXPECT_NEAR(single, 3 * 0.95 / (4 * std::numbers::pi) / 2, 4e-2 * single);
  const double multiple = seen(R"(, "scattering": "multiple")");
  EXPECT_EQ(scattering_, 1);
  // A half space of albedo .95 reflects H(1)^2, some 4.3, times as much (Chandrasekhar 1950).
  EXPECT_GT(multiple, 3.2 * single);
  EXPECT_LT(multiple, 5.4 * single);
  EXPECT_EQ(seen(R"(, "scattering": "single")"), single);
  EXPECT_EQ(seen("", false, true), multiple);
  EXPECT_EQ(seen(R"(, "scattering": "multiple")", false, false), single);
}

TEST_F(SceneScattering, WhatIsMeasuredScattersOnce) {
  const double single = seen("", true);
  EXPECT_THAT(remarks_.text, testing::Not(testing::HasSubstr("left out of what is measured")));
  EXPECT_EQ(seen(R"(, "scattering": "multiple")", true), single);
  EXPECT_THAT(remarks_.text, testing::HasSubstr("left out of what is measured"));
}

TEST_F(SceneScattering, ItIsOneOfTwoWords) {
  EXPECT_EQ(seen(R"(, "scattering": "twice")"), -1);
  EXPECT_THAT(said_,
              testing::HasSubstr(R"(/scattering: "twice" is neither "single" nor "multiple")"));
}

}  // namespace
}  // namespace volute
