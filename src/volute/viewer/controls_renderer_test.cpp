// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Who draws: every kind of medium by OpenGL and by the CPU, before every kind of camera.
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

constexpr const char* kCamera =
    R"("camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45})";
constexpr const char* kParallel =
    R"("camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "up": [0, 1, 0], "ortho": 16})";
constexpr const char* kRoom = R"("camera": {"eye": [1, 2, 1.5], "target": [6, 4, 1.4], "fov": 70})";
constexpr const char* kMap =
    R"("kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4, "degree": 1)";
constexpr const char* kSlab = R"("profile": {"kind": "slab", "bottom": 0, "top": 4})";
constexpr const char* kLamps =
    R"("lights": [{"kind": "ambient", "radiance": [0.3, 0.3, 0.3]},
       {"kind": "spot", "position": [3, 3, 2.9], "target": [3.5, 3, 0], "angle": 130, "intensity": [9, 8, 7]}])";
constexpr const char* kWalls =
    R"({"kind": "smoke", "case": "smoke.pvd", "quantity": "soot-density", "unit": "kg/m3", "walls": [0.8, 0.7, 0.6]})";
constexpr const char* kSun =
    R"("lights": [{"kind": "sun", "direction": [0.4, 0.5, -0.6], "radiance": [2, 1.8, 1.5]}])";

struct Renderers : Controls {
  void SetUp() override {
    Controls::SetUp();
    if (script_)
      resize(160, 120);  // the rasteriser has little to do
  }

  void resize(int width, int height) {
    script_->input().width = width, script_->input().height = height;
  }

  void write(const std::string& name, const std::string& members) {
    std::ofstream(folder_.path(name))
        << R"({"format": "volute-scene-1", "background": [0.2, 0.3, 0.4], )" << members << "}";
  }

  Image by(ViewRenderer renderer) {
    app().settings().look.renderer = static_cast<int>(renderer);
    app().settings().look.quality = 1;
    return picture();
  }

  /// OpenGL draws all of it, nearly as the CPU does: signs are rasterised, and their edges
  /// may be a pixel off.
  void expectBoth(const std::string& name, double mean) {
    SCOPED_TRACE(name);
    open(name);
    const Image gl = by(ViewRenderer::kGl);
    EXPECT_FALSE(app().view().picture().times().cpu);
    EXPECT_FALSE(app().view().picture().times().passes.empty()) << "media are drawn";
    EXPECT_EQ(app().view().picture().remark(), "");
    const Image cpu = by(ViewRenderer::kCpu);
    EXPECT_TRUE(app().view().picture().times().cpu);
    double sum = 0;
    for (std::size_t i = 0; i < gl.pixels.size(); ++i)
      sum += std::abs(gl.pixels[i] - cpu.pixels[i]);
    EXPECT_LT(sum / static_cast<double>(gl.pixels.size()), mean);
    const auto [least, most] = std::ranges::minmax(cpu.pixels);
    EXPECT_GT(most - least, 0.05) << "something is to be seen";
  }
};

