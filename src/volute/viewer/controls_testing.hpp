// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What tests of the viewer's controls share: files of every kind, and a hand.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <ranges>
#include <set>
#include <thread>

#include "volute/base/program.hpp"
#include "volute/capture/testing.hpp"
#include "volute/fds/fds_case_testing.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/viewer/script.hpp"

namespace volute {

/// Of the window: room for all panels, and no more than that.
constexpr int kNarrow = 660, kHigh = 1060;
constexpr std::uint64_t kViewerMemory = std::uint64_t{1} << 30;

/// A folder with a scene of everything: fog, smoke on a mesh, lights, signs, ground.
class SceneFolder {
 public:
  SceneFolder() {
    writeMapOfFog();
    writeSmoke();
    writeVolume();
    writeCapture();
    writeFdsCase();
    std::ofstream(path("ground.obj")) << "v -1 -1 0\nv 7 -1 0\nv 7 7 0\nv -1 7 0\nf 1 2 3 4\n";
    std::ofstream(path("fog.json")) << kFog;
    std::ofstream(path("dull.json")) << kDull;
    std::ofstream(path("smoke.json")) << kSmoke;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

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

  /// Two frames of a blob.
  void writeVolume() const {
    VolumeInfo info;
    info.frames = 2, info.x = info.y = info.z = 10;
    info.fillDefaults();
    auto sink = NpySink::create(path("blob.npy"), info);
    ASSERT_TRUE(sink);
    for (const double middle : {3.0, 6.0}) {
      std::vector<float> values;
      for (int z = 0; z < 10; ++z) {
        for (int y = 0; y < 10; ++y) {
          for (int x = 0; x < 10; ++x)
            values.push_back(
                std::max(0.0F, float(1 - std::hypot(x - middle, y - 4.5, z - 4.5) / 3)));
        }
      }
      ASSERT_TRUE((*sink)->writeFrame(values));
    }
    ASSERT_TRUE((*sink)->finish());
  }

  /// Three cameras, two frames.
  void writeCapture() const {
    for (const char camera : {'a', 'b', 'c'}) {
      for (const int frame : {4, 5}) {
        Image image(testing::kWidth, testing::kHeight);
        image.at(12, 8, frame - 4) = static_cast<float>(camera - 'a' + 1);
        ASSERT_TRUE(writeImage(path(fmt::format("f_{:04d}_{}.exr", frame, camera)), image));
      }
    }
    testing::writeText(path("capture.json"), testing::ringJson().dump());
  }

  /// A room of one mesh with smoke at two times.
  void writeFdsCase() const {
    fdswriter::Index index;
    index.meshes.push_back({kFirst, {{1, 3, 1, 3, 0, 1}}, {}});
    index.smoke(1, "room_1.s3d", 8700);
    index.save(path("room.smv"));
    std::vector<std::uint8_t> some, more;
    for (const double k : fdswriter::atNodes(kFirst, linear)) {
      some.push_back(static_cast<std::uint8_t>(10 * k));
      more.push_back(static_cast<std::uint8_t>(40 * k));
    }
    fdswriter::smokeFile(cellsOf(kFirst), {{0, some}, {5, more}}).save(path("room_1.s3d"));
    fdswriter::Index soot;
    soot.meshes.push_back({kFirst, {{1, 3, 1, 3, 0, 1}}, {}});
    const fdswriter::Slice slice{whole(kFirst), "SOOT DENSITY", "rho", "kg/m3"};
    const auto density = [](double x, double y, double z) { return 1e-4 * linear(x, y, z); };
    fdswriter::sliceFile(slice, {{0, fdswriter::atNodes(kFirst, slice.at, density)}})
        .save(path("soot.sf"));
    soot.slice(1, slice, "soot.sf", false);
    soot.save(path("soot.smv"));
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

  ScratchFolder folder_;
};

/// Of all tests of this program.
inline ControlRecord& controlRecord() {
  static ControlRecord record;
  return record;
}

inline double difference(const Image& a, const Image& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max<double>(largest, std::abs(a.pixels[i] - b.pixels[i]));
  return largest;
}

class Controls : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made =
        HeadlessViewer::create(documentOpener({.maxMemory = kViewerMemory}), {.rasteriser = true});
    if (!made)
      GTEST_SKIP() << made.error().message;
    viewer_ = std::move(*made);
    begin(kNarrow, kHigh);
  }

