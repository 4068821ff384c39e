// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Where media are, when, and how fog thins with height; volumes as billboards; units that were
// taken wrongly. Driven by the input layer.
#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/scene_document.hpp"

namespace volute {
namespace {

constexpr const char* kVolume = R"({"format": "volute-scene-1",
  "camera": {"eye": [0.4, -2.6, 0.9], "target": [0.5, 0.5, 0.5], "fov": 40},
  "media": [{"kind": "volume", "file": "blob.npy", "emission": 3, "extinction": 2}]})";
constexpr const char* kBlown = R"({"format": "volute-scene-1",
  "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
  "media": [{"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4, "wind": [1, 0],
             "profile": {"kind": "slab", "bottom": 0, "top": 4}},
            {"kind": "volume", "file": "blob.npy", "emission": 3, "time": {"loop": true},
             "transform": [8, 0, 0, 3, 0, 8, 0, 0, 0, 0, 8, 2, 0, 0, 0, 1]}]})";
constexpr const char* kTop = R"({"format": "volute-scene-1",
  "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
  "media": [{"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4,
             "top": {"map": "map.png", "height": 6}}]})";

class MediaControls : public WideControls {
 protected:
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path(name)) << text;
  }

  nlohmann::json saved(const std::string& name) {
    std::ifstream stream(folder_.path(name));
    return nlohmann::json::parse(stream);
  }

  bool hasParameter(const std::string& path) {
    const auto& all = app().document().info()->parameters;
    return std::ranges::find(all, path, &Parameter::path) != all.end();
  }

  Image byCpu() {
    app().settings().look.renderer = static_cast<int>(ViewRenderer::kCpu);
    Image image = picture();
    app().settings().look.renderer = static_cast<int>(ViewRenderer::kGl);
    return image;
  }

  /// Of the value and of both pictures; and it is taken back and done again.
  void expectWholly(const std::string& path) {
    SCOPED_TRACE(path);
    app().settings().look.renderer = static_cast<int>(ViewRenderer::kGl);
    const auto begun = valueOf(path);
    const Image before = picture(), beforeByCpu = byCpu();
    Image shown = before;
    expectChange(parameterAt(path), shown);
    EXPECT_GT(difference(beforeByCpu, byCpu()), 0.0005);
    const auto changed = valueOf(path);
    script_->press(Key::kZ, true);
    load();
    EXPECT_EQ(valueOf(path), begun);
    EXPECT_LT(difference(before, picture()), 1e-4);
    script_->press(Key::kY, true);
    load();
    EXPECT_EQ(valueOf(path), changed);
    EXPECT_LT(difference(shown, picture()), 1e-4);
  }

  void press(const std::string& control) {
    ASSERT_TRUE(script_->click(control)) << control;
    load();
    EXPECT_EQ(app().document().error(), "");
  }

  void seek(double time) {
    app().playback().timeline().seek(time);
    EXPECT_NEAR(app().playback().timeline().time(), time, 1e-9);
    load();
  }

  void chooseProfile(const std::string& kind) {
    expectSeen(kind, [&] { ASSERT_TRUE(script_->choose("/media/0/profile/kind", kind)); });
    EXPECT_EQ(app().document().error(), "");
  }
};

TEST_F(MediaControls, VolumesAreMovedTurnedAndScaled) {
  write("volume.json", kVolume);
  open("volume.json");
  EXPECT_EQ(valueOf("/media/0/transform/middle"), (std::vector<double>{0.5, 0.5, 0.5}));
  EXPECT_EQ(valueOf("/media/0/transform/turn"), (std::vector<double>{0, 0, 0}));
  for (const char* key : {"middle", "turn", "size", "scale", "mirror"})
    expectWholly(std::string("/media/0/transform/") + key);
  saveAs("volume2.json");
  expectTheSameAfter("volume2.json");
  EXPECT_EQ(saved("volume2.json")["media"][0]["transform"].size(), 16U);
}

TEST_F(MediaControls, AVolumesBasisIsChosenAndSaved) {
  write("volume.json", kVolume);
  open("volume.json");
  expectSeen("basis", [&] { ASSERT_TRUE(script_->choose("/media/0/basis", "box")); });
  saveAs("volume2.json");
  expectTheSameAfter("volume2.json");
  EXPECT_EQ(saved("volume2.json")["media"][0]["basis"], "box");
}