/// Shadows' edges, of a block on the ground under a lamp.
struct Edges : Renderers {
  void SetUp() override {
    Renderers::SetUp();
    std::ofstream(folder_.path("block.obj"))
        << "v 2 2 0\nv 3 2 0\nv 3 3 0\nv 2 3 0\nv 2 2 1.1\nv 3 2 1.1\nv 3 3 1.1\nv 2 3 1.1\n"
           "f 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  }

  static constexpr const char* kThings =
      R"(, "geometry": [{"file": "ground.obj"}, {"file": "block.obj"}])";

  /// Before the exposure and in floats, of a small window that has come to rest.
  Image lightBy(ViewRenderer renderer) {
    by(renderer);
    resize(120, 90);
    EXPECT_TRUE(script_->settle());
    return app().view().picture().sampledLight(app().document().info()->background);
  }

  /// Of the brightest.
  static double off(const Image& light, const Image& reference) {
    EXPECT_EQ(light.pixels.size(), reference.pixels.size());
    return difference(light, reference) / *std::ranges::max_element(reference.pixels);
  }

  void expectExact(const std::string& name) {
    SCOPED_TRACE(name);
    open(name);
    const Image gl = lightBy(ViewRenderer::kGl);
    EXPECT_EQ(app().view().picture().remark(), "");
    EXPECT_FALSE(app().view().picture().times().cpu);
    EXPECT_LT(off(gl, lightBy(ViewRenderer::kCpu)), 2e-3);
    EXPECT_TRUE(app().view().picture().times().cpu);
  }
};

TEST_F(Edges, AreExactAtRest) {
  const std::string before = std::string(kCamera) + "," + kLamps + kThings;
  write("block.json", before);
  expectExact("block.json");
  write("parallel.json", std::string(kParallel) + "," + kLamps + kThings);
  expectExact("parallel.json");
  write("smoke.json", before + R"(, "media": [{"kind": "smoke", "case": "smoke.pvd",
      "quantity": "products-density", "unit": "kg/m3", "smoke_potential": 2.0, "mode": "threshold", "C": 3}])");
  expectExact("smoke.json");
  write("walls.json",
        std::string(kRoom) + "," + kLamps + kThings + R"(, "media": [)" + kWalls + "]");
  expectExact("walls.json");
}

TEST_F(Edges, AreRoughAtOnceAndExactOnceTheCameraRests) {
  write("block.json", std::string(kCamera) + "," + kLamps + kThings);
  open("block.json");
  lightBy(ViewRenderer::kGl);
  const std::size_t pictures = app().view().picture().times().history.size();
  const Image before = viewer_->picture();
  app().view().camera().drag(4, 2);
  script_->frame();
  EXPECT_FALSE(app().settled());
  EXPECT_EQ(app().view().picture().times().history.size(), pictures + 1) << "drawn at once";
  EXPECT_GT(difference(viewer_->picture(), before), 0.05);
  const auto background = app().document().info()->background;
  const Image rough = app().view().picture().sampledLight(background);
  ASSERT_TRUE(script_->settle());
  EXPECT_EQ(app().view().picture().times().history.size(), pictures + 1);
  const Image exact = app().view().picture().sampledLight(background);
  EXPECT_GT(off(exact, rough), 0.03) << "edges of shadows";
  EXPECT_LT(off(exact, lightBy(ViewRenderer::kCpu)), 2e-3);
}

TEST_F(Edges, AreBehindSigns) {
  write("sign.json", std::string(kCamera) + "," + kLamps + kThings + R"(, "signs": [
      {"position": [1.2, 1, 0.6], "normal": [-1, -1, 0.4], "size": [1.6, 0.8], "emitting": true}])");
  open("sign.json");
  const Image gl = by(ViewRenderer::kGl);
  app().document().edit({.kind = SceneEdit::Kind::kRemove, .path = "/signs/0"});
  load();
  EXPECT_GT(difference(gl, by(ViewRenderer::kGl)), 0.1) << "the sign is before surfaces";
}

TEST_F(Renderers, DrawFogInTheSunAndUnderATop) {
  expectBoth("fog.json", 0.002);
  write("top.json", std::string(kCamera) + R"(, "media": [{)" + kMap + "," + kSlab +
                        R"(, "top": {"map": "map.png", "height": 8}}])");
  expectBoth("top.json", 0.002);
  write("angle.json", std::string(kCamera) + R"(, "media": [{)" + kMap + "," + kSlab +
                          R"(, "levels": 2, "cell_angle": 0.1}])");
  expectBoth("angle.json", 0.002);
  write("ground.json", std::string(kCamera) + "," + kSun +
                           R"(, "geometry": [{"file": "ground.obj"}], "media": [{)" + kMap + "," +
                           kSlab + "}]");
  expectBoth("ground.json", 0.01);
}

TEST_F(Renderers, DrawFdsCases) {
  expectBoth("room.smv", 0.01);
}

