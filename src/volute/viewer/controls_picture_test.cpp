// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The viewer's controls that are no parameters of a document: picture, files.
#include <nlohmann/json.hpp>

#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

TEST_F(Controls, ThePicturesOwn) {
  open("smoke.json");
  expectSeen("exposure", [&] { EXPECT_TRUE(script_->click("exposure", 0.5)); });
  EXPECT_GT(app().settings().look.stops, 2);
  app().settings().look.stops = 0;  // or all is white
  expectSeen("view", [&] { script_->click("view", 0.6); });
  expectSeen("Whole view", [&] { EXPECT_TRUE(script_->click("Whole view")); });
  expectSeen("First view", [&] { EXPECT_TRUE(script_->click("First view")); });
  expectSeen("surfaces", [&] { script_->click("surfaces", 0.1); });
  EXPECT_FALSE(app().settings().look.surfaces);
  expectSeen("quality", [&] { script_->choose("quality", "half"); });
  EXPECT_EQ(app().settings().look.quality, 2);
  script_->choose("quality", "quarter");
  expectSeen("time", [&] { script_->click("time", 0.99); });
  EXPECT_GT(app().playback().timeline().time(), 0.15);
  expectSeen("<", [&] { script_->click("<"); });
  EXPECT_EQ(app().playback().timeline().time(), 0);
  expectSeen(">", [&] { script_->click(">"); });
  ASSERT_TRUE(script_->choose("camera", "walk"));
  ASSERT_TRUE(script_->choose("renderer", "CPU"));
  script_->click("Screenshot");
  EXPECT_TRUE(app().window().takeScreenshotRequest());
  const Image bare = viewer_->picture();
  script_->click("Help");
  EXPECT_TRUE(app().settings().help);
  EXPECT_GT(difference(bare, viewer_->picture()), 0.1);
  app().settings().help = false;
  ASSERT_NO_FATAL_FAILURE(openMore());
  ASSERT_TRUE(script_->click("speed", 0.7));
  const double speed = app().playback().timeline().speed();
  EXPECT_GT(speed, 1.5);
  ASSERT_TRUE(script_->click("exposure", 0.45));
  ASSERT_TRUE(script_->click("view", 0.6));
  const double stops = app().settings().look.stops, fov = app().view().camera().fov();
  const double time = app().playback().timeline().time();
  EXPECT_NE(stops, 0);
  EXPECT_NE(fov, 50);
  saveAs("look.json");
  app().settings().look = {};
  app().open(folder_.path("look.json"));
  load();
  EXPECT_EQ(app().settings().look.stops, stops);
  EXPECT_NEAR(app().view().camera().fov(), fov, 1e-9);
  EXPECT_NEAR(app().playback().timeline().time(),
              std::min(time, app().playback().timeline().last()), 1e-9);
  EXPECT_FALSE(app().settings().look.surfaces);
  EXPECT_EQ(app().settings().look.renderer, 2);
  EXPECT_EQ(app().settings().look.quality, 3);
  EXPECT_EQ(app().playback().timeline().speed(), speed);
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kWalk);
}

using PictureControls = WideControls;

TEST_F(PictureControls, TheCamerasModeSaysWhatADragDoes) {
  open("smoke.json");
  const StartView begun = app().view().camera().view();
  const auto turned = [&](const char* mode) {
    app().view().camera().set(begun);
    EXPECT_TRUE(script_->choose("camera", mode));
    expectSeen(mode, [&] { script_->drag(kWide / 2, 300, kWide / 2 + 60, 330); });
    return picture();
  };
  const Image orbit = turned("orbit");
  EXPECT_GT((app().view().camera().eye() - begun.eye).norm(), 0.5);
  EXPECT_LT((app().view().camera().view().target - begun.target).norm(), 1e-9);
  const Image walk = turned("walk");
  EXPECT_EQ(app().view().camera().eye(), begun.eye);
  EXPECT_GT(difference(orbit, walk), 0.01);
}

