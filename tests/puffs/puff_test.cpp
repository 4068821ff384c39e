// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A fifth kind of medium is its own folder and one line: whatever Volute does with media, it does
// with this one.
#include "puffs/puff.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "volute/medium/conformance.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/viewer/headless_viewer.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {
namespace {

const bool kRegistered = (registerMedium(puffKind()), true);  // the one line

VOLUTE_CONFORMANCE(Puffs, conformance::underTest(Puff{Vec3(0.3, -0.2, 0.1), 1.5, 0.8,
                                                      Rgb(0.2, 0.4, 0.6)}));

constexpr double kThrough = 16.0 / 15;  ///< of density times radius: the depth through the middle

nlohmann::ordered_json puffScene() {
  return nlohmann::ordered_json::parse(R"({
    "format": "volute-scene-1",
    "camera": {"eye": [0, -10, 0], "target": [0, 0, 0], "fov": 30, "size": [33, 33]},
    "background": [1, 1, 1],
    "lights": [{"kind": "ambient", "radiance": [0.5, 0.5, 0.5]}],
    "media": [{"kind": "puff", "radius": 1, "density": 1.5, "growth": 0.5, "albedo": [0.2, 0.4, 0.8]}]
  })");
}

Scene scene(const nlohmann::ordered_json& json = puffScene()) {
  Progress quiet;
  auto made = Scene::make(json, "puffs.json", {}, quiet);
  if (!made)
    throw std::runtime_error(made.error().message);
  return std::move(*made);
}

Image pictureOf(Scene& of, double time, Renderer method, Aov aov = Aov::kNone) {
  Progress quiet;
  const auto snapshot = of.at({.time = time}, quiet);
  const CameraDescription camera = *of.camera();
  CpuRenderer renderer(method);
  return *renderer.render(*snapshot, makeCamera(camera, *camera.size),
                          {.background = snapshot->background, .aov = aov}, quiet);
}

TEST(FifthMedium, IsInAScene) {
  ASSERT_TRUE(kRegistered);
  Progress quiet;
  auto wrong = puffScene();
  wrong["media"][0]["radios"] = 2;
  const auto refused = Scene::make(wrong, "puffs.json", {}, quiet);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("puffs.json: /media/0/radios"), std::string::npos);
  wrong["media"][0] = {{"kind", "puf"}};
  EXPECT_NE(Scene::make(wrong, "puffs.json", {}, quiet).error().message.find("puff"),
            std::string::npos)
      << "it is listed";
}

TEST(FifthMedium, IsRenderedByReferenceAndCpu) {
  Scene puffs = scene();
  const double depth = kThrough * 1.5;
  const Image exact = pictureOf(puffs, 0, Renderer::kReference);
  const Image fast = pictureOf(puffs, 0, Renderer::kCpu);
  const double passed = std::exp(-depth);
  for (int c = 0; c < 3; ++c) {
    const double sent = 0.5 * (c == 0 ? 0.2 : c == 1 ? 0.4 : 0.8);
    EXPECT_NEAR(exact.at(16, 16, c), passed + (1 - passed) * sent, 1e-6);
  }
  for (std::size_t i = 0; i < exact.pixels.size(); ++i)
    EXPECT_NEAR(fast.pixels[i], exact.pixels[i], 2e-6);
  EXPECT_NEAR(pictureOf(puffs, 0, Renderer::kCpu, Aov::kOpticalDepth).at(16, 16), depth, 1e-6);
  puffs.setLaw({PictureMode::kThreshold, 3});
  EXPECT_NEAR(pictureOf(puffs, 0, Renderer::kCpu, Aov::kTransmittance).at(16, 16),
              std::pow(10, -depth / 3), 1e-6);
}

TEST(FifthMedium, IsFramedPlayedAndProbed) {
  Scene puffs = scene();
  EXPECT_NEAR(puffs.bounds().max.x(), 2, 1e-12);
  EXPECT_EQ(puffs.times(), (std::vector<double>{0, 1, 2}));
  EXPECT_NEAR(pictureOf(puffs, 1.5, Renderer::kCpu, Aov::kOpticalDepth).at(16, 16),
              kThrough * 1.5 * 1.75, 1e-6);
  Progress quiet;
  const auto snapshot = puffs.at({.time = 1}, quiet);
  std::vector<AnyMedium> media;
  snapshot->media[0]->addMedia(media);
  EXPECT_NEAR(media[0].extinction(Vec3(0.75, 0, 0)), 1.5 * 0.75 * 0.75, 1e-12);
}