  /// Another viewer instead: there is one interface at a time.
  void restart(ViewerOptions options, DocumentOptions document = {}) {
    const int width = script_->input().width, height = script_->input().height;
    script_.reset(), viewer_.reset();
    document.maxMemory = kViewerMemory;
    options.rasteriser = true;
    auto made = HeadlessViewer::create(documentOpener(document), options);
    ASSERT_TRUE(made) << made.error().message;
    viewer_ = std::move(*made);
    begin(width, height);
  }

  void begin(int width, int height) {
    script_ = std::make_unique<ViewerScript>(*viewer_, width, height);
    script_->record = &controlRecord();
  }

  ViewerApp& app() { return viewer_->app(); }

  void open(const std::string& name) {
    app().open(folder_.path(name));
    app().settings().look.quality = 3;
    load();
    ASSERT_EQ(app().document().error(), "");
    app().settings().look.quality = 3;
  }

  /// By the arrow on its title, once the first picture's times are above it.
  void openPaintPanel() {
    ASSERT_TRUE(script_->settle());
    script_->frames(3);  // a panel that appears finds its size first
    if (!script_->has("plan"))
      script_->click("Paint fog", 0.03);
    script_->frames(5);
    ASSERT_TRUE(script_->has("plan"));
  }

  /// The scene without panels, as large as pictureWidth_ by pictureHeight_.
  Image picture() {
    ViewerInput& input = script_->input();
    const int width = std::exchange(input.width, pictureWidth_);
    const int height = std::exchange(input.height, pictureHeight_);
    app().settings().panels = false;
    EXPECT_TRUE(script_->settle());
    Image image = viewer_->picture();
    app().settings().panels = true;
    input.width = width, input.height = height;
    script_->frames(3);  // panels find their places
    return image;
  }

  /// The speed and the film's controls, which "More" hides where the window is narrow.
  void openMore() {
    if (!script_->has("speed"))
      script_->click("More");
    script_->frames(3);
    ASSERT_TRUE(script_->has("speed"));
  }

  std::vector<double> valueOf(const std::string& path) {
    for (const Parameter& parameter : app().document().info()->parameters) {
      if (parameter.path == path)
        return parameter.value;
    }
    ADD_FAILURE() << path << " is gone";
    return {};
  }