TEST_F(PictureControls, TheLastPicturesTimesAreBars) {
  open("smoke.json");
  ASSERT_TRUE(script_->settle());
  double x = 0, y = 0, right = 0, bottom = 0;
  ASSERT_TRUE(script_->pointOf("times", 0, 0, x, y));
  ASSERT_TRUE(script_->pointOf("times", 1, 1, right, bottom));
  const Image shown = shownAt("times", int(right - x), int(bottom - y));
  EXPECT_GT(shown.width, 200);
  int bright = 0;
  for (int i = 0; i < shown.width; ++i) {
    const auto green = shown.at(i, shown.height - 6, 1), red = shown.at(i, shown.height - 6, 0);
    bright += green > 0.4 && green > 1.5 * red;
  }
  EXPECT_GT(bright, shown.width / 20) << "a bar for the first picture";
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
  EXPECT_FALSE(app().view().picture().times().cpu);
  const Image cpu = said("CPU");
  EXPECT_TRUE(app().view().picture().times().cpu);
  EXPECT_GT(difference(gl, cpu), 0.1);
  EXPECT_LT(difference(gl, said("OpenGL")), 0.05) << "else it is the background's change";
}

TEST_F(PictureControls, ARasteriserIsNotOffered) {
  if (!viewer_ || app().view().picture().makers().hardware)
    GTEST_SKIP() << "there is a graphics card";
  script_.reset(), viewer_.reset();
  auto made = HeadlessViewer::create(documentOpener({.maxMemory = kViewerMemory}));
  ASSERT_TRUE(made) << made.error().message;
  viewer_ = std::move(*made);
  begin(kNarrow, kHigh);
  open("smoke.json");
  ASSERT_TRUE(script_->click("renderer"));
  script_->frames(2);
  EXPECT_TRUE(script_->has("renderer = CPU"));
  EXPECT_FALSE(script_->has("renderer = OpenGL"));
  script_->press(Key::kEscape);
  script_->frames(2);
  EXPECT_FALSE(script_->has("renderer = CPU")) << "Escape closes a list";
  ASSERT_TRUE(script_->choose("renderer", "CPU"));
  EXPECT_EQ(app().settings().look.renderer, static_cast<int>(ViewRenderer::kCpu));
  // A scene of another machine.
  app().settings().look.renderer = static_cast<int>(ViewRenderer::kGl);
  EXPECT_TRUE(script_->settle());
  EXPECT_TRUE(app().view().picture().times().cpu);
  EXPECT_EQ(app().view().picture().times().why, "there is no graphics card");
}

TEST_F(PictureControls, AnErrorMovesNoControl) {
  open("smoke.json");
  ASSERT_TRUE(script_->settle());
  script_->frames(3);
  const double exposure = app().window().controls().at("exposure").top;
  app().open(folder_.path("nowhere.json"));
  load();
  script_->frames(3);
  ASSERT_NE(app().document().error(), "");
  EXPECT_EQ(app().window().controls().at("exposure").top, exposure);
  EXPECT_EQ(app().settings().alerts.size(), 1U);
}

TEST_F(Controls, OpenGlAndTheCpuAgree) {
  open("smoke.json");
  app().settings().look.quality = 1;
  app().settings().look.renderer = 1;
  const Image gl = picture();
  app().settings().look.renderer = 2;
  const Image cpu = picture();
  double sum = 0;
  for (std::size_t i = 0; i < gl.pixels.size(); ++i) sum += std::abs(gl.pixels[i] - cpu.pixels[i]);
  // A sign is rasterised: its edges are a pixel off.
  EXPECT_LT(sum / static_cast<double>(gl.pixels.size()), 0.01);
}

TEST_F(Controls, APictureWithNothingInItSaysSo) {
  open("blob.npy");
  ASSERT_TRUE(script_->settle());
  const auto says = [&] {
    EXPECT_TRUE(script_->settle());
    script_->frames(3);
    return std::ranges::any_of(app().settings().alerts, [](const PanelNotice& notice) {
      return notice.text.starts_with("nothing is to be seen");
    });
  };
  EXPECT_FALSE(says());
  const ViewCamera there = app().view().camera();
  app().view().camera().lookAlong(-there.forward());
  app().view().camera().pan(0, 1e5, kHigh);
  EXPECT_TRUE(says());
  app().view().camera() = there;
  EXPECT_FALSE(says());
}

TEST_F(Controls, ASceneWithoutLightSaysSo) {
  std::ofstream(folder_.path("dark.json")) << R"({"format": "volute-scene-2",
    "media": [{"kind": "smoke", "case": "smoke.pvd", "quantity": "soot-density", "unit": "kg/m3"}]})";
  open("dark.json");
  EXPECT_TRUE(script_->settle());
  script_->frames(3);
  ASSERT_EQ(app().settings().alerts.size(), 1U);
  EXPECT_THAT(app().settings().alerts[0].text, ::testing::HasSubstr("the scene has no light"));
  script_->input().width = 900;
  script_->frames(3);
  ASSERT_TRUE(script_->click("add ambient"));
  load();
  EXPECT_TRUE(script_->settle());
  script_->frames(3);
  for (const PanelNotice& notice : app().settings().alerts)
    EXPECT_THAT(notice.text, ::testing::Not(::testing::HasSubstr("has no light")));
}

