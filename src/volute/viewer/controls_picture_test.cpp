// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The viewer's controls that are no parameters of a document: picture, files.
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

TEST_F(Controls, ThePicturesOwn) {
  open("smoke.json");
  expectSeen("exposure", [&] { EXPECT_TRUE(script_->click("exposure", 0.5)); });
  EXPECT_GT(app().settings().look.stops, 2);
  app().settings().look.stops = 0;  // or all is white
  expectSeen("view", [&] { script_->click("view", 0.6); });
  expectSeen("Whole view", [&] { EXPECT_TRUE(script_->click("Whole view")); });
  expectSeen("Scene's view", [&] { EXPECT_TRUE(script_->click("Scene's view")); });
  expectSeen("surfaces", [&] { script_->click("surfaces", 0.1); });
  EXPECT_FALSE(app().settings().look.surfaces);
  expectSeen("quality", [&] { script_->choose("quality", "half"); });
  EXPECT_EQ(app().settings().look.quality, 2);
  script_->choose("quality", "quarter");
  expectSeen("time", [&] { script_->click("time", 0.99); });
  EXPECT_GT(app().timeline().time(), 0.15);
  expectSeen("<", [&] { script_->click("<"); });
  EXPECT_EQ(app().timeline().time(), 0);
  expectSeen(">", [&] { script_->click(">"); });
  ASSERT_TRUE(script_->choose("camera", "walk"));
  ASSERT_TRUE(script_->choose("renderer", "processor"));
  script_->click("Screenshot");
  EXPECT_TRUE(app().takeScreenshotWish());
  const Image bare = viewer_->picture();
  script_->click("Help");
  EXPECT_TRUE(app().settings().help);
  EXPECT_GT(difference(bare, viewer_->picture()), 0.1);
  app().settings().help = false;
  ASSERT_TRUE(script_->click("speed", 0.7));
  const double speed = app().timeline().speed();
  EXPECT_GT(speed, 1.5);
  ASSERT_TRUE(script_->click("exposure", 0.45));
  ASSERT_TRUE(script_->click("view", 0.6));
  const double stops = app().settings().look.stops, fov = app().camera().fov();
  const double time = app().timeline().time();
  EXPECT_NE(stops, 0);
  EXPECT_NE(fov, 50);
  saveAs("look.json");
  app().settings().look = {};
  app().open(folder_.path("look.json"));
  load();
  EXPECT_EQ(app().settings().look.stops, stops);
  EXPECT_NEAR(app().camera().fov(), fov, 1e-9);
  EXPECT_NEAR(app().timeline().time(), std::min(time, app().timeline().last()), 1e-9);
  EXPECT_FALSE(app().settings().look.surfaces);
  EXPECT_EQ(app().settings().look.renderer, 2);
  EXPECT_EQ(app().settings().look.quality, 3);
  EXPECT_EQ(app().timeline().speed(), speed);
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kWalk);
}

using PictureControls = WideControls;

TEST_F(PictureControls, TheCamerasModeSaysWhatADragDoes) {
  open("smoke.json");
  const StartView begun = app().camera().view();
  const auto turned = [&](const char* mode) {
    app().camera().set(begun);
    EXPECT_TRUE(script_->choose("camera", mode));
    expectSeen(mode, [&] { script_->drag(kWide / 2, 300, kWide / 2 + 60, 330); });
    return picture();
  };
  const Image orbit = turned("orbit");
  EXPECT_GT((app().camera().eye() - begun.eye).norm(), 0.5);
  EXPECT_LT((app().camera().view().target - begun.target).norm(), 1e-9);
  const Image walk = turned("walk");
  EXPECT_EQ(app().camera().eye(), begun.eye);
  EXPECT_GT(difference(orbit, walk), 0.01);
}

TEST_F(PictureControls, WhoDrewIsSaid) {
  constexpr int kLetters = 120, kLine = 13;
  open("smoke.json");
  const auto said = [&](const char* renderer) {
    EXPECT_TRUE(script_->choose("renderer", renderer));
    EXPECT_TRUE(script_->settle());
    script_->frames(3);
    return shownAt("who draws", kLetters, kLine);
  };
  const Image gl = said("OpenGL");
  EXPECT_FALSE(app().times().processor);
  const Image processor = said("processor");
  EXPECT_TRUE(app().times().processor);
  EXPECT_GT(difference(gl, processor), 0.1);
  EXPECT_LT(difference(gl, said("OpenGL")), 0.05) << "else it is the background's change";
}

TEST_F(Controls, OpenGlAndTheProcessorAgree) {
  open("smoke.json");
  app().settings().look.quality = 1;
  app().settings().look.renderer = 1;
  const Image gl = picture();
  app().settings().look.renderer = 2;
  const Image processor = picture();
  double sum = 0;
  for (std::size_t i = 0; i < gl.pixels.size(); ++i)
    sum += std::abs(gl.pixels[i] - processor.pixels[i]);
  // Light at corners is between them linear, edges are a pixel off.
  EXPECT_LT(sum / static_cast<double>(gl.pixels.size()), 0.01);
}

TEST_F(Controls, FilesOpenByDropping) {
  open("smoke.json");
  script_->drop(folder_.path("map.png"));
  load();
  EXPECT_EQ(app().error(), "");
  EXPECT_THAT(app().document()->title, ::testing::HasSubstr("a map of fog"));
  script_->drop(folder_.path("smoke.vtu"));
  load();
  EXPECT_THAT(app().document()->title, ::testing::HasSubstr("smoke on a mesh"));
  script_->drop(folder_.path("smoke.pvd"));
  load();
  ASSERT_TRUE(app().timeline().moves());
  script_->click("time", 0.6);
  load();
  const double time = app().timeline().time();
  script_->drop(folder_.path("ground.obj"));
  load();
  EXPECT_TRUE(app().timeline().moves());
  EXPECT_EQ(app().timeline().time(), time);
  EXPECT_NE(app().error(), "");
  EXPECT_THAT(app().document()->title, ::testing::HasSubstr("smoke on a mesh")) << "it stays";
}