TEST_F(Renderers, DrawTheWallsOfAMesh) {
  write("walls.json", std::string(kRoom) + "," + kLamps + R"(, "media": [)" + kWalls + "]");
  expectBoth("walls.json", 0.01);
  app().settings().look.quality = 3;
  resize(kNarrow, kHigh);
  script_->frames(3);
  ASSERT_TRUE(script_->has("surfaces"));
  ASSERT_TRUE(script_->click("surfaces", 0.1));
  ASSERT_FALSE(app().settings().look.surfaces);
  resize(160, 120);
  const Image bare = by(ViewRenderer::kGl);
  app().settings().look.surfaces = true;
  EXPECT_GT(difference(by(ViewRenderer::kGl), bare), 0.05);
  app().settings().look.surfaces = false;
  EXPECT_LT(difference(bare, by(ViewRenderer::kCpu)), 0.01) << "no walls for either";
}

TEST_F(Renderers, DrawWhatAClipLeavesOfAllMedia) {
  const std::string media =
      std::string(R"(, "media": [{)") + kMap + "," + kSlab +
      R"(}, {"kind": "volume", "file": "blob.npy", "emission": 3, "transform": [4, 0, 0, 6, 0, 4, 0, 4, 0, 0, 4, 2, 0, 0, 0, 1]}])";
  const std::string plane = R"({"kind": "plane", "point": [6.3, 4, 1], "normal": [-1, 0.4, 0.2]})";
  write("whole.json", std::string(kCamera) + media);
  write("plane.json", std::string(kCamera) + media + R"(, "clip": [)" + plane + "]");
  write("clip.json", std::string(kCamera) + media + R"(, "clip": [)" + plane +
                         R"(, {"kind": "box", "min": [2, 1, 0.5], "max": [9, 7, 3.5]}])");
  open("whole.json");
  const Image whole = by(ViewRenderer::kGl);
  for (const char* file : {"plane.json", "clip.json"}) {
    expectBoth(file, 0.002);
    EXPECT_GT(difference(by(ViewRenderer::kGl), whole), 0.02) << file;
  }
  write("walls.json",
        std::string(kRoom) + "," + kLamps + R"(, "media": [)" + kWalls +
            R"(], "clip": [{"kind": "plane", "point": [3, 3, 1], "normal": [0, 1, 0]}])");
  expectBoth("walls.json", 0.01);
  write("alone.json", std::string(kCamera) + R"(, "media": [{)" + kMap + "," + kSlab +
                          R"(}], "clip": [)" + plane + "]");
  expectBoth("alone.json", 0.002);
}

TEST_F(Renderers, DrawBillboardsAmongOthers) {
  write(
      "board.json",
      std::string(kCamera) + R"(, "media": [{)" + kMap + "," + kSlab +
          R"(}], "billboards": [{"volume": "blob.npy", "position": [5, 4, 0], "size": [6, 6], "emission": 2}])");
  expectBoth("board.json", 0.002);
}

TEST_F(Renderers, DrawBeforeAParallelCameraThatIsNotUpright) {
  write("parallel.json",
        std::string(kParallel) + "," + kLamps +
            R"(, "geometry": [{"file": "ground.obj"}], "media": [)" + kWalls +
            R"(], "signs": [{"position": [3, 3, 0.1], "normal": [0, 0, 1], "size": [3, 2]}])");
  expectBoth("parallel.json", 0.01);
  const Camera camera = app().view().camera().camera(120, 90);
  const Camera meant =
      Camera::orthographic({Vec3(-9, -12, 11), Vec3(7, 5, 0), Vec3::UnitY()}, 16, 120, 90);
  EXPECT_TRUE(camera.isOrthographic());
  EXPECT_NEAR(camera.pixelSize(), meant.pixelSize(), 1e-12);
  EXPECT_LT((camera.rotation() - meant.rotation()).norm(), 1e-9);
  app().settings().look.quality = 3;
  resize(kNarrow, kHigh);
  script_->frames(3);
  const double height = app().view().camera().ortho();
  ASSERT_TRUE(script_->click("view", 0.3));
  EXPECT_NE(app().view().camera().ortho(), height);
  const double seen = app().view().camera().ortho();
  saveAs("parallel2.json");
  expectTheSameAfter("parallel2.json");
  EXPECT_NEAR(app().view().camera().ortho(), seen, 1e-9);
  EXPECT_LT((app().view().camera().view().up - Vec3::UnitY()).norm(), 1e-9);
}