/// A slider of one medium costs the others nothing.
TEST(FifthMedium, StaysWhileNothingNewIsSaidOfIt) {
  auto json = puffScene();
  json["media"].push_back(json["media"][0]);
  Scene puffs = scene(json);
  const std::vector before(puffs.media().begin(), puffs.media().end());
  Progress quiet;
  auto changed = *puffs.with("/media/1/radius", {2});
  ASSERT_TRUE(puffs.change(changed, quiet));
  EXPECT_EQ(puffs.media()[0], before[0]);
  EXPECT_NE(puffs.media()[1], before[1]);
  changed["lights"][0]["radiance"] = {1, 1, 1};
  ASSERT_TRUE(puffs.change(changed, quiet));
  EXPECT_NE(puffs.media()[0], before[0]) << "it is lit otherwise";
}

TEST(FifthMedium, IsInSceneFilesHoweverTheirNamesAreWritten) {
  EXPECT_TRUE(isScenePath("a.json") && isScenePath("B.JSON"));
  EXPECT_FALSE(isScenePath("json") || isScenePath("a.json.npy"));
}

/// Its shadow is on a floor under a lamp.
TEST(FifthMedium, StandsInTheLight) {
  const std::string floor = testing::TempDir() + "puff_floor.obj";
  std::ofstream(floor) << "v -9 -9 -3\nv 9 -9 -3\nv 9 9 -3\nv -9 9 -3\nf 1 2 3 4\n";
  auto json = puffScene();
  json["geometry"] = {{{"file", floor}}};
  json["lights"] = {{{"kind", "sun"}, {"direction", {0, 0, -1}}, {"radiance", {2, 2, 2}}}};
  json["camera"] = {{"eye", {5, 0, -2.9}}, {"target", {0, 0, -3}}, {"fov", 20}, {"size", {9, 9}}};
  Scene shaded = scene(json);
  json["media"] = nlohmann::ordered_json::array();
  Scene clear = scene(json);
  const double share = pictureOf(shaded, 0, Renderer::kCpu).at(4, 4, 0) /
                       pictureOf(clear, 0, Renderer::kCpu).at(4, 4, 0);
  EXPECT_NEAR(share, std::exp(-kThrough * 1.5), 1e-3);
}

TEST(FifthMedium, IsCrossedBySightLines) {
  Progress quiet;
  const auto field = sightOf(scene(), {}, quiet);
  ASSERT_TRUE(field) << field.error().message;
  EXPECT_EQ((*field)->times().size(), 3u);
  const SafetySign sign{.name = "exit",
                        .position = Vec3(3, 0, 0),
                        .normal = -Vec3::UnitX(),
                        .law = *visibilityLaw("jin-reflecting"),
                        .angle = {}};
  for (const std::size_t time : {0, 2}) {
    const auto snapshot = (*field)->read(time);
    ASSERT_TRUE(snapshot);
    const auto targets = placeSigns(**snapshot, {&sign, 1}, (*field)->bounds(), quiet);
    ASSERT_TRUE(targets);
    const Vec3 eye(-3, 0, 0);
    Sighting seen;
    lookAround(**snapshot, *targets, {&eye, 1}, {&seen, 1});
    EXPECT_NEAR(seen.depth, kThrough * 1.5 * (1 + 0.5 * static_cast<double>(time)), 1e-9);
    EXPECT_EQ(seen.visible, seen.depth <= 3);
  }
}

TEST(FifthMedium, IsLookedAtInTheViewerWithItsSliders) {
  auto viewer = HeadlessViewer::create(documentOpener({}));
  if (!viewer)
    GTEST_SKIP() << viewer.error().message;
  const std::string path = testing::TempDir() + "puffs.json";
  std::ofstream(path) << puffScene();
  ViewerApp& app = (*viewer)->app();
  app.open(path);
  ViewerInput input;
  input.width = 320, input.height = 240;
  Progress quiet;
  ASSERT_TRUE((*viewer)->settle(input, quiet));
  ASSERT_NE(app.document().info(), nullptr);
  const auto& parameters = app.document().info()->parameters;
  const auto radius = std::ranges::find(parameters, "/media/0/radius", &Parameter::path);
  ASSERT_NE(radius, parameters.end());
  EXPECT_EQ(radius->value.front(), 1);
  const Image small = (*viewer)->picture();
  app.document().set(*radius, {2});
  ASSERT_TRUE((*viewer)->settle(input, quiet));
  const Image large = (*viewer)->picture();
  double difference = 0;
  for (std::size_t i = 0; i < small.pixels.size(); ++i)
    difference += std::abs(small.pixels[i] - large.pixels[i]);
  EXPECT_GT(difference / static_cast<double>(small.pixels.size()), 0.005);
}

}  // namespace
}  // namespace volute