TEST_F(MediaControls, VolumesTurnAboutTheirMiddle) {
  write("volume.json", kVolume);
  open("volume.json");
  app().document().set(parameterAt("/media/0/transform/middle"), {2, 1, 0.25});
  load();
  app().document().set(parameterAt("/media/0/transform/turn"), {0, 0, 90});
  app().document().set(parameterAt("/media/0/transform/scale"), {2, 1, 0.5});
  load();
  saveAs("turned.json");
  // x' = 0.25 .. : (x, y, z) -> (2 - (y - 0.5), 1 + 2 (x - 0.5), 0.25 + 0.5 (z - 0.5))
  const std::vector<double> expected = {0, -1, 0, 2.5, 2, 0, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1};
  const auto numbers = saved("turned.json")["media"][0]["transform"];
  ASSERT_EQ(numbers.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(numbers[i].get<double>(), expected[i], 1e-12) << i;
  const Box3 bounds = app().document().info()->bounds;
  EXPECT_LT((bounds.min - Vec3(1.5, 0, 0)).norm() + (bounds.max - Vec3(2.5, 2, 0.5)).norm(), 1e-9);
  app().document().set(parameterAt("/media/0/transform/middle"), {0.5, 0.5, 0.5});
  app().document().set(parameterAt("/media/0/transform/turn"), {0, 0, 0});
  app().document().set(parameterAt("/media/0/transform/scale"), {1, 1, 1});
  load();
  saveAs("turned.json");
  EXPECT_FALSE(saved("turned.json")["media"][0].contains("transform")) << "which does nothing";
}

TEST_F(MediaControls, MediaHaveATimeOfTheirOwn) {
  write("blown.json", kBlown);
  open("blown.json");
  ASSERT_GT(app().playback().timeline().last(), 9.9) << "the wind blows";
  seek(0.1);
  expectWholly("/media/1/time/loop");
  Image shown = picture();
  expectChange(parameterAt("/media/1/time/loop"), shown);
  seek(0.05);
  shown = picture();
  app().document().set(parameterAt("/media/1/time/rate"), {0.5});
  load();
  EXPECT_GT(difference(shown, picture()), 0.0005) << "it is at its first frame still";
  script_->press(Key::kZ, true);
  load();
  EXPECT_LT(difference(shown, picture()), 1e-4);
  expectWholly("/media/1/time/offset");
  script_->press(Key::kZ, true);
  load();
  ASSERT_TRUE(script_->click("/media/1/time/rate", 0.1));
  load();
  EXPECT_LT(valueOf("/media/1/time/rate")[0], 0.8);
  EXPECT_GT(difference(shown, picture()), 0.0005);
  saveAs("blown2.json");
  expectTheSameAfter("blown2.json");
}

TEST_F(MediaControls, StepsOfSmokeHaveATimeOfTheirOwn) {
  auto scene = saved("smoke.json");
  for (const char* slow : {"lights", "geometry", "signs"}) scene.erase(slow);
  scene["media"].push_back({{"kind", "volume"}, {"file", "blob.npy"}, {"time", {{"rate", 0.05}}}});
  write("steps.json", scene.dump());
  open("steps.json");
  seek(0.5);
  Image shown = picture();
  expectChange(parameterAt("/media/0/time/loop"), shown);
  seek(0.1);
  expectWholly("/media/0/time/offset");
  app().document().set(parameterAt("/media/0/time/offset"), {0.02});
  load();  // a rate shows between the first step and the last
  shown = picture();
  expectChange(parameterAt("/media/0/time/rate"), shown);
  saveAs("late.json");
  expectTheSameAfter("late.json");
}

TEST_F(MediaControls, WindBlowsFog) {
  open("dull.json");
  EXPECT_EQ(valueOf("/media/0/wind"), (std::vector<double>{0, 0, 0}));
  EXPECT_FALSE(app().playback().timeline().moves());
  const Image calm = picture();
  ASSERT_NO_FATAL_FAILURE(change(parameterAt("/media/0/wind")));
  load();
  EXPECT_LT(valueOf("/media/0/wind")[0], -1);
  ASSERT_TRUE(app().playback().timeline().moves()) << "there is something to be seen over time";
  EXPECT_LT(difference(calm, picture()), 1e-6) << "at 0 s it is where it was";
  const Image still = byCpu();
  seek(2);
  const Image blown = picture();
  EXPECT_GT(difference(calm, blown), 0.01);
  EXPECT_GT(difference(still, byCpu()), 0.01);
  script_->press(Key::kZ, true);
  load();
  EXPECT_EQ(valueOf("/media/0/wind"), (std::vector<double>{0, 0, 0}));
  EXPECT_FALSE(app().playback().timeline().moves());
  script_->press(Key::kY, true);
  load();
  seek(2);
  EXPECT_LT(difference(blown, picture()), 1e-4);
  saveAs("windy.json");
  EXPECT_EQ(saved("windy.json")["media"][0]["wind"].size(), 2U) << "it does not rise";
  expectTheSameAfter("windy.json");
  EXPECT_EQ(app().playback().timeline().time(), 2);
}

TEST_F(MediaControls, MapsOfFogAreMoved) {
  open("dull.json");
  expectWholly("/media/0/origin");
  expectWholly("/media/0/cell");
  saveAs("moved.json");
  expectTheSameAfter("moved.json");
}

TEST_F(MediaControls, FogEndsAboveItsTop) {
  write("top.json", kTop);
  open("top.json");
  expectWholly("/media/0/top/height");
  Image shown = picture();
  for (const char* key : {"origin", "cell"})
    expectChange(parameterAt(std::string("/media/0/top/") + key), shown);
  saveAs("top2.json");
  expectTheSameAfter("top2.json");
}

TEST_F(MediaControls, FogHasAProfileOfEachKind) {
  open("dull.json");
  chooseProfile("slab");
  Image shown = picture();
  expectChange(parameterAt("/media/0/profile/bottom"), shown);
  expectChange(parameterAt("/media/0/profile/top"), shown);
  app().document().set(parameterAt("/media/0/profile/top"), {-50});
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_GT(valueOf("/media/0/profile/top")[0], valueOf("/media/0/profile/bottom")[0]);
  app().document().set(parameterAt("/media/0/profile/top"), {6});
  load();
  for (const char* kind : {"exponential", "linear", "layers", "any height"}) {
    SCOPED_TRACE(kind);
    chooseProfile(kind);
    saveAs("profile.json");
    expectTheSameAfter("profile.json");
  }
}

TEST_F(MediaControls, KnotsOfAProfileComeGoAndMove) {
  open("dull.json");
  chooseProfile("linear");
  Image shown = picture();
  expectChange(parameterAt("/media/0/profile/knots/0"), shown);
  expectWholly("/media/0/profile/knots/1");
  app().document().set(parameterAt("/media/0/profile/knots/1"), {90, 2});
  load();
  EXPECT_EQ(app().document().error(), "");
  const auto next = valueOf("/media/0/profile/knots/2");
  EXPECT_EQ(valueOf("/media/0/profile/knots/1"), (std::vector<double>{next[0], 1}));
  script_->press(Key::kZ, true);
  load();
  press("add /media/0/profile/knots = 0");
  ASSERT_TRUE(hasParameter("/media/0/profile/knots/3"));
  shown = picture();
  expectChange(parameterAt("/media/0/profile/knots/1"), shown);
  expectChange(parameterAt("/media/0/profile/knots/2"), shown);
  app().document().set(parameterAt("/media/0/profile/knots/3"), {9, 0.5});
  load();
  shown = picture();
  expectChange(parameterAt("/media/0/profile/knots/3"), shown);
  saveAs("knots.json");
  expectTheSameAfter("knots.json");
  EXPECT_EQ(saved("knots.json")["media"][0]["profile"]["knots"].size(), 4U);
  expectSeen("remove", [&] { press("remove /media/0/profile/knots = 2"); });
  press("remove /media/0/profile/knots = 0");
  EXPECT_FALSE(hasParameter("/media/0/profile/knots/2"));
  EXPECT_FALSE(script_->has("remove /media/0/profile/knots = 0")) << "two have to be there";
  script_->press(Key::kZ, true);
  load();
  EXPECT_TRUE(hasParameter("/media/0/profile/knots/2"));
}

TEST_F(MediaControls, LayersOfAProfileComeGoAndMove) {
  open("dull.json");
  chooseProfile("layers");
  Image shown = picture();
  expectChange(parameterAt("/media/0/profile/layers/0"), shown);
  expectWholly("/media/0/profile/layers/1");
  expectSeen("add", [&] { press("add /media/0/profile/layers = 1"); });
  ASSERT_TRUE(hasParameter("/media/0/profile/layers/2"));
  shown = picture();
  expectChange(parameterAt("/media/0/profile/layers/2"), shown);
  saveAs("layers.json");
  expectTheSameAfter("layers.json");
  expectSeen("remove", [&] { press("remove /media/0/profile/layers = 0"); });
  press("remove /media/0/profile/layers = 0");
  EXPECT_FALSE(hasParameter("/media/0/profile/layers/1"));
  EXPECT_FALSE(script_->has("remove /media/0/profile/layers = 0")) << "one has to be there";
}

TEST_F(MediaControls, ALongProfileWaitsUntilItIsAskedFor) {
  write("long.json", [] {
    auto scene = nlohmann::json::parse(kTop);
    scene["media"][0].erase("top");
    auto& profile = scene["media"][0]["profile"] = {{"kind", "linear"}};
    for (int i = 0; i < 9; ++i)
      profile["knots"].push_back(nlohmann::json::array({i * 0.5, 1 - 0.1 * i}));
    return scene.dump();
  }());
  open("long.json");
  script_->frames(3);
  EXPECT_FALSE(script_->has("/media/0/profile/kind"));
  EXPECT_TRUE(script_->has("/media/0/cell"));
  ASSERT_TRUE(script_->click("group profile of /media/0", 0.3));
  script_->frames(2);
  EXPECT_TRUE(script_->has("/media/0/profile/kind"));
  for (int i = 0; i < 9; ++i)
    ASSERT_NO_FATAL_FAILURE(change(parameterAt(fmt::format("/media/0/profile/knots/{}", i))));
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_TRUE(script_->has("/media/0/profile/kind")) << "it stays open";
}

TEST_F(MediaControls, AVolumeIsABillboardAndBack) {
  write("volume.json", kVolume);
  open("volume.json");
  app().document().set(parameterAt("/media/0/transform/size"), {1.5});
  load();
  const Image volume = picture();
  const double brightest = *std::ranges::max_element(volume.pixels);
  press("billboard /media/0");
  ASSERT_TRUE(hasParameter("/billboards/0/rows"));
  EXPECT_FALSE(hasParameter("/media/0/emission"));
  const Image board = picture();
  double sum = 0;
  for (std::size_t i = 0; i < board.pixels.size(); ++i)
    sum += std::abs(board.pixels[i] - volume.pixels[i]);
  EXPECT_GT(difference(board, volume), 0.0005);
  EXPECT_LT(sum / static_cast<double>(board.pixels.size()), 0.05 * brightest)
      << "as large and as bright";
  saveAs("board.json");
  EXPECT_TRUE(saved("board.json")["media"].empty());
  expectTheSameAfter("board.json");
  press("volume /billboards/0");
  ASSERT_TRUE(hasParameter("/media/0/transform/size"));
  EXPECT_FALSE(hasParameter("/billboards/0/rows"));
  EXPECT_NEAR(valueOf("/media/0/transform/size")[0], 1.5, 1e-8);
  EXPECT_LT(difference(volume, picture()), 1e-3);
  script_->press(Key::kZ, true);
  load();
  EXPECT_TRUE(hasParameter("/billboards/0/rows"));
  EXPECT_LT(difference(board, picture()), 1e-4);
  script_->press(Key::kY, true);
  load();
  saveAs("again.json");
  EXPECT_FALSE(saved("again.json").contains("billboards"));
  expectTheSameAfter("again.json");
}

TEST_F(MediaControls, EveryParameterOfBillboards) {
  auto scene = nlohmann::json::parse(kBlown);
  scene["background"] = {0.5, 0.4, 0.3};
  scene["media"].erase(1);
  scene["billboards"] = nlohmann::json::array({{{"volume", "blob.npy"},
                                                {"position", {5, 4, 3}},
                                                {"size", {6, 6}},
                                                {"emission", 2},
                                                {"rows", 64},
                                                {"time", {{"loop", true}}}}});
  write("board.json", scene.dump());
  open("board.json");
  seek(0.1);
  Image shown = picture();
  for (const char* key : {"alpha", "emission", "extinction", "size/0", "size/1", "time/loop"})
    expectChange(parameterAt(std::string("/billboards/0/") + key), shown);
  for (const char* key : {"rows", "position"}) expectWholly(std::string("/billboards/0/") + key);
  seek(0.05);
  shown = picture();
  expectWholly("/billboards/0/time/offset");
  script_->press(Key::kZ, true);
  load();
  ASSERT_TRUE(script_->click("/billboards/0/time/rate", 0.1));
  load();
  EXPECT_GT(difference(shown, picture()), 0.0005);
  saveAs("board2.json");
  expectTheSameAfter("board2.json");
}

TEST_F(MediaControls, AUnitThatMakesSmokeBlackIsMendedByAClick) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 6, 3)}, {4, 4, 3}, 0.1, 1);
  std::vector<float> values;
  for (const Vec3& p : mesh->vertices()) values.push_back(static_cast<float>(0.3 * p.z()));
  ASSERT_TRUE(writeVtu(folder_.path("black.vtu"), *mesh, "smoke", values));
  testing::writeText(folder_.path("black.json"),
                     R"({"format": "volute-scene-1", "background": [1, 1, 1],
    "camera": {"eye": [3, -12, 2], "target": [3, 3, 1.5], "fov": 40},
    "media": [{"kind": "smoke", "case": "black.vtu", "quantity": "soot-density", "unit": "kg/m3"}]})");
  open("black.json");
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::HasSubstr("much for soot")));
  script_->frames(3);
  EXPECT_FALSE(script_->has("mend /media/0/unit = mg/m3")) << "0.9 mg of soot are little";
  expectSeen("g/m3", [&] { press("mend /media/0/unit = g/m3"); });
  EXPECT_EQ(parameterAt("/media/0/unit").choices[1], "g/m3");
  EXPECT_EQ(valueOf("/media/0/unit")[0], 1);
  EXPECT_FALSE(script_->has("mend /media/0/unit = g/m3")) << "nothing is doubted any more";
  saveAs("mended.json");
  expectTheSameAfter("mended.json");
  open("black.json");
  expectSeen("extinction", [&] { press("mend /media/0/quantity = extinction"); });
  EXPECT_FALSE(hasParameter("/media/0/unit"));
  EXPECT_FALSE(script_->has("mend /media/0/quantity = extinction"));
  saveAs("mended2.json");
  expectTheSameAfter("mended2.json");
  EXPECT_EQ(saved("mended2.json")["media"][0]["quantity"], "extinction");
}