TEST_F(Controls, FilesOpenByDropping) {
  open("smoke.json");
  script_->open(folder_.path("map.png"));
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("a map of fog"));
  script_->open(folder_.path("smoke.vtu"));
  load();
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("smoke on a mesh"));
  script_->open(folder_.path("smoke.pvd"));
  load();
  ASSERT_TRUE(app().playback().timeline().moves());
  script_->click("time", 0.6);
  load();
  const double time = app().playback().timeline().time();
  script_->open(folder_.path("ground.obj"));
  load();
  EXPECT_TRUE(app().playback().timeline().moves());
  EXPECT_EQ(app().playback().timeline().time(), time);
  EXPECT_NE(app().document().error(), "");
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("smoke on a mesh"))
      << "it stays";
}

TEST_F(Controls, ADroppedFileIsExposedAsIfItWasOpened) {
  // The light that is exposed for is that of the window's picture.
  open("blob.npy");
  script_->settle();
  const Image alone = picture();
  script_->drop(folder_.path("fog.json"));
  load();
  const Image fog = picture();
  script_->open(folder_.path("blob.npy"));
  load();
  script_->settle();
  EXPECT_LT(difference(alone, picture()), 0.001);
  EXPECT_GT(difference(alone, fog), 0.01);
}

TEST_F(Controls, OneLooksFromTheCamerasOfACapture) {
  open("capture.json");
  EXPECT_THAT(app().document().info()->title, ::testing::HasSubstr("3 cameras, 2 frames"));
  Image shown = picture();
  for (const char* camera : {"look from a", "look from b", "look from c"}) {
    const Vec3 eye = app().view().camera().eye();
    ASSERT_TRUE(script_->click(camera));
    EXPECT_GT((app().view().camera().eye() - eye).norm(), 0.5) << camera;
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
  EXPECT_THAT(app().document().info()->remarks,
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

TEST_F(Controls, AnFdsCaseIsSeenFromOutsideAsADollsHouse) {
  fdswriter::Planes planes;
  for (int i = 0; i <= 24; ++i) planes[0].push_back(0.5 * i);
  for (int i = 0; i <= 12; ++i) planes[1].push_back(0.5 * i);
  for (int i = 0; i <= 6; ++i) planes[2].push_back(0.5 * i);
  fdswriter::Index index;
  index.meshes.push_back({planes, {{0, 24, 0, 12, 5, 6}}, {}});  // a roof
  index.smoke(1, "hall_1.s3d", 8700);
  index.save(folder_.path("hall.smv"));
  const std::vector<std::uint8_t> clear(25 * 13 * 7, 0);
  fdswriter::smokeFile({24, 12, 6}, {{0, clear}}).save(folder_.path("hall_1.s3d"));
  open("hall.smv");
  const Vec3 first = app().view().camera().eye();
  EXPECT_GT(first.z(), 3);
  EXPECT_FALSE(app().document().info()->bounds.contains(first));
  ASSERT_TRUE(script_->click("Whole view"));
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kOrbit);
  EXPECT_FALSE(app().document().info()->bounds.contains(app().view().camera().eye()));
  ASSERT_TRUE(script_->click("First view"));
  EXPECT_LT((app().view().camera().eye() - first).norm(), 1e-6);
  open("room.smv");  // without a roof
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kOrbit);
  EXPECT_FALSE(app().document().info()->bounds.contains(app().view().camera().eye()));
}

/// What was told of a long call.
class Stages final : public Progress {
 public:
  void report(std::string_view stage, double, double) override { seen.emplace(stage); }

  std::set<std::string> seen;
};

TEST_F(Controls, ProgressIsToldUntilThePictureIsDrawn) {
  Stages stages;
  app().open(folder_.path("smoke.json"));
  app().settings().look.quality = 3;
  ViewerInput input = script_->input();
  ASSERT_TRUE(viewer_->settle(input, stages));
  ASSERT_TRUE(app().view().picture().times().cpu);
  EXPECT_TRUE(stages.seen.contains("opening"));
  EXPECT_TRUE(stages.seen.contains("drawing"));
}

TEST_F(Controls, RemarksRepeatNoFolder) {
  open("room.smv");
  EXPECT_THAT(app().document().info()->remarks,
              ::testing::Contains(::testing::StartsWith("extinction from s3d")));
  for (const std::string& remark : app().document().info()->remarks)
    EXPECT_THAT(remark, ::testing::Not(::testing::HasSubstr(folder_.path("")))) << remark;
}

TEST_F(Controls, ACapturesDamagedPictureIsToldAndTheOthersShown) {
  using ::testing::AllOf;
  using ::testing::Contains;
  using ::testing::HasSubstr;
  testing::writeText(folder_.path("f_0004_b.exr"), "");
  testing::writeText(folder_.path("f_0004_c.exr"), "no picture");
  open("capture.json");
  EXPECT_EQ(app().document().error(), "");
  EXPECT_THAT(app().document().info()->remarks,
              Contains(AllOf(HasSubstr("camera b, frame 4"), HasSubstr("is empty"),
                             HasSubstr("1 of 6 pictures"))));
  ASSERT_TRUE(app().view().picture().scene());
  EXPECT_EQ(app().view().picture().scene()->quads.size(), 1U);
  // An empty picture is one that the camera missed, which the document's remarks say.
  EXPECT_THAT(app().view().picture().scene()->remarks,
              ::testing::ElementsAre(HasSubstr("camera c, frame 4")));
  ASSERT_TRUE(script_->click(">"));
  load();
  EXPECT_EQ(app().view().picture().scene()->quads.size(), 3U);
  EXPECT_TRUE(app().view().picture().scene()->remarks.empty());
}

class LayoutControls : public Controls {
 protected:
  void resize(int width, int height) {
    script_->input().width = width, script_->input().height = height;
  }

  void expectApart(int width, int height) {
    const auto& controls = app().window().controls();
    for (const auto& [name, at] : controls) {
      EXPECT_GE(at.left, 0) << name;
      EXPECT_LE(at.right, width) << name;
      EXPECT_LE(at.bottom, height) << name;
      for (const auto& [other, there] : controls) {
        if (other <= name)
          continue;
        const float across = std::min(at.right, there.right) - std::max(at.left, there.left);
        const float down = std::min(at.bottom, there.bottom) - std::max(at.top, there.top);
        EXPECT_FALSE(across > 1 && down > 1) << name << " and " << other;
      }
    }
  }

  /// How much of a part of the window is another with panels than without, 0..1.
  double covered(double left, double top, double right, double bottom) {
    EXPECT_TRUE(script_->settle());
    const Image with = viewer_->picture();
    app().settings().panels = false;
    EXPECT_TRUE(script_->settle());
    const Image without = viewer_->picture();
    app().settings().panels = true;
    script_->frames(3);
    int all = 0, other = 0;
    for (int y = int(top * with.height); y < int(bottom * with.height); ++y) {
      for (int x = int(left * with.width); x < int(right * with.width); ++x) {
        ++all;
        other += std::abs(with.at(x, y, 1) - without.at(x, y, 1)) > 0.01;
      }
    }
    return static_cast<double>(other) / all;
  }
};

TEST_F(LayoutControls, ControlsLieInTheWindowAndNotOnEachOther) {
  for (const auto& [width, height] : {std::pair{1920, 1080}, {kNarrow, kHigh}}) {
    SCOPED_TRACE(width);
    resize(width, height);
    open("fog.json");
    ASSERT_NO_FATAL_FAILURE(openPaintPanel());
    expectApart(width, height);
    EXPECT_LE(app().window().controls().at("tool coefficient").right,
              app().window().controls().at("plan").right);
  }
}

TEST_F(LayoutControls, TheMiddleOfThePictureIsFree) {
  for (const auto& [width, height] :
       {std::pair{640, 400}, {1024, 640}, {1280, 720}, {1920, 1080}}) {
    SCOPED_TRACE(width);
    resize(width, height);
    for (const char* file : {"smoke.json", "fog.json"}) {
      SCOPED_TRACE(file);
      open(file);
      EXPECT_LT(covered(0.33, 0.15, 0.67, 0.8), 3e-3) << "but by the marks of lamps";
      EXPECT_LT(covered(0, 0, 1, 1), width < 800 ? 0.2 : 0.6);
    }
  }
}

TEST_F(LayoutControls, InASmallWindowPanelsAreOpenedOneAfterTheOther) {
  constexpr int kWide = 640, kTall = 400;
  resize(kWide, kTall);
  open("fog.json");
  EXPECT_FALSE(script_->has("exposure") || script_->has("add sign") || script_->has("plan"));
  const std::pair<const char*, const char*> panels[] = {
      {"Scene", "add sign"}, {"Volute", "exposure"}, {"Paint fog", "plan"}};
  for (const auto& [title, control] : panels) {
    SCOPED_TRACE(title);
    ASSERT_TRUE(script_->click(title, 0.03));
    script_->frames(4);
    for (const auto& [other, its] : panels) EXPECT_EQ(script_->has(its), its == control) << its;
    expectApart(kWide, kTall);
    EXPECT_EQ(covered(0.48, 0.4, 0.52, 0.6), 0);
  }
  ASSERT_TRUE(script_->click("Paint fog", 0.03));
  script_->frames(4);
  EXPECT_FALSE(script_->has("plan"));
}

TEST_F(LayoutControls, AnErrorIsSeenWhileItsPanelIsClosed) {
  resize(640, 400);
  open("smoke.json");
  const double before = covered(0, 0, 0.4, 0.3);
  script_->drop(folder_.path("nowhere.json"));
  load();
  ASSERT_NE(app().document().error(), "");
  EXPECT_FALSE(script_->has("exposure"));
  EXPECT_GT(covered(0, 0, 0.4, 0.3), before + 0.1);
}

TEST_F(LayoutControls, TheHelpFitsIntoASmallWindow) {
  resize(640, 400);
  open("blob.npy");
  ASSERT_TRUE(script_->settle());
  const Image before = viewer_->picture();
  script_->press(Key::kF1);
  ASSERT_TRUE(script_->settle());
  script_->frames(4);
  const Image image = viewer_->picture();
  EXPECT_GT(difference(before, image), 0);
  for (int x = 0; x < image.width; ++x) {
    EXPECT_EQ(image.at(x, 3, 0), before.at(x, 3, 0)) << x;
    EXPECT_EQ(image.at(x, image.height - 4, 0), before.at(x, image.height - 4, 0)) << x;
  }
}

/// A name is cut in front, where it says least.
TEST(Shortened, KeepsTheEndOfAName) {
  EXPECT_EQ(shortened("/home/me/case.smv.json", 30), "/home/me/case.smv.json");
  EXPECT_EQ(shortened("/home/me/case.smv.json", 20), ".../me/case.smv.json");
  EXPECT_EQ(shortened("/home/me/case.smv.json", 19), ".../case.smv.json");
  EXPECT_EQ(shortened("/home/me/case.smv.json", 14), "...se.smv.json");
  EXPECT_EQ(shortened("/h/\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4", 6), "...\xC3\xA4\xC3\xA4\xC3\xA4");
  EXPECT_EQ(shortened("/h/\xC3\xA4\xC3\xA4", 5), "/h/\xC3\xA4\xC3\xA4") << "letters, not bytes";
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
    for (int i = 0; i < 20'000 && !holds(); ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return holds();
  };
  std::filesystem::copy_file(folder_.path("map.png"), folder_.path("whole.png"));
  std::ofstream(folder_.path("torn.png")) << "\x89PNG and then nothing";
  replace("map.png", "torn.png");
  EXPECT_TRUE(until([&] { return !app().document().error().empty(); }));
  EXPECT_THAT(app().document().error(), ::testing::HasSubstr("map.png"));
  ASSERT_NE(app().document().info(), nullptr);
  EXPECT_LT(difference(shown, picture()), 0.001);
  replace("map.png", "whole.png");
  EXPECT_TRUE(until([&] { return app().document().error().empty(); }));
  EXPECT_LT(difference(shown, picture()), 0.001);
  std::filesystem::copy_file(folder_.path("fog.json"), folder_.path("whole.json"));
  std::ofstream(folder_.path("torn.json")) << "{\"format\": ";
  replace("fog.json", "torn.json");
  EXPECT_TRUE(until([&] { return !app().document().error().empty(); }));
  EXPECT_LT(difference(shown, picture()), 0.001);
  replace("fog.json", "dull.json");
  EXPECT_TRUE(until([&] { return app().document().error().empty(); }));
  EXPECT_GT(difference(shown, picture()), 0.01) << "without a sun";
}

}  // namespace
}  // namespace volute
