// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog is painted: what each tool and each setting of the brush does to the map and to the picture.
#include <nlohmann/json.hpp>
#include <numeric>

#include "volute/base/read_text.hpp"
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

class PaintControls : public Controls {
 protected:
  using Map = std::vector<double>;

  static constexpr int kWidth = 1000, kHeight = 1100;  ///< the ground is seen beside the panel

  void unfold(const std::string& name) {
    script_->input().width = kWidth, script_->input().height = kHeight;
    open(name);
    ASSERT_NO_FATAL_FAILURE(openPaintPanel());
  }

  const FogPainter& painter() { return app().tools().painting.tool().painter(); }

  const Map& map() { return painter().coefficients().c; }

  /// Without what is drawn around the hand.
  Image fog() {
    const bool painting = std::exchange(app().settings().painting, false);
    Image image = picture();
    app().settings().painting = painting;
    return image;
  }

  /// In the plan.
  void stroke() {
    ASSERT_TRUE(script_->dragFrom("plan", 0.6, 0.5, 20, 0, 12));
    load();
  }

  /// `act` changes the map and the picture.
  template <class Act>
  void expectPainted(const std::string& what, Act&& act) {
    SCOPED_TRACE(what);
    const Image shown = fog();
    const Map before = map();
    act();
    load();
    EXPECT_EQ(app().document().error(), "");
    EXPECT_NE(map(), before);
    EXPECT_GT(difference(shown, fog()), 0.0005);
  }

  /// A scene of fogs of these maps, one beside the other; more members of each as JSON.
  void writeFogs(const std::string& name, const std::vector<std::string>& maps,
                 const std::string& more = "{}") {
    nlohmann::json scene = {
        {"format", "volute-scene-2"},
        {"camera", {{"eye", {-9, -12, 11}}, {"target", {7, 5, 0}}, {"fov", 45}}}};
    for (std::size_t i = 0; i < maps.size(); ++i) {
      nlohmann::json fog = {{"kind", "fog"},
                            {"map", maps[i]},
                            {"cell", 1},
                            {"origin", {9 * static_cast<int>(i), 0, 0}},
                            {"sigma_max", 0.4},
                            {"degree", 1},
                            {"profile", {{"kind", "slab"}, {"bottom", 0}, {"top", 4}}}};
      fog.update(nlohmann::json::parse(more));
      scene["media"].push_back(std::move(fog));
    }
    std::ofstream(folder_.path(name)) << scene.dump();
  }

  FogPainting& painting() { return app().tools().painting; }

  void take(const std::string& tool) {
    ASSERT_TRUE(script_->click("tool " + tool, 0.1)) << tool;
    script_->frames(2);
  }

  void press(const std::string& control) {
    ASSERT_TRUE(script_->click(control)) << control;
    load();
  }

  /// The map was saved as `file` and read again.
  void expectReadAgain(const std::string& file) {
    const Map painted = map();
    const Image shown = fog();
    ASSERT_TRUE(script_->write("map", folder_.path(file)));
    press("Save map");
    EXPECT_EQ(app().document().error(), "");
    EXPECT_FALSE(app().tools().painting.unsaved());
    saveAs("painted.json");
    app().open(folder_.path("painted.json"));
    load();
    ASSERT_TRUE(app().tools().painting.tool().has());
    ASSERT_EQ(map().size(), painted.size());
    for (std::size_t i = 0; i < painted.size(); ++i)
      EXPECT_NEAR(map()[i], painted[i], 0.4 * 0.51 / 65535) << i;
    EXPECT_LT(difference(shown, fog()), 0.02);
  }
};

