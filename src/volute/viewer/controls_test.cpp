// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Every control of the viewer, driven by its input layer on real files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <ranges>
#include <set>
#include <thread>

#include "volute/io/film.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/viewer/script.hpp"

namespace volute {
namespace {

constexpr int kWidth = 1000, kHeight = 1100;
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;

/// A folder with a scene of everything: fog, smoke on a mesh, lights, signs, ground.
class SceneFolder {
 public:
  SceneFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "volute-viewer-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      std::abort();
    path_ = name;
    writeMapOfFog();
    writeSmoke();
    std::ofstream(path("ground.obj")) << "v -1 -1 0\nv 7 -1 0\nv 7 7 0\nv -1 7 0\nf 1 2 3 4\n";
    std::ofstream(path("fog.json")) << kFog;
    std::ofstream(path("dull.json")) << kDull;
    std::ofstream(path("smoke.json")) << kSmoke;
  }

  ~SceneFolder() { std::filesystem::remove_all(path_); }

  std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  void writeMapOfFog() const {
    Image map(14, 10, 1);
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 14; ++x)
        map.at(x, y) =
            static_cast<float>(0.6 * std::exp(-(std::pow(x - 6, 2) + std::pow(y - 4, 2)) / 12));
    }
    ASSERT_TRUE(writeMap(path("map.png"), map));
  }

  void writeSmoke() const {
    const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 6, 3)}, {4, 4, 3}, 0.1, 1);
    std::vector<float> values;
    for (const Vec3& p : mesh->vertices())
      values.push_back(static_cast<float>(5e-5 * (0.2 + p.z() / 3)));
    ASSERT_TRUE(writeVtu(path("smoke.vtu"), *mesh, "smoke", values));
    for (float& value : values) value *= 3;
    ASSERT_TRUE(writeVtu(path("more.vtu"), *mesh, "smoke", values));
    const SeriesFile series[] = {{"smoke.vtu", 0}, {"more.vtu", 0.2}};
    ASSERT_TRUE(writePvd(path("smoke.pvd"), series));
  }

  static constexpr const char* kFog = R"({"format": "volute-scene-1",
    "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
    "lights": [{"kind": "sun", "direction": [0.4, 0.5, -0.6], "radiance": [2, 1.8, 1.5]}],
    "media": [{"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4, "degree": 1,
               "levels": 2, "mu": 0.5, "asymmetry": 0.3,
               "profile": {"kind": "slab", "bottom": 0, "top": 4}}]})";
  static constexpr const char* kDull = R"({"format": "volute-scene-1",
    "camera": {"eye": [-9, -12, 11], "target": [7, 5, 0], "fov": 45}, "background": [0.2, 0.1, 0.05],
    "media": [{"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.4, "degree": 1,
               "levels": 2, "mu": 0.5, "profile": {"kind": "exponential", "bottom": 0, "height": 4}}]})";
  static constexpr const char* kSmoke = R"({"format": "volute-scene-1",
    "camera": {"eye": [-6, 2, 2.2], "target": [5, 3, 1.2], "fov": 50}, "background": [0.2, 0.25, 0.3],
    "lights": [{"kind": "ambient", "radiance": [0.3, 0.3, 0.3]},
               {"kind": "spot", "position": [3, 3, 2.9], "target": [3.5, 3, 0], "angle": 100, "intensity": [9, 8, 7]}],
    "geometry": [{"file": "ground.obj"}],
    "media": [{"kind": "smoke", "case": "smoke.pvd", "quantity": "products-density", "unit": "kg/m3",
               "smoke_potential": 2.0, "mode": "threshold", "C": 3}],
    "signs": [{"name": "exit", "position": [5.9, 3, 1.8], "normal": [-1, 0, 0], "size": [1.6, 0.8], "emitting": false}]})";

  std::filesystem::path path_;
};

double difference(const Image& a, const Image& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max<double>(largest, std::abs(a.pixels[i] - b.pixels[i]));
  return largest;
}

