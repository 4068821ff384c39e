// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog is painted: what each tool and each setting of the brush does to the map and to the picture.
#include <numeric>

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

}  // namespace
}  // namespace volute