TEST_F(Renderers, ShowSignsToThoseBeforeThem) {
  for (const ViewRenderer renderer : {ViewRenderer::kGl, ViewRenderer::kCpu}) {
    open("smoke.json");
    const Image sign = by(renderer);
    const auto normal = parameterAt("/signs/0/normal");
    app().document().set(normal, {1, 0, 0});
    load();
    const Image back = by(renderer);
    EXPECT_GT(difference(sign, back), 0.2);
    app().document().edit({.kind = SceneEdit::Kind::kRemove, .path = "/signs/0"});
    load();
    EXPECT_LT(difference(back, by(renderer)), 0.002);
  }
}

TEST_F(Renderers, SmokeIsDrawnByTheMethodThatWasAskedFor) {
  ASSERT_NO_FATAL_FAILURE(restart({}, {.smokeMethod = GlSmokeMethod::kProject}));
  open("smoke.vtu");
  by(ViewRenderer::kGl);
  const auto& passes = app().view().picture().times().passes;
  EXPECT_TRUE(std::ranges::any_of(passes, [](const auto& pass) { return pass.name == "resolve"; }));
}

TEST_F(Renderers, WhatOpenGlRefusesIsSaidAndTheRestIsDrawn) {
  Image map(9000, 2, 1);
  std::ranges::fill(map.pixels, 0.5F);
  ASSERT_TRUE(writeMap(folder_.path("long.png"), map));
  write("long.json", std::string(kCamera) +
                         R"(, "geometry": [{"file": "ground.obj"}], "media": [{"kind": "fog",
      "map": "long.png", "cell": 1, "sigma_max": 0.1, "degree": 1, )" +
                         kSlab + "}]");
  open("long.json");
  if (app().view().picture().makers().hardware)
    GTEST_SKIP() << "graphics cards draw it";
  by(ViewRenderer::kGl);
  EXPECT_THAT(app().view().picture().remark(),
              ::testing::HasSubstr("without the media: rays pass"));
  EXPECT_FALSE(app().view().picture().times().cpu);
  by(ViewRenderer::kAuto);
  EXPECT_TRUE(app().view().picture().times().cpu);
  EXPECT_EQ(app().view().picture().times().why, "there is no graphics card");
}

TEST(NoCpu, IsAnErrorWhereItWouldDraw) {
  if (const auto gl = HeadlessGl::create(); !gl)
    GTEST_SKIP() << gl.error().message;
  const SceneFolder folder;
  for (const bool gl : {true, false}) {
    const ViewerOptions options{.renderer = gl ? ViewRenderer::kGl : ViewRenderer::kCpu,
                                .cpu = false};
    Progress quiet;
    const auto picture =
        viewerScreenshot(documentOpener({.maxMemory = kViewerMemory}),
                         {folder.path("fog.json"), std::nullopt, 120, 90, options}, false, quiet);
    EXPECT_EQ(picture.has_value(), gl);
    if (!picture) {
      EXPECT_THAT(picture.error().message, ::testing::HasSubstr("VOLUTE_CPU_RENDERER=off"));
    }
  }
}

TEST_F(Renderers, BeginsAtTheTimeThatWasAskedFor) {
  write("late.json",
        std::string(kRoom) + R"(, "media": [)" + kWalls + R"(], "view": {"time": 0.15})");
  app().open(folder_.path("late.json"));
  load();
  EXPECT_NEAR(app().playback().timeline().time(), 0.15, 1e-12);
  app().open(folder_.path("late.json"), 0.0);
  load();
  EXPECT_EQ(app().playback().timeline().time(), 0);
  app().open(folder_.path("late.json"), 0.05);
  load();
  EXPECT_NEAR(app().playback().timeline().time(), 0.05, 1e-12);
}

}  // namespace
}  // namespace volute