TEST_F(PaintControls, EachSettingOfTheBrushChangesTheStroke) {
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  const Map begun = map();
  ASSERT_NO_FATAL_FAILURE(stroke());
  Map painted = map();
  Image shown = fog();
  ASSERT_NE(painted, begun);

  const struct {
    const char* control;
    double across;
  } kSettings[] = {{"brush strength", 0.62}, {"brush size", 0.6}, {"brush softness", 0.05}};

  for (const auto& [control, across] : kSettings) {
    SCOPED_TRACE(control);
    press("Undo");
    ASSERT_EQ(map(), begun);
    ASSERT_TRUE(script_->click(control, across));
    ASSERT_NO_FATAL_FAILURE(stroke());
    EXPECT_NE(map(), painted);
    EXPECT_GT(std::accumulate(map().begin(), map().end(), 0.0),
              std::accumulate(painted.begin(), painted.end(), 0.0))
        << "stronger, wider, harder: more fog";
    Image now = fog();
    EXPECT_GT(difference(shown, now), 0.0005);
    painted = map(), shown = std::move(now);
  }
  expectReadAgain("brushed.png");
}

TEST_F(PaintControls, EachToolChangesTheMapInItsWay) {
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  ASSERT_TRUE(script_->click("brush strength", 0.62));
  const auto sum = [&] { return std::accumulate(map().begin(), map().end(), 0.0); };
  const auto roughness = [&] {
    double squares = 0;
    const SplineGrid& grid = painter().coefficients();
    for (int j = 0; j < grid.rows; ++j) {
      for (int i = 1; i < grid.columns; ++i)
        squares += std::pow(grid.at(i, j) - grid.at(i - 1, j), 2);
    }
    return squares;
  };
  double fogThere = sum();
  take("remove");
  expectPainted("remove", [&] { stroke(); });
  EXPECT_LT(sum(), fogThere);
  fogThere = sum();
  take("add");
  expectPainted("add", [&] { stroke(); });
  EXPECT_GT(sum(), fogThere);
  const double rough = roughness();
  take("smooth");
  expectPainted("smooth", [&] { stroke(); });
  EXPECT_LT(roughness(), rough);
  take("coefficient");
  const Map before = map();
  expectPainted("coefficient", [&] { EXPECT_TRUE(script_->dragFrom("plan", 0.2, 0.8, 0, -60)); });
  std::vector<double> changes;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (map()[i] != before[i])
      changes.push_back(map()[i] - before[i]);
  }
  ASSERT_EQ(changes.size(), 1U) << "one coefficient";
  EXPECT_NEAR(changes[0], 60.0 / 200 * painter().most(), 1e-6) << "200 pixels for the densest fog";
  expectPainted("down again", [&] { EXPECT_TRUE(script_->dragFrom("plan", 0.2, 0.8, 0, 30)); });
  expectReadAgain("tools.png");
  expectPainted("Clear", [&] { press("Clear"); });
  EXPECT_EQ(sum(), 0);
  expectPainted("Undo", [&] { press("Undo"); });
  expectPainted("Redo", [&] { press("Redo"); });
  expectReadAgain("clear.png");
}

TEST_F(PaintControls, NothingMovesUnderTheHand) {
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  take("coefficient");  // which a hand that is still does not change
  const auto top = [&] { return app().window().controls().at("plan").top; };
  const double begun = top();
  double x = 0, y = 0;
  ASSERT_TRUE(script_->pointOf("plan", 0.5, 0.5, x, y));
  script_->move(x, y);
  script_->hold(0, true);
  app().open(folder_.path("nowhere.json"));
  load();
  ASSERT_NE(app().document().error(), "");
  EXPECT_EQ(top(), begun);
  script_->hold(0, false);
  script_->frames(4);
  EXPECT_EQ(top(), begun) << "an error stands on the picture";
  ASSERT_EQ(app().settings().alerts.size(), 1U);
  EXPECT_EQ(app().settings().alerts[0].text, app().document().error());
}

