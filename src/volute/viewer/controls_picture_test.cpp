// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The viewer's controls that are no parameters of a document: picture, time, paint, film, files.
#include <array>

#include "volute/io/film.hpp"
#include "volute/viewer/controls_testing.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

TEST_F(Controls, ThePicturesOwn) {
  open("smoke.json");
  const auto changes = [&](const std::string& what, const auto& act) {
    SCOPED_TRACE(what);
    const Image before = picture();
    act();
    load();
    EXPECT_GT(difference(before, picture()), 0.001);
  };
  changes("exposure", [&] { EXPECT_TRUE(script_->click("exposure", 0.5)); });
  EXPECT_GT(app().settings().look.stops, 2);
  app().settings().look.stops = 0;  // or all is white
  changes("view", [&] { script_->click("view", 0.6); });
  changes("turning", [&] { script_->drag(100, 620, 200, 660); });
  changes("Whole view", [&] { EXPECT_TRUE(script_->click("Whole view")); });
  changes("First view", [&] { EXPECT_TRUE(script_->click("First view")); });
  changes("surfaces", [&] { script_->click("surfaces", 0.1); });
  EXPECT_FALSE(app().settings().look.surfaces);
  changes("quality", [&] { script_->choose("quality", "half"); });
  EXPECT_EQ(app().settings().look.quality, 2);
  script_->choose("quality", "quarter");
  script_->choose("camera", "walk");
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kWalk);
  changes("time", [&] { script_->click("time", 0.99); });
  EXPECT_GT(app().timeline().time(), 0.15);
  changes("<", [&] { script_->click("<"); });
  EXPECT_EQ(app().timeline().time(), 0);
  changes(">", [&] { script_->click(">"); });
  EXPECT_TRUE(script_->click("More"));
  script_->click("speed", 0.2);
  EXPECT_LT(app().timeline().speed(), 0.5);
  script_->click("Play");
  EXPECT_TRUE(app().timeline().playing());
  script_->click("Play");
  EXPECT_FALSE(app().timeline().playing());
  script_->choose("renderer", "OpenGL");
  picture();
  EXPECT_FALSE(app().times().processor);
  script_->choose("renderer", "processor");
  picture();
  EXPECT_TRUE(app().times().processor);
  script_->click("Screenshot");
  EXPECT_TRUE(app().takeScreenshotWish());
  script_->click("Help");
  EXPECT_TRUE(app().settings().help);
  app().settings().help = false;
  app().timeline().setSpeed(2);
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
  EXPECT_EQ(app().timeline().speed(), 2);
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kWalk);
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

TEST_F(Controls, FogIsPaintedOnThePlanAndOnTheGround) {
  constexpr int kWidth = 1000, kHeight = 1100;  // so that the ground is seen beside the panel
  script_->input().width = kWidth, script_->input().height = kHeight;
  open("fog.json");
  ASSERT_NO_FATAL_FAILURE(openPaintPanel());
  for (const char* control : {"tool add", "brush size", "brush strength", "brush softness", "plan",
                              "Undo", "Redo", "Clear", "map", "Save map", "paint in the view"})
    EXPECT_TRUE(script_->has(control)) << control;
  const FogPainter& painter = app().paint().painter();
  const auto begun = painter.coefficients().c;
  ASSERT_TRUE(script_->click("brush size", 0.6));
  EXPECT_GT(app().paint().brush.radius, 1.5);
  ASSERT_TRUE(script_->click("brush strength", 0.6));
  EXPECT_GT(app().paint().brush.strength, 1);
  ASSERT_TRUE(script_->click("brush softness", 0.3));
  EXPECT_LT(app().paint().brush.softness, 0.5);
  const Image before = picture();
  double x = 0, y = 0;
  ASSERT_TRUE(script_->pointOf("plan", 0.75, 0.7, x, y));
  script_->drag(x, y, x + 20, y, 0, 12);
  load();
  const auto painted = painter.coefficients().c;
  EXPECT_NE(painted, begun);
  EXPECT_GT(difference(before, picture()), 0.01);
  ASSERT_TRUE(script_->click("Undo"));
  EXPECT_EQ(painter.coefficients().c, begun);
  load();
  EXPECT_LT(difference(before, picture()), 0.001);
  ASSERT_TRUE(script_->click("Redo"));
  EXPECT_EQ(painter.coefficients().c, painted);
  ASSERT_TRUE(script_->click("paint in the view", 0.05));
  ASSERT_TRUE(app().settings().painting);
  // On the ground, in the middle of the 3D view.
  const auto ground = app().camera().camera(kWidth, kHeight).project(Vec3(8, 6, 0));
  ASSERT_TRUE(ground);
  ASSERT_TRUE(script_->click("tool coefficient", 0.1));
  const auto place = painter.nearest(Vec2(8, 6));
  const double low = painter.valueOf(*place);
  script_->drag(ground->x(), ground->y(), ground->x(), ground->y() - 60);
  EXPECT_NEAR(painter.valueOf(*place), std::min(low + 60.0 / 200 * painter.most(), painter.most()),
              0.05 * painter.most());
  ASSERT_TRUE(script_->click("tool remove", 0.1));
  script_->drag(ground->x() - 20, ground->y(), ground->x() + 20, ground->y(), 0, 12);
  EXPECT_LT(painter.valueOf(*place), low + 0.3 * painter.most());
  ASSERT_TRUE(script_->click("tool smooth", 0.1));
  script_->drag(ground->x() - 20, ground->y(), ground->x() + 20, ground->y(), 0, 12);
  const auto last = painter.coefficients().c;
  script_->press(Key::kZ, true);
  EXPECT_NE(painter.coefficients().c, last);
  script_->press(Key::kY, true);
  EXPECT_EQ(painter.coefficients().c, last);
  ASSERT_TRUE(script_->write("map", folder_.path("painted.png")));
  ASSERT_TRUE(script_->click("Save map"));
  load();
  EXPECT_EQ(app().error(), "");
  EXPECT_FALSE(app().paint().canvas().unsaved);
  saveAs("painted.json");
  app().open(folder_.path("painted.json"));
  load();
  ASSERT_TRUE(app().paint().has());
  const auto& read = app().paint().painter().coefficients().c;
  ASSERT_EQ(read.size(), last.size());
  for (std::size_t i = 0; i < last.size(); ++i)
    EXPECT_NEAR(read[i], last[i], 0.4 * 0.51 / 65535) << i;
  ASSERT_TRUE(script_->click("Clear"));
  EXPECT_TRUE(std::ranges::all_of(app().paint().painter().coefficients().c,
                                  [](double v) { return v == 0; }));
}