TEST_F(MediaControls, AVolumeAloneIsLitAsItsNameSays) {
  std::filesystem::copy_file(folder_.path("blob.npy"), folder_.path("smoke.npy"));
  open("smoke.npy");
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::HasSubstr("shown as smoke")));
  EXPECT_EQ(valueOf("/media/0/emission")[0], 0);
  EXPECT_GT(valueOf("/media/0/extinction")[0], 0);
  EXPECT_FALSE(app().document().info()->changed);
  open("blob.npy");
  EXPECT_EQ(valueOf("/media/0/emission")[0], 1);
}

TEST_F(MediaControls, WhatAFieldAloneHoldsIsGuessedAndSaid) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 6, 3)}, {4, 4, 3}, 0.1, 1);
  std::vector<float> values;
  for (const Vec3& p : mesh->vertices()) values.push_back(static_cast<float>(0.3 * p.z()));
  ASSERT_TRUE(writeVtu(folder_.path("grams.vtu"), *mesh, "soot", values));
  open("grams.vtu");
  EXPECT_EQ(valueOf("/media/0/unit")[0], 1);
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::HasSubstr("is taken for soot in g/m3")));
  EXPECT_FALSE(app().document().info()->changed);
  ASSERT_TRUE(writeVtu(folder_.path("metres.vtu"), *mesh, "smoke", values));
  open("metres.vtu");
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::HasSubstr("is taken for extinction in 1/m")));
}