TEST_F(PaintControls, FogIsPaintedOnTheGround) {
  ASSERT_NO_FATAL_FAILURE(unfold("fog.json"));
  const Map begun = map();
  ASSERT_TRUE(script_->click("brush size", 0.6));
  ASSERT_TRUE(script_->click("brush strength", 0.6));
  ASSERT_TRUE(script_->click("paint in the view", 0.05));
  ASSERT_TRUE(app().settings().painting);
  const auto ground = app().view().camera().camera(kWidth, kHeight).project(Vec3(8, 6, 0));
  ASSERT_TRUE(ground);
  const double x = ground->x(), y = ground->y();
  const auto place = painter().nearest(Vec2(8, 6));
  ASSERT_TRUE(place);
  const Vec3 eye = app().view().camera().eye();
  const auto stroke = [&] { script_->drag(x - 20, y, x + 20, y, 0, 12); };
  const auto value = [&] { return painter().valueOf(*place); };
  double low = value();
  take("coefficient");
  expectPainted("coefficient", [&] { script_->drag(x, y, x, y - 60); });
  EXPECT_NEAR(value(), std::min(low + 60.0 / 200 * painter().most(), painter().most()),
              0.05 * painter().most());
  take("remove");
  expectPainted("remove", stroke);
  EXPECT_LT(value(), low + 0.3 * painter().most());
  low = value();
  take("add");
  expectPainted("add", stroke);
  EXPECT_GT(value(), low);
  take("smooth");
  expectPainted("smooth", stroke);
  const Map last = map();
  expectPainted("Ctrl Z", [&] { script_->press(Key::kZ, true); });
  expectPainted("Ctrl Y", [&] { script_->press(Key::kY, true); });
  EXPECT_EQ(map(), last);
  expectPainted("Ctrl Z", [&] { script_->press(Key::kZ, true); });
  script_->input().shift = true;
  expectPainted("Ctrl Shift Z", [&] { script_->press(Key::kZ, true); });
  script_->input().shift = false;
  EXPECT_EQ(map(), last);
  EXPECT_EQ(app().view().camera().eye(), eye) << "the left button paints";
  script_->drag(x, y, x + 40, y + 10, 1);
  EXPECT_GT((app().view().camera().eye() - eye).norm(), 0.1) << "the right one turns";
  EXPECT_EQ(map(), last);
  script_->press(Key::kEscape);
  EXPECT_FALSE(app().settings().painting);
  expectReadAgain("ground.png");
  EXPECT_NE(map(), begun);
}

TEST_F(PaintControls, FogThatBlowsIsPaintedUnderTheHand) {
  writeFogs("blown.json", {"map.png"}, R"({"wind": [1, 0]})");
  ASSERT_NO_FATAL_FAILURE(unfold("blown.json"));
  app().playback().timeline().seek(7);
  load();
  ASSERT_TRUE(script_->click("paint in the view", 0.05));
  const auto ground = app().view().camera().camera(kWidth, kHeight).project(Vec3(8, 6, 0));
  ASSERT_TRUE(ground);
  ASSERT_TRUE(script_->click("brush strength", 0.62));
  const Map before = map();
  expectPainted("add",
                [&] { script_->drag(ground->x(), ground->y(), ground->x(), ground->y(), 0, 12); });
  std::size_t most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (map()[i] - before[i] > map()[most] - before[most])
      most = i;
  }
  const int column = static_cast<int>(most) % 14, row = static_cast<int>(most) / 14;
  EXPECT_NEAR((column + 7) % 14, 7.5, 0.6) << "what is in the middle of its cell there";
  EXPECT_NEAR(row, 5.5, 0.6);
}

TEST_F(PaintControls, AStrokeOnThePlanIsOneThoughTheViewIsPaintedToo) {
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  ASSERT_TRUE(script_->click("paint in the view", 0.05));
  const Map begun = map();
  ASSERT_NO_FATAL_FAILURE(stroke());
  ASSERT_NE(map(), begun);
  press("Undo");
  EXPECT_EQ(map(), begun);
}