class Controls : public testing::Test {
 protected:
  void SetUp() override {
    auto made = HeadlessViewer::create(documentOpener({.maxMemory = kMemory}));
    if (!made)
      GTEST_SKIP() << made.error().message;
    viewer_ = std::move(*made);
    script_ = std::make_unique<ViewerScript>(*viewer_, kWidth, kHeight);
  }

  ViewerApp& app() { return viewer_->app(); }

  void open(const std::string& name) {
    app().open(folder_.path(name));
    app().settings().look.quality = 3;
    load();
    ASSERT_EQ(app().error(), "");
    app().settings().look.quality = 3;
  }

  /// The scene without panels.
  Image picture() {
    app().settings().panels = false;
    script_->input().width = 120, script_->input().height = 90;
    EXPECT_TRUE(script_->settle());
    Image image = viewer_->picture();
    app().settings().panels = true;
    script_->input().width = kWidth, script_->input().height = kHeight;
    script_->frames(4);
    return image;
  }

  std::vector<double> valueOf(const std::string& path) {
    for (const Parameter& parameter : app().document()->parameters) {
      if (parameter.path == path)
        return parameter.value;
    }
    ADD_FAILURE() << path << " is gone";
    return {};
  }

  /// Until what was asked for is there.
  void load() {
    for (int quiet = 0; quiet < 12; ++quiet) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      if (app().loading().busy)
        quiet = 0;
    }
  }

  /// As a person would.
  void change(const Parameter& parameter) {
    double x = 0, y = 0;
    ASSERT_TRUE(script_->pointOf(parameter.path, 0, 0.5, x, y)) << parameter.path;
    switch (parameter.kind) {
      case Parameter::Kind::kNumber:
      case Parameter::Kind::kInteger: {
        const double share =
            (parameter.value[0] - parameter.least) / (parameter.most - parameter.least);
        script_->click(parameter.path, parameter.logarithmic || share < 0.5 ? 0.64 : 0.12);
        break;
      }
      case Parameter::Kind::kFlag:
        script_->clickAt(x + 8, y);
        break;
      case Parameter::Kind::kChoice: {
        const auto held = static_cast<std::size_t>(parameter.value[0]);
        script_->choose(parameter.path, parameter.choices[held == 0 ? 1 : held - 1]);
        break;
      }
      case Parameter::Kind::kColor:
        script_->drag(x + 10, y, x + 10 + (parameter.value[0] > 0.5 ? -90 : 90), y);
        break;
      case Parameter::Kind::kPoint:
        script_->drag(x + 10, y, x - 60, y);
        break;
      case Parameter::Kind::kDirection:
        script_->click(parameter.path, 0.2);
        break;
    }
  }

  /// Of the picture and of the value.
  void expectChange(const Parameter& parameter) {
    SCOPED_TRACE(parameter.path);
    const Image before = picture();
    change(parameter);
    load();
    EXPECT_EQ(app().error(), "");
    EXPECT_NE(valueOf(parameter.path), parameter.value);
    EXPECT_GT(difference(before, picture()), 0.0005);
  }

  /// Each one changes the picture and its value.
  void changeAll(std::set<std::string> done = {}, const std::string& part = "/") {
    for (bool more = true; more;) {
      more = false;
      for (const Parameter& parameter : std::vector(app().document()->parameters)) {
        if (!parameter.path.starts_with(part) || parameter.path.ends_with("/material") ||
            !done.insert(parameter.path).second)
          continue;
        expectChange(parameter);
        more = true;
        break;  // the list may be another by now
      }
    }
    EXPECT_GE(done.size(), 4u);
  }

  void saveAs(const std::string& name) {
    ASSERT_TRUE(script_->write("scene", folder_.path(name)));
    EXPECT_EQ(app().settings().sceneName, folder_.path(name));
    ASSERT_TRUE(script_->click("Save scene"));
    load();
    EXPECT_EQ(app().error(), "");
    ASSERT_TRUE(std::filesystem::exists(folder_.path(name)));
  }

  void expectTheSameAfter(const std::string& name) {
    const auto before = app().document()->parameters;
    const ViewLook look = app().settings().look;
    const Vec3 eye = app().camera().eye();
    const Image shown = picture();
    app().settings().look = {};
    app().open(folder_.path(name));
    load();
    ASSERT_EQ(app().error(), "");
    const auto after = app().document()->parameters;
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(before[i].path, after[i].path);
      EXPECT_EQ(before[i].value, after[i].value) << before[i].path;
    }
    EXPECT_EQ(app().settings().look.stops, look.stops);
    EXPECT_EQ(app().settings().look.quality, look.quality);
    EXPECT_LT((app().camera().eye() - eye).norm(), 1e-9);
    EXPECT_LT(difference(shown, picture()), 0.02);
  }

  SceneFolder folder_;
  std::unique_ptr<HeadlessViewer> viewer_;
  std::unique_ptr<ViewerScript> script_;
};