std::unique_ptr<Document> documentOf(const SceneFolder& folder, const std::string& scene,
                                     Progress& progress) {
  const std::string path = folder.path("scene.json");
  std::ofstream(path) << scene;
  auto document = SceneDocument::open(path, {}, progress);
  EXPECT_TRUE(document) << document.error().message;
  return document ? std::move(*document) : nullptr;
}

/// What is moved, turned or blown is not read again, for the files may be gone, nor uploaded again.
TEST(SceneDocument, NothingIsReadAgainForWhereThingsAre) {
  const auto gl = HeadlessGl::create();
  if (!gl)
    GTEST_SKIP() << gl.error().message;
  auto renderer = GlRenderer::create();
  ASSERT_TRUE(renderer);
  SceneFolder folder;
  Progress quiet;
  const auto document = documentOf(folder, kBlown, quiet);
  ASSERT_TRUE(document);
  const auto begun = document->sceneAt({.time = 0.01, .openGl = false}, quiet);
  ASSERT_TRUE(begun) << begun.error().message;
  for (const char* name : {"map.png", "blob.npy"}) std::filesystem::remove(folder.path(name));
  const Camera camera = Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 8, 8);
  const auto uploadsOf = [&](const char* path, const std::vector<double>& value) {
    const auto done = document->set(path, value, quiet);
    EXPECT_TRUE(done) << path << ": " << done.error().message;
    auto scene = document->sceneAt({.time = 0.01, .openGl = false}, quiet);
    EXPECT_TRUE(scene) << path << ": " << scene.error().message;
    EXPECT_TRUE(scene && renderer->draw(camera, scene->media, GlQuantity::kLight, quiet)) << path;
    int uploads = 0;
    for (const GlPassTime& pass : renderer->takePasses())
      uploads += pass.name == "upload" ? pass.times : 0;
    return uploads;
  };
  EXPECT_EQ(uploadsOf("/media/1/transform/middle", {1, 2, 3}), 2) << "the map and the volume";
  EXPECT_EQ(uploadsOf("/media/1/transform/middle", {4, 2, 3}), 0);
  EXPECT_EQ(uploadsOf("/media/1/transform/turn", {10, 20, 30}), 0);
  EXPECT_EQ(uploadsOf("/media/1/transform/turn", {-70, 20, 30}), 0);
  EXPECT_EQ(uploadsOf("/media/1/emission", {5}), 0);
  EXPECT_EQ(uploadsOf("/media/0/wind", {2, 1, 0}), 0);
  EXPECT_EQ(uploadsOf("/media/0/origin", {2, 1, 0}), 0);
  EXPECT_EQ(uploadsOf("/media/0/profile/top", {3}), 0);
  EXPECT_EQ(uploadsOf("/media/1/transform/size", {2}), 1) << "its voxels are larger";
  const auto board =
      document->edit({.kind = SceneEdit::Kind::kBillboard, .path = "/media/1"}, quiet);
  EXPECT_TRUE(board) << board.error().message;
  EXPECT_TRUE(document->sceneAt({.time = 0.01, .openGl = false}, quiet));
  EXPECT_TRUE(document->undo(quiet));
  EXPECT_TRUE(document->sceneAt({.time = 0.01, .openGl = false}, quiet));
}