TEST_F(PaintControls, StrokesAreUndoneWhateverTheMapsScale) {
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  const Map begun = map();
  ASSERT_NO_FATAL_FAILURE(stroke());
  const Map painted = map();
  app().document().set(parameterAt("/media/0/sigma_max"), {0.8});
  load();
  ASSERT_EQ(map().size(), painted.size());
  for (std::size_t i = 0; i < painted.size(); ++i) EXPECT_DOUBLE_EQ(map()[i], 2 * painted[i]);
  app().document().set(parameterAt("/media/0/cell"), {1.5});
  load();
  EXPECT_EQ(painter().cell(), 1.5);
  for (int i = 0; i < 3; ++i) {
    script_->press(Key::kZ, true);
    load();
  }
  EXPECT_EQ(valueOf("/media/0/cell")[0], 1);
  EXPECT_EQ(valueOf("/media/0/sigma_max")[0], 0.4);
  for (std::size_t i = 0; i < begun.size(); ++i) EXPECT_NEAR(map()[i], begun[i], 1e-12);
  EXPECT_FALSE(painting().unsaved());
  const Parameter densest = parameterAt("/media/0/sigma_max");
  app().document().set(densest, {0});
  load();
  EXPECT_FALSE(painting().tool().has()) << "there is no fog to paint";
  app().document().set(densest, {0.4});
  load();
  script_->frames(5);
  press("Redo");
  for (std::size_t i = 0; i < painted.size(); ++i) EXPECT_NEAR(map()[i], painted[i], 1e-12);
}

TEST_F(PaintControls, WhatAPictureHoldsBesidesIsNotReplacedUnasked) {
  Image colour(14, 10, 3);
  for (std::size_t i = 0; i < colour.pixels.size(); ++i)
    colour.pixels[i] = 0.02F * static_cast<float>(i % 37);
  ASSERT_TRUE(writeImage(folder_.path("colour.png"), colour));
  const std::vector<float> some(14 * 10, 0.5F);
  ASSERT_TRUE(writeChannels(folder_.path("clear.exr"), 14, 10, {{"Y", some}, {"A", some}}));
  for (const std::string name : {"colour", "clear"}) {
    SCOPED_TRACE(name);
    const std::string ext = name == "clear" ? ".exr" : ".png";
    const std::string file = folder_.path(name + ext);
    const std::string before = *readText(file);
    writeFogs(name + ".json", {name + ext}, R"({"convert": "luma"})");
    ASSERT_NO_FATAL_FAILURE(unfold(name + ".json"));
    EXPECT_EQ(app().settings().mapName, folder_.path(name + "_grey" + ext));
    ASSERT_NO_FATAL_FAILURE(stroke());
    ASSERT_TRUE(script_->write("map", file));
    press("Save map");
    ASSERT_TRUE(app().document().files().replacing());
    EXPECT_NE(app().document().files().replacing()->loses, "");
    ASSERT_TRUE(script_->click("keep"));
    load();
    EXPECT_EQ(*readText(file), before);
    EXPECT_TRUE(painting().unsaved());
    ASSERT_TRUE(script_->write("map", folder_.path(name + "_grey" + ext)));
    press("Save map");
    EXPECT_EQ(app().document().error(), "");
    EXPECT_FALSE(painting().unsaved());
    EXPECT_EQ(*readText(file), before);
    EXPECT_TRUE(std::filesystem::exists(folder_.path(name + "_grey" + ext)));
    EXPECT_TRUE(app().document().info()->changed) << "the scene's file names the other map";
    // Alone it is what is open, and is asked about too.
    ASSERT_NO_FATAL_FAILURE(unfold(name + ext));
    EXPECT_EQ(app().settings().mapName, folder_.path(name + "_grey_2" + ext));
    ASSERT_NO_FATAL_FAILURE(stroke());
    ASSERT_TRUE(script_->write("map", file));
    press("Save map");
    ASSERT_TRUE(app().document().files().replacing());
    ASSERT_TRUE(script_->click("replace"));
    load();
    EXPECT_FALSE(painting().unsaved());
    EXPECT_NE(*readText(file), before);
    ASSERT_NO_FATAL_FAILURE(stroke());
    press("Save map");
    EXPECT_FALSE(painting().unsaved()) << "it is grey by now";
  }
}