TEST_F(Controls, EveryParameterOfFogAndItsSun) {
  open("fog.json");
  changeAll({"/media/0/mu", "/media/0/levels"});  // sunlit fog keeps its details
  ASSERT_TRUE(script_->click("exposure", 0.6));
  saveAs("fog2.json");
  expectTheSameAfter("fog2.json");
}

TEST_F(Controls, FogWithoutASunDropsDetails) {
  open("dull.json");
  changeAll();
}

TEST_F(Controls, EveryParameterOfSmokeAndLamps) {
  open("smoke.json");
  changeAll({"/media/0/mode"}, "/media");  // last: C is the threshold's alone
  const Image threshold = picture();
  ASSERT_TRUE(script_->choose("/media/0/mode", "photometric"));
  load();
  EXPECT_GT(difference(threshold, picture()), 0.0005);
  changeAll({}, "/lights");
  saveAs("smoke2.json");
  expectTheSameAfter("smoke2.json");
}

TEST_F(Controls, EveryParameterOfSigns) {
  open("smoke.json");
  const std::set<std::string> first = {"/signs/0/C", "/signs/0/emitting"};  // while it is well seen
  for (const std::string& path : first) {
    const std::vector parameters = app().document()->parameters;
    expectChange(*std::ranges::find(parameters, path, &Parameter::path));
  }
  changeAll(first, "/signs");
  saveAs("signs2.json");
  expectTheSameAfter("signs2.json");
}

TEST_F(Controls, AMaterialHasItsSmokePotential) {
  open("smoke.json");
  const auto find = [&] {
    return *std::ranges::find(app().document()->parameters, "/media/0/material", &Parameter::path);
  };
  const Image before = picture();
  ASSERT_TRUE(script_->choose("/media/0/material", find().choices[3]));
  load();
  EXPECT_EQ(find().value[0], 3);
  EXPECT_NE(valueOf("/media/0/smoke_potential")[0], 2.0);
  EXPECT_GT(difference(before, picture()), 0.001);
}

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
  changes("Whole view", [&] { script_->drag(500, 900, 600, 950); });
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
  saveAs("look.json");
  app().settings().look = {};
  app().open(folder_.path("look.json"));
  load();
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
  open("fog.json");
  script_->clickAt(app().controls().at("Paint fog").left + 10,
                   app().controls().at("Paint fog").top + 10);
  script_->frames(3);
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
  EXPECT_THAT(app().message(), testing::HasSubstr("is written"));
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
  EXPECT_THAT(app().document()->title, testing::HasSubstr("a map of fog"));
  script_->drop(folder_.path("smoke.vtu"));
  load();
  EXPECT_THAT(app().document()->title, testing::HasSubstr("smoke on a mesh"));
  script_->drop(folder_.path("ground.obj"));
  load();
  EXPECT_NE(app().error(), "");
  EXPECT_THAT(app().document()->title, testing::HasSubstr("smoke on a mesh")) << "it stays";
}

}  // namespace
}  // namespace volute