TEST_F(MediaControls, AMapThatOthersWriteDuringAChangeIsRead) {
  open("fog.json");
  const Image shown = picture();
  Image empty(14, 10, 1);
  ASSERT_TRUE(writeMap(folder_.path("map.png"), empty));
  std::filesystem::last_write_time(
      folder_.path("map.png"),
      std::filesystem::last_write_time(folder_.path("map.png")) + clock_++);
  app().document().set(parameterAt("/media/0/wind"), {0, 0.1, 0});
  load();
  bool other = false;
  for (int i = 0; i < 200 && !other; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    load();
    other = difference(shown, picture()) > 0.01;
  }
  EXPECT_TRUE(other) << "there is no fog any more";
}

/// Of a parameter, as the document has it now.
std::vector<double> valueIn(const Document& document, const std::string& path) {
  for (const Parameter& parameter : document.info().parameters) {
    if (parameter.path == path)
      return parameter.value;
  }
  return {};
}

TEST(SceneDocument, WhatWasPaintedOutlastsFogOfNoDensity) {
  SceneFolder folder;
  Progress quiet;
  const auto document = documentOf(folder, kBlown, quiet);
  ASSERT_TRUE(document);
  const auto map = [&] {
    const auto canvases = document->info().canvases;
    return canvases.empty() ? std::vector<double>() : canvases[0].fog->levels().map().c;
  };
  std::vector<double> painted = map();
  ASSERT_FALSE(painted.empty());
  for (double& value : painted) value = 0.5 * value + 0.1;
  ASSERT_TRUE(document->setFogMap(0, painted, true));
  ASSERT_TRUE(document->set("/media/0/sigma_max", {0}, quiet));
  ASSERT_TRUE(document->set("/media/0/sigma_max", {0.8}, quiet));
  const auto now = map();
  ASSERT_EQ(now.size(), painted.size());
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_NEAR(now[i], 2 * painted[i], 1e-12) << i;
  EXPECT_TRUE(document->info().canvases[0].unsaved);
}