TEST_F(Controls, ADroppedFileIsExposedAsIfItWasOpened) {
  // The light that is exposed for is that of the window's picture.
  open("blob.npy");
  script_->settle();
  const Image alone = picture();
  script_->drop(folder_.path("fog.json"));
  load();
  const Image fog = picture();
  script_->drop(folder_.path("blob.npy"));
  load();
  script_->settle();
  EXPECT_LT(difference(alone, picture()), 0.001);
  EXPECT_GT(difference(alone, fog), 0.01);
}

TEST_F(Controls, OneLooksFromTheCamerasOfACapture) {
  open("capture.json");
  EXPECT_THAT(app().document()->title, ::testing::HasSubstr("3 cameras, 2 frames"));
  Image shown = picture();
  for (const char* camera : {"look from a", "look from b", "look from c"}) {
    const Vec3 eye = app().camera().eye();
    ASSERT_TRUE(script_->click(camera));
    EXPECT_GT((app().camera().eye() - eye).norm(), 0.5) << camera;
    Image now = picture();
    EXPECT_GT(difference(shown, now), 0.01) << camera;
    shown = std::move(now);
  }
  ASSERT_TRUE(script_->click(">"));
  load();
  EXPECT_GT(difference(shown, picture()), 0.01) << "the next frame";
}

TEST_F(Controls, ACapturesFaultsAreToldAndItsOtherPicturesShown) {
  std::filesystem::remove(folder_.path("f_0005_b.exr"));
  auto json = testing::ringJson();
  json["cameras"][2]["t"][2] = -4;
  testing::writeText(folder_.path("faulty.json"), json.dump());
  open("faulty.json");
  EXPECT_THAT(app().document()->remarks,
              ::testing::IsSupersetOf({::testing::HasSubstr("camera b, frame 5: there is no"),
                                       ::testing::HasSubstr("camera c: the volume lies behind")}));
  const auto image = picture().pixels;
  EXPECT_GT(*std::ranges::max_element(image), 0.05);
}

TEST_F(Controls, AFilesPartsAreHiddenByTheirHeads) {
  open("blob.npy");
  ASSERT_TRUE(script_->has("/media/0/emission"));
  ASSERT_TRUE(script_->click("group volume: blob.npy", 0.5));
  script_->frames(2);
  EXPECT_FALSE(script_->has("/media/0/emission"));
  ASSERT_TRUE(script_->click("group volume: blob.npy", 0.5));
  script_->frames(2);
  EXPECT_TRUE(script_->has("/media/0/emission"));
}

TEST_F(Controls, LieInTheWindowAndNotOnEachOther) {
  for (const auto& [width, height] : {std::pair{1280, 800}, {kNarrow, kHigh}}) {
    SCOPED_TRACE(width);
    script_->input().width = width, script_->input().height = height;
    open("fog.json");
    ASSERT_NO_FATAL_FAILURE(openPaintPanel());
    const auto& controls = app().controls();
    for (const auto& [name, at] : controls) {
      EXPECT_GE(at.left, 0) << name;
      EXPECT_LE(at.right, width) << name;
      EXPECT_LE(at.bottom, height) << name;
      for (const auto& [other, there] : controls) {
        if (other <= name || name == "Paint fog" || other == "Paint fog")
          continue;
        const float across = std::min(at.right, there.right) - std::max(at.left, there.left);
        const float down = std::min(at.bottom, there.bottom) - std::max(at.top, there.top);
        EXPECT_FALSE(across > 1 && down > 1) << name << " and " << other;
      }
    }
    EXPECT_LE(controls.at("tool coefficient").right, controls.at("plan").right);
  }
}

TEST_F(Controls, ADamagedFileLeavesTheOldPictureUntilItIsMended) {
  open("fog.json");
  const Image shown = picture();
  const auto replace = [&](const std::string& name, const std::string& by) {
    std::filesystem::copy_file(folder_.path(by), folder_.path(name),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::last_write_time(
        folder_.path(name), std::filesystem::last_write_time(folder_.path(name)) + clock_++);
  };
  const auto until = [&](const auto& holds) {
    for (int i = 0; i < 4000 && !holds(); ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return holds();
  };
  std::filesystem::copy_file(folder_.path("map.png"), folder_.path("whole.png"));
  std::ofstream(folder_.path("torn.png")) << "\x89PNG and then nothing";
  replace("map.png", "torn.png");
  EXPECT_TRUE(until([&] { return !app().error().empty(); }));
  EXPECT_THAT(app().error(), ::testing::HasSubstr("map.png"));
  ASSERT_NE(app().document(), nullptr);
  EXPECT_LT(difference(shown, picture()), 0.001);
  replace("map.png", "whole.png");
  EXPECT_TRUE(until([&] { return app().error().empty(); }));
  EXPECT_LT(difference(shown, picture()), 0.001);
  std::filesystem::copy_file(folder_.path("fog.json"), folder_.path("whole.json"));
  std::ofstream(folder_.path("torn.json")) << "{\"format\": ";
  replace("fog.json", "torn.json");
  EXPECT_TRUE(until([&] { return !app().error().empty(); }));
  EXPECT_LT(difference(shown, picture()), 0.001);
  replace("fog.json", "dull.json");
  EXPECT_TRUE(until([&] { return app().error().empty(); }));
  EXPECT_GT(difference(shown, picture()), 0.01) << "without a sun";
}

}  // namespace
}  // namespace volute