TEST_F(Controls, AFilmIsMadeBesideTheWindowOrNotAtAll) {
  open("smoke.pvd");
  ASSERT_TRUE(script_->click("More"));
  ASSERT_TRUE(script_->choose("film size", "640 x 360"));
  ASSERT_TRUE(script_->write("film", folder_.path("film.mp4")));
  ASSERT_TRUE(script_->click("Make film"));
  if (!app().film() && !app().message().empty())
    GTEST_SKIP() << app().message();
  script_->frames(3);
  ASSERT_TRUE(app().film());
  ASSERT_TRUE(script_->click("Cancel film"));
  script_->frames(2);
  EXPECT_FALSE(app().film());
  EXPECT_FALSE(std::filesystem::exists(folder_.path("film.mp4")));
  ASSERT_TRUE(script_->click("Make film"));
  while (app().film()) load();
  EXPECT_THAT(app().message(), ::testing::HasSubstr("is written"));
  auto reader = FilmReader::open(folder_.path("film.mp4"));
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->info().width, 640);
  int frames = 0;
  for (auto next = reader->next(); next && *next; next = reader->next()) ++frames;
  EXPECT_EQ(frames, 6) << "0 to 0.2 s, 25 a second";
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

TEST_F(Controls, AnFdsCaseIsSeenFromWithinItsRoom) {
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
  EXPECT_LT((app().camera().eye() - Vec3(0.5, 3, 1.7)).norm(), 0.1);
  EXPECT_GT((app().camera().view().target - app().camera().eye()).normalized().x(), 0.999);
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kWalk);
  ASSERT_TRUE(script_->click("Whole view"));
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kOrbit);
  EXPECT_FALSE(app().document()->bounds.contains(app().camera().eye()));
  ASSERT_TRUE(script_->click("First view"));
  EXPECT_LT((app().camera().eye() - Vec3(0.5, 3, 1.7)).norm(), 0.1);
  open("room.smv");  // without a roof
  EXPECT_EQ(app().camera().mode(), ViewCamera::Mode::kOrbit);
  EXPECT_FALSE(app().document()->bounds.contains(app().camera().eye()));
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
  ASSERT_TRUE(app().times().processor);
  EXPECT_TRUE(stages.seen.contains("opening"));
  EXPECT_TRUE(stages.seen.contains("drawing"));
}

TEST_F(Controls, RemarksRepeatNoFolder) {
  open("room.smv");
  EXPECT_THAT(app().document()->remarks,
              ::testing::Contains(::testing::StartsWith("extinction from s3d")));
  for (const std::string& remark : app().document()->remarks)
    EXPECT_THAT(remark, ::testing::Not(::testing::HasSubstr(folder_.path("")))) << remark;
}