TEST(SceneDocument, ASavedMapIsHeldAsTheFogThatBlows) {
  SceneFolder folder;
  Progress quiet;
  const auto document = documentOf(folder, kBlown, quiet);
  ASSERT_TRUE(document);
  auto painted = document->info().canvases[0].fog->levels().map().c;
  for (double& value : painted) value *= 0.5;
  ASSERT_TRUE(document->setFogMap(0, painted, true));
  Image map(14, 10, 1);
  ASSERT_TRUE(document->saveFogMap(0, folder.path("other.png"), map));
  ASSERT_TRUE(document->set("/media/0/wind", {3, 1, 0}, quiet));
  EXPECT_EQ(document->info().canvases[0].fog->levels().map().c, painted);
  EXPECT_EQ(document->info().canvases[0].file, folder.path("other.png"));
}

/// Whatever is beyond the map's border: where the brush is the fog becomes denser.
TEST(SceneDocument, FogThatBlowsIsPaintedWhereItIsShown) {
  SceneFolder folder;
  Progress quiet;
  for (const char* border : {"repeat", "clamp", "zero"}) {
    for (const int degree : {0, 1, 2}) {
      auto scene = nlohmann::json::parse(kBlown);
      scene["media"][0]["border"] = border;
      scene["media"][0]["degree"] = degree;
      scene["media"][0]["wind"] = {0.9, -0.4};
      const auto document = documentOf(folder, scene.dump(), quiet);
      ASSERT_TRUE(document);
      const FogCanvas canvas = document->info().canvases[0];
      const std::vector<double> before = canvas.fog->levels().map().c;
      for (const double time : {0.0, 3.3, 9.0}) {
        FogPainter painter(*canvas.fog, canvas.most);
        painter.blow({time * canvas.wind.head<2>(), canvas.border});
        const auto extinctionAt = [&](const Vec2& at) {
          const auto fields = document->fieldsAt(time, Vec3(at.x(), at.y(), 2));
          EXPECT_TRUE(fields);
          return fields->front().fields.front().values.front();
        };
        const bool zero = std::string(border) == "zero";
        for (const Vec2& at : {Vec2(3.2, 6.1), Vec2(9.7, 3.4)}) {
          SCOPED_TRACE(fmt::format("{}, degree {}, {} s, x {}", border, degree, time, at.x()));
          ASSERT_TRUE(document->setFogMap(0, before, true));
          const Vec2 other(at.x() < 7 ? 11.1 : 1.6, 8.6);
          const double there = extinctionAt(at), elsewhere = extinctionAt(other);
          FogPainter held = painter;
          const bool onMap = held.nearest(at).has_value();
          EXPECT_TRUE(onMap || zero);
          EXPECT_TRUE(held.paint({.radius = 1.8, .strength = 0.2}, at, at, 1) || !onMap);
          ASSERT_TRUE(document->setFogMap(0, held.coefficients().c, true));
          if (onMap) {
            EXPECT_GT(extinctionAt(at), there + (zero ? 0 : 0.01)) << "less at a border";
          } else {
            EXPECT_EQ(extinctionAt(at), there);
          }
          if (canvas.border != FogBorder::kClamp) {
            EXPECT_EQ(extinctionAt(other), elsewhere);
          }
        }
      }
    }
  }
}