TEST_F(PaintControls, EachFogOfASceneIsPainted) {
  const std::string map = *readText(folder_.path("map.png"));
  std::ofstream(folder_.path("second.png")) << map;
  writeFogs("fogs.json", {"map.png", "second.png", "map.png"});
  ASSERT_NO_FATAL_FAILURE(unfold("fogs.json"));
  EXPECT_EQ(painting().names(), (std::vector<std::string>{"map.png", "second.png", "map.png (2)"}));
  const Map begun = this->map();
  expectPainted("first", [&] { stroke(); });
  const Map first = this->map();
  ASSERT_TRUE(script_->choose("painted map", "second.png"));
  load();
  EXPECT_EQ(this->map(), begun);
  EXPECT_EQ(app().settings().mapName, folder_.path("second.png"));
  take("remove");
  expectPainted("second", [&] { stroke(); });
  const Map second = this->map();
  EXPECT_NE(second, first);
  press("Undo");
  EXPECT_EQ(this->map(), begun);
  press("Redo");
  ASSERT_TRUE(script_->choose("painted map", "map.png"));
  load();
  EXPECT_EQ(this->map(), first);
  press("Undo");
  EXPECT_EQ(this->map(), begun);
  EXPECT_TRUE(painting().unsaved()) << "the other is";
  press("Redo");

  // A fog of no density is none to paint; when it comes back it has what was painted.
  const Parameter densest = parameterAt("/media/1/sigma_max");
  app().document().set(densest, {0});
  load();
  ASSERT_EQ(painting().names().size(), 2U);
  EXPECT_EQ(this->map(), first);
  app().document().undo();
  load();
  ASSERT_EQ(painting().names().size(), 3U);
  EXPECT_EQ(app().document().info()->canvases[1].fog->levels().map().c, second);

  // Each is asked about.
  script_->close();
  script_->frames(3);
  ASSERT_TRUE(app().leaving().asked());
  EXPECT_EQ(app().settings().mapName, folder_.path("map.png"));
  ASSERT_TRUE(script_->click("leave discard"));
  script_->frames(3);
  ASSERT_TRUE(app().leaving().asked()) << "another is unsaved";
  EXPECT_EQ(app().settings().mapName, folder_.path("second.png"));
  ASSERT_TRUE(script_->click("leave save"));
  load();
  load();
  EXPECT_TRUE(app().leaving().ends());
  EXPECT_NE(*readText(folder_.path("second.png")), map);
  EXPECT_EQ(*readText(folder_.path("map.png")), map);
}

TEST_F(PaintControls, ItIsSaidThatNoFileHasWhatWasPainted) {
  const auto folder = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(folder_.path("x")).parent_path());
  ASSERT_NO_FATAL_FAILURE(unfold("dull.json"));
  const auto report = [&] {
    script_->press(Key::kF12, true);
    EXPECT_NE(app().report().job(), nullptr);
    const std::string page = app().report().job()->target().string();
    for (int i = 0; i < 2000 && app().report().job(); ++i) {
      script_->frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return *readText(page);
  };
  const char* const kPainted =
      "map.png: the fog painted on it, which the picture shows, is in no file";
  const char* const kChanged = "the scene is shown with changes that are in no file";
  std::string page = report();
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr(kPainted)));
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr(kChanged)));
  ASSERT_NO_FATAL_FAILURE(stroke());
  EXPECT_THAT(report(), ::testing::HasSubstr(kPainted));
  app().document().set(parameterAt("/media/0/sigma_max"), {0.2});
  load();
  EXPECT_THAT(report(), ::testing::HasSubstr(kChanged));
  saveAs("said.json");
  EXPECT_THAT(app().document().message(), ::testing::HasSubstr("map.png is not saved"));
  press("Save map");
  saveAs("said.json");
  EXPECT_THAT(app().document().message(), ::testing::Not(::testing::HasSubstr("not saved")));
  page = report();
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr("in no file")));
  std::filesystem::current_path(folder);
}

}  // namespace
}  // namespace volute