TEST_F(Controls, ACapturesDamagedPictureIsToldAndTheOthersShown) {
  using ::testing::AllOf;
  using ::testing::Contains;
  using ::testing::HasSubstr;
  testing::writeText(folder_.path("f_0004_b.exr"), "");
  testing::writeText(folder_.path("f_0004_c.exr"), "no picture");
  open("capture.json");
  EXPECT_EQ(app().error(), "");
  EXPECT_THAT(app().document()->remarks,
              Contains(AllOf(HasSubstr("camera b, frame 4"), HasSubstr("is empty"),
                             HasSubstr("1 of 6 pictures"))));
  ASSERT_TRUE(app().picture().scene());
  EXPECT_EQ(app().picture().scene()->quads.size(), 1U);
  EXPECT_THAT(
      app().picture().scene()->remarks,
      ::testing::ElementsAre(HasSubstr("camera b, frame 4"), HasSubstr("camera c, frame 4")));
  ASSERT_TRUE(script_->click(">"));
  load();
  EXPECT_EQ(app().picture().scene()->quads.size(), 3U);
  EXPECT_TRUE(app().picture().scene()->remarks.empty());
}

class Layout : public Controls {
 protected:
  void resize(int width, int height) {
    script_->input().width = width, script_->input().height = height;
  }

  void expectApart(int width, int height) {
    const auto& controls = app().controls();
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

TEST_F(Layout, ControlsLieInTheWindowAndNotOnEachOther) {
  for (const auto& [width, height] : {std::pair{1920, 1080}, {kNarrow, kHigh}}) {
    SCOPED_TRACE(width);
    resize(width, height);
    open("fog.json");
    ASSERT_NO_FATAL_FAILURE(openPaintPanel());
    expectApart(width, height);
    EXPECT_LE(app().controls().at("tool coefficient").right, app().controls().at("plan").right);
  }
}

TEST_F(Layout, TheMiddleOfThePictureIsFree) {
  for (const auto& [width, height] :
       {std::pair{640, 400}, {1024, 640}, {1280, 720}, {1920, 1080}}) {
    SCOPED_TRACE(width);
    resize(width, height);
    for (const char* file : {"smoke.json", "fog.json"}) {
      SCOPED_TRACE(file);
      open(file);
      EXPECT_EQ(covered(0.33, 0.15, 0.67, 0.8), 0);
      EXPECT_LT(covered(0, 0, 1, 1), width < 800 ? 0.2 : 0.6);
    }
  }
}

TEST_F(Layout, InASmallWindowPanelsAreOpenedOneAfterTheOther) {
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

TEST_F(Layout, AnErrorIsSeenWhileItsPanelIsClosed) {
  resize(640, 400);
  open("smoke.json");
  const double before = covered(0, 0, 0.4, 0.3);
  script_->drop(folder_.path("nowhere.json"));
  load();
  ASSERT_NE(app().error(), "");
  EXPECT_FALSE(script_->has("exposure"));
  EXPECT_GT(covered(0, 0, 0.4, 0.3), before + 0.1);
}

TEST_F(Layout, TheHelpFitsIntoASmallWindow) {
  resize(640, 400);
  open("blob.npy");
  script_->press(Key::kF1);
  script_->frames(4);
  const Image image = viewer_->picture();
  for (int x = 0; x < image.width; ++x) {
    EXPECT_EQ(image.at(x, 3, 0), image.at(0, 3, 0)) << x;
    EXPECT_EQ(image.at(x, image.height - 4, 0), image.at(0, image.height - 4, 0)) << x;
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

/// Whoever adds a control adds it to the tests above, and here.
TEST_F(Controls, NoneIsLeftOut) {
  const std::set<std::string> driven = {"exposure",
                                        "colours",
                                        "quality",
                                        "renderer",
                                        "view",
                                        "surfaces",
                                        "camera",
                                        "Whole view",
                                        "First view",
                                        "Screenshot",
                                        "Help",
                                        "look from a",
                                        "look from b",
                                        "look from c",
                                        "scene",
                                        "Save scene",
                                        "Play",
                                        "<",
                                        ">",
                                        "speed",
                                        "time",
                                        "film",
                                        "film size",
                                        "Make film",
                                        "tool add",
                                        "tool remove",
                                        "tool smooth",
                                        "tool coefficient",
                                        "brush size",
                                        "brush strength",
                                        "brush softness",
                                        "plan",
                                        "Undo",
                                        "Redo",
                                        "Clear",
                                        "map",
                                        "Save map",
                                        "paint in the view",
                                        "Paint fog",
                                        "Volute",
                                        "Scene",
                                        "More",
                                        "who draws",
                                        "add sign",
                                        "add lamp",
                                        "add sun",
                                        "add ambient",
                                        "Undo change",
                                        "Redo change"};
  for (const char* name : {"fog.json", "smoke.json", "blob.npy", "capture.json", "room.smv"}) {
    SCOPED_TRACE(name);
    open(name);
    if (script_->has("Paint fog")) {
      script_->click("Paint fog", 0.02);
      script_->frames(3);
    }
    for (const auto& [control, place] : app().controls()) {
      const bool each =
          std::ranges::any_of(std::array{"/", "group ", "place /", "duplicate /", "remove /"},
                              [&](const char* begin) { return control.starts_with(begin); });
      EXPECT_TRUE(each || driven.contains(control)) << control;
    }
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