TEST(SceneDocument, ASavedMapLeavesWhatCanBeUndone) {
  SceneFolder folder;
  Progress quiet;
  for (const char* name : {"map.png", "other.png"}) {
    SCOPED_TRACE(name);
    const auto document = documentOf(folder, kBlown, quiet);
    ASSERT_TRUE(document);
    auto painted = document->info().canvases[0].fog->levels().map().c;
    for (double& value : painted) value *= 0.5;
    ASSERT_TRUE(document->setFogMap(0, painted, true));
    ASSERT_TRUE(document->set("/media/0/wind", {3, 1, 0}, quiet));
    ASSERT_TRUE(document->saveFogMap(0, folder.path(name), Image(14, 10, 1)));
    ASSERT_TRUE(document->info().canUndo);
    ASSERT_TRUE(document->undo(quiet));
    EXPECT_EQ(valueIn(*document, "/media/0/wind")[0], 1);
    EXPECT_EQ(document->info().canvases[0].name, name);
    EXPECT_EQ(document->info().canvases[0].fog->levels().map().c, painted);
    EXPECT_FALSE(document->info().canvases[0].unsaved);
    EXPECT_EQ(document->info().changed, std::string(name) != "map.png")
        << "the scene's file has the map before";
    ASSERT_TRUE(document->redo(quiet));
    EXPECT_EQ(valueIn(*document, "/media/0/wind")[0], 3);
    EXPECT_EQ(document->info().canvases[0].name, name);
  }
}