  /// Until what was asked for is there.
  void load() {
    do {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (!app().document().idle());
    script_->frames(2);
  }

  /// As a person would.
  void change(const Parameter& parameter) {
    ASSERT_TRUE(script_->has(parameter.path)) << parameter.path;
    switch (parameter.kind) {
      case Parameter::Kind::kNumber:
      case Parameter::Kind::kInteger: {
        const double share =
            (parameter.value[0] - parameter.least) / (parameter.most - parameter.least);
        const double right = parameter.name.size() > 12 ? 0.45 : 0.55;  // of it is the name
        script_->click(parameter.path, parameter.logarithmic || share < 0.5 ? right : 0.12);
        break;
      }
      case Parameter::Kind::kFlag:
        script_->click(parameter.path, 0.1);
        break;
      case Parameter::Kind::kChoice: {
        const auto held = static_cast<std::size_t>(parameter.value[0]);
        script_->choose(parameter.path, parameter.choices[held == 0 ? 1 : held - 1]);
        break;
      }
      case Parameter::Kind::kColor:
        script_->dragFrom(parameter.path, 0.1, 0.5, parameter.value[0] > 0.5 ? -90 : 90, 0);
        break;
      case Parameter::Kind::kPoint:
        script_->dragFrom(parameter.path, 0.1, 0.5, -70, 0);
        break;
      case Parameter::Kind::kDirection:
        script_->click(parameter.path, 0.2);
        break;
    }
  }

  /// `act` changes the picture.
  template <class Act>
  void expectSeen(const std::string& what, Act&& act) {
    SCOPED_TRACE(what);
    const Image before = picture();
    act();
    load();
    EXPECT_GT(difference(before, picture()), 0.0005);
  }

  /// What the window shows at a control: its upper left part, of this size [pixels].
  Image shownAt(const std::string& control, int width, int height) {
    double x = 0, y = 0;
    EXPECT_TRUE(script_->pointOf(control, 0, 0, x, y)) << control;
    const Image all = viewer_->picture();
    Image part(width, height);
    for (int j = 0; j < height; ++j) {
      for (int i = 0; i < width; ++i) {
        for (int c = 0; c < 3; ++c) {
          part.at(i, j, c) = all.at(std::min(static_cast<int>(x) + i, all.width - 1),
                                    std::min(static_cast<int>(y) + j, all.height - 1), c);
        }
      }
    }
    return part;
  }

  /// Of the value, and of the picture, which was `shown` and then is what came of it.
  void expectChange(const Parameter& parameter, Image& shown) {
    SCOPED_TRACE(parameter.path);
    change(parameter);
    load();
    EXPECT_EQ(app().document().error(), "");
    EXPECT_NE(valueOf(parameter.path), parameter.value);
    Image now = picture();
    EXPECT_GT(difference(shown, now), 0.0005);
    shown = std::move(now);
  }

  Parameter parameterAt(const std::string& path) {
    const auto& all = app().document().info()->parameters;
    const auto found = std::ranges::find(all, path, &Parameter::path);
    EXPECT_NE(found, all.end()) << path;
    return found == all.end() ? Parameter{} : *found;
  }

  /// The elevation of a direction, which has a slider of its own.
  void expectElevation(const std::string& path) {
    SCOPED_TRACE(path);
    const auto before = valueOf(path);
    const Image shown = picture();
    ASSERT_TRUE(script_->click(path + " elevation", 0.2));
    load();
    EXPECT_NE(valueOf(path), before);
    EXPECT_GT(difference(shown, picture()), 0.0005);
  }

  /// Each one changes the picture and its value.
  void changeAll(std::set<std::string> done = {}, const std::string& part = "/") {
    Image shown = picture();
    const std::size_t given = done.size();
    for (bool more = true; more;) {
      more = false;
      for (const Parameter& parameter : std::vector(app().document().info()->parameters)) {
        // What is shown of a file has tests of its own.
        const bool others =
            parameter.section == "what is shown" || parameter.section == "building" ||
            parameter.path.ends_with("/building") || parameter.path.ends_with("/material");
        if (!parameter.path.starts_with(part) || others || !done.insert(parameter.path).second)
          continue;
        expectChange(parameter, shown);
        more = true;
        break;  // the list may be another by now
      }
    }
    EXPECT_GT(done.size(), given);
  }

  void saveAs(const std::string& name) {
    ASSERT_TRUE(script_->write("scene", folder_.path(name)));
    EXPECT_EQ(app().settings().sceneName, folder_.path(name));
    if (!app().playback().timeline().playing()) {
      ASSERT_TRUE(script_->settle());  // what is kept is the exposure of a finished picture
    }
    ASSERT_TRUE(script_->click("Save scene"));
    load();
    EXPECT_EQ(app().document().error(), "");
    ASSERT_TRUE(std::filesystem::exists(folder_.path(name)));
  }

  void expectTheSameAfter(const std::string& name) {
    const auto before = app().document().info()->parameters;
    const ViewLook look = app().settings().look;
    const Vec3 eye = app().view().camera().eye();
    const Image shown = picture();
    app().settings().look = {};
    app().open(folder_.path(name));
    load();
    ASSERT_EQ(app().document().error(), "");
    const auto after = app().document().info()->parameters;
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(before[i].path, after[i].path);
      EXPECT_EQ(before[i].value, after[i].value) << before[i].path;
    }
    EXPECT_EQ(app().settings().look.stops, look.stops);
    EXPECT_EQ(app().settings().look.quality, look.quality);
    EXPECT_LT((app().view().camera().eye() - eye).norm(), 1e-9);
    EXPECT_LT(difference(shown, picture()), 0.02);
  }

  int pictureWidth_ = 120, pictureHeight_ = 90;
  SceneFolder folder_;
  std::chrono::seconds clock_{2};  ///< by which the next file that is replaced is younger
  std::unique_ptr<HeadlessViewer> viewer_;
  std::unique_ptr<ViewerScript> script_;
};

/// In a window whose middle is beside the panels, which show all that they have.
class WideControls : public Controls {
 protected:
  static constexpr int kWide = 900, kTall = 1500;

  void SetUp() override {
    Controls::SetUp();
    if (!script_)
      return;
    script_->input().width = kWide, script_->input().height = kTall;
  }
};

}  // namespace volute