/// Opened alone or in a scene, by whatever name, and however many files a name stands for.
TEST(SceneDocument, NothingThatIsShownIsReplaced) {
  SceneFolder folder;
  Progress quiet;
  std::filesystem::create_symlink(folder.path("blob.npy"), folder.path("link.json"));
  const auto bytesOf = [&](const char* name) { return *readText(folder.path(name)); };
  const std::string blob = bytesOf("blob.npy"), map = bytesOf("map.png");
  const std::string smoke = bytesOf("more.vtu"), ground = bytesOf("ground.obj");
  const auto expectKept = [&](Document& document, std::initializer_list<const char*> names) {
    for (const char* name : names) {
      const Status saved = document.save(folder.path(name), {}, {});
      ASSERT_FALSE(saved) << name;
      EXPECT_EQ(saved.error().code, ErrorCode::kInvalidArgument);
      EXPECT_THAT(saved.error().message, ::testing::HasSubstr("is shown and would be replaced"));
    }
    EXPECT_EQ(bytesOf("blob.npy"), blob);
    EXPECT_EQ(bytesOf("map.png"), map);
    EXPECT_EQ(bytesOf("more.vtu"), smoke);
    EXPECT_EQ(bytesOf("ground.obj"), ground);
  };
  auto alone = SceneDocument::open(folder.path("blob.npy"), {}, quiet);
  ASSERT_TRUE(alone);
  expectKept(**alone, {"blob.npy", "./blob.npy", "link.json"});
  EXPECT_TRUE((*alone)->save(folder.path("blob.npy.json"), {}, {}));
  auto mesh = SceneDocument::open(folder.path("smoke.json"), {}, quiet);
  ASSERT_TRUE(mesh);
  expectKept(**mesh, {"smoke.pvd", "smoke.vtu", "more.vtu", "ground.obj"});
  EXPECT_TRUE((*mesh)->save(folder.path("smoke.json"), {}, {})) << "its own file";
  const auto fog = documentOf(folder, kBlown, quiet);
  ASSERT_TRUE(fog);
  expectKept(*fog, {"map.png", "blob.npy"});
  const Image painted(14, 10, 1);
  EXPECT_TRUE(fog->saveFogMap(0, folder.path("map.png"), painted)) << "its own map";
  std::filesystem::create_symlink(folder.path("blob.npy"), folder.path("link.png"));
  EXPECT_FALSE(fog->saveFogMap(0, folder.path("link.png"), painted));
  EXPECT_EQ(bytesOf("blob.npy"), blob);
}

TEST(SceneDocument, AVolumeThatIsMovedKeepsItsSize) {
  SceneFolder folder;
  auto scene = nlohmann::json::parse(kVolume);
  const double tiny = 1e-4;
  scene["media"][0]["transform"] = {tiny, 0, 0, 1, 0, tiny, 0, 2, 0, 0, tiny, 3, 0, 0, 0, 1};
  Progress quiet;
  const auto document = documentOf(folder, scene.dump(), quiet);
  ASSERT_TRUE(document);
  ASSERT_TRUE(document->set("/media/0/transform/middle", {5, 6, 7}, quiet));
  const auto scale = valueIn(*document, "/media/0/transform/scale");
  ASSERT_EQ(scale.size(), 3U);
  for (const double value : scale) EXPECT_NEAR(value, tiny, 1e-9 * tiny);
  EXPECT_NEAR(valueIn(*document, "/media/0/transform/middle")[1], 6, 1e-9);
}

TEST(SceneDocument, DoorsOfAnFdsCaseOpenInTheirTime) {
  SceneFolder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {{1, 3, 1, 3, 0, 1}, {0, 1, 0, 1, 1, 2}}, {}});
  index.smoke(1, "room_1.s3d", 8700);
  index.event("HIDE_OBST", 1, 1, 3);
  index.save(folder.path("door.smv"));
  Progress quiet;
  auto document = SceneDocument::open(folder.path("door.smv"), {}, quiet);
  ASSERT_TRUE(document) << document.error().message;
  const auto corners = [&](double time) {
    const auto scene = (*document)->sceneAt({.time = time}, quiet);
    EXPECT_TRUE(scene) << scene.error().message;
    return scene && scene->surfaces ? scene->surfaces->corners : std::vector<float>();
  };
  const auto closed = corners(0);
  EXPECT_FALSE(closed.empty());
  const auto open = corners(5);
  EXPECT_FALSE(open.empty());
  EXPECT_TRUE(open != closed);
  EXPECT_TRUE(corners(0) == closed);
  const auto held = [&](double time) {
    return (*document)->sceneAt({.time = time}, quiet).value().surfaces;
  };
  EXPECT_EQ(held(0), held(1)) << "no door moves in between: nothing is lit or uploaded again";
}

}  // namespace
}  // namespace volute
