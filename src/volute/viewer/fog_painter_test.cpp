// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/fog_painter.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr double kMax = 0.04, kCell = 2;

FogPainter painterOf(int columns = 20, int rows = 14, int degree = 1) {
  return {SplineGrid(columns, rows), Vec2(-4, 6), kCell, degree, kMax};
}

TEST(FogBrush, FadesFromTheMiddleToTheRim) {
  FogBrush brush{.radius = 8, .softness = 1};
  EXPECT_EQ(brush.weight(0), 1);
  EXPECT_DOUBLE_EQ(brush.weight(4), 0.5);
  EXPECT_EQ(brush.weight(8), 0);
  brush.softness = 0;
  EXPECT_EQ(brush.weight(7.9), 1);
  EXPECT_EQ(brush.weight(8), 0);
}

TEST(FogPainter, AddsWhatTheBrushSays) {
  FogPainter painter = painterOf();
  const FogPlace place{7, 5};
  const Vec2 at = painter.peakOf(place);
  EXPECT_EQ(at, Vec2(-4 + 2 * 8, 6 + 2 * 6)) << "degree 1 peaks one cell after its index";
  const FogBrush brush{.radius = 6, .strength = 0.25, .softness = 1};
  ASSERT_TRUE(painter.paint(brush, at, at, 0.5));
  for (int j = 0; j < 14; ++j) {
    for (int i = 0; i < 20; ++i) {
      const double expected =
          0.25 * 0.5 * kMax * brush.weight((painter.peakOf({i, j}) - at).norm());
      EXPECT_NEAR(painter.valueOf({i, j}), expected, 1e-15) << i << ", " << j;
    }
  }
}

TEST(FogPainter, FindsTheNearestCoefficient) {
  const FogPainter painter = painterOf();
  EXPECT_EQ(painter.nearest(painter.peakOf({3, 9}) + Vec2(0.9, -0.9)), (FogPlace{3, 9}));
  EXPECT_EQ(painter.nearest(Vec2(-4, 6)), (FogPlace{0, 0})) << "before the first peak";
  EXPECT_FALSE(painter.nearest(Vec2(-4.1, 6)));
}

TEST(FogPainter, OneCoefficientIsClamped) {
  FogPainter painter = painterOf();
  EXPECT_TRUE(painter.set({2, 2}, 0.01));
  EXPECT_EQ(painter.valueOf({2, 2}), 0.01);
  EXPECT_FALSE(painter.set({2, 2}, 0.01));
  painter.set({2, 2}, 7);
  EXPECT_EQ(painter.valueOf({2, 2}), kMax);
  painter.set({2, 2}, -7);
  EXPECT_EQ(painter.valueOf({2, 2}), 0);
}

TEST(FogPainter, SmoothingKeepsAPlaneAndLowersAPeak) {
  FogPainter painter = painterOf();
  for (int j = 0; j < 14; ++j)
    for (int i = 0; i < 20; ++i) painter.set({i, j}, 0.001 * (i + j));
  const FogBrush smooth{.kind = FogBrush::Kind::kSmooth, .radius = 6, .strength = 1, .softness = 0};
  const Vec2 at = painter.peakOf({9, 6});
  painter.paint(smooth, at, at, 1);
  EXPECT_NEAR(painter.valueOf({9, 6}), 0.015, 1e-15);
  painter.set({9, 6}, kMax);
  painter.paint(smooth, at, at, 1);
  EXPECT_NEAR(painter.valueOf({9, 6}), kMax / 4 + 0.75 * 0.015, 1e-15) << "weights 1 2 1";
}

TEST(FogPainter, AStrokeIsUndoneAsOne) {
  FogPainter painter = painterOf();
  painter.begin();
  painter.paint({.radius = 5}, Vec2(0, 10), Vec2(20, 20), 1);
  painter.paint({.radius = 5}, Vec2(20, 20), Vec2(30, 10), 1);
  painter.end();
  EXPECT_TRUE(painter.changed());
  EXPECT_TRUE(painter.undo());
  EXPECT_FALSE(painter.changed());
  EXPECT_TRUE(std::ranges::all_of(painter.coefficients().c, [](double v) { return v == 0; }));
  EXPECT_FALSE(painter.undo());
}

TEST(FogPainter, KnowsWhatIsSaved) {
  FogPainter painter = painterOf();
  painter.set({1, 1}, 0.01);
  painter.markSaved(painter.version());
  EXPECT_FALSE(painter.changed());
  painter.undo();
  EXPECT_TRUE(painter.changed());
  painter.redo();
  EXPECT_FALSE(painter.changed());
  painter.undo();
  painter.set({1, 1}, 0.02);
  EXPECT_TRUE(painter.changed()) << "another future than the saved one";
}

TEST(FogPainter, ThePictureHasItsTopAtTheLargestY) {
  FogPainter painter = painterOf();
  painter.set({4, 13}, kMax / 2);
  const Image picture = painter.picture();
  EXPECT_EQ(picture.at(4, 0), 0.5F);
  const auto map = FogMap::fromImage(picture, {Vec3(-4, 6, 0), kCell, kMax});
  ASSERT_TRUE(map);
  for (std::size_t k = 0; k < painter.coefficients().c.size(); ++k)
    EXPECT_NEAR(map->coefficients.c[k], painter.coefficients().c[k], 1e-9);
}

TEST(FogPainter, StandsWhereTheFogStands) {
  SplineGrid grid(9, 7);
  grid.at(4, 3) = 0.02;
  for (int levels = 0; levels <= 2; ++levels) {
    const auto map = FogMap::fromCoefficients(grid, {Vec3(10, 20, 0), 3, kMax});
    const auto fog =
        FogMedium::make(*map, *FogProfile::slab(0, 5), {.degree = 2, .levels = levels});
    const FogPainter painter(fog->shifted(Vec3(1, 2, 0)), kMax);
    EXPECT_LT((painter.origin() - Vec2(11, 22)).norm(), 1e-9);
    EXPECT_EQ(painter.coefficients().c, grid.c);
    const Vec2 at = painter.peakOf({4, 3});
    EXPECT_NEAR(fog->extinction(Vec3(at.x() - 1, at.y() - 2, 1)), 0.02 * 0.75 * 0.75, 1e-12);
  }
}

/// 48 x 32 m of fog that the wind has moved by 36 m: what left came in on the other side.
TEST(FogPainter, PaintsWhatIsShownWhereTheWindBringsItIn) {
  FogPainter painter(SplineGrid(12, 8), Vec2::Zero(), 4, 1, kMax);
  painter.blow({Vec2(36, 0), FogBorder::kRepeat});
  const Vec2 at(20, 16);
  EXPECT_EQ(painter.nearest(at), (FogPlace{7, 3})) << "which peaks at 32 m in calm air";
  EXPECT_EQ(painter.blown(painter.peakOf({7, 3})), at);
  ASSERT_TRUE(painter.paint({.radius = 3}, at, at, 1));
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 12; ++i)
      EXPECT_EQ(painter.valueOf({i, j}) > 0, i == 7 && j == 3) << i << ", " << j;
  }
  EXPECT_FALSE(painter.nearest(Vec2(58, 16))) << "nothing is shown there";
  EXPECT_FALSE(painter.paint({.radius = 3}, Vec2(58, 16), Vec2(58, 16), 1));
  const auto around = painter.around(at, 1);
  ASSERT_EQ(around.size(), 9U);
  EXPECT_EQ(around[4].place, (FogPlace{7, 3}));
  EXPECT_EQ(around[4].at, at);
  painter.blow({Vec2(36, 0), FogBorder::kZero});
  EXPECT_FALSE(painter.nearest(at)) << "clear air";
  EXPECT_EQ(painter.nearest(Vec2(36 + 20, 16)), (FogPlace{4, 3}));
}

TEST(FogPainter, ValuesAreSharesOfTheLargest) {
  FogPainter painter = painterOf();
  painter.set({4, 4}, 0.01);
  painter.set({5, 4}, 0.03);
  painter.undo();
  painter.rescale(2 * kMax, 3);
  EXPECT_EQ(painter.most(), 2 * kMax);
  EXPECT_EQ(painter.cell(), 3);
  EXPECT_DOUBLE_EQ(painter.valueOf({4, 4}), 0.02);
  ASSERT_TRUE(painter.redo());
  EXPECT_DOUBLE_EQ(painter.valueOf({5, 4}), 0.06);
  ASSERT_TRUE(painter.undo() && painter.undo());
  EXPECT_EQ(painter.valueOf({4, 4}), 0);
  EXPECT_FALSE(painter.changed());
}

RC_GTEST_PROP(FogPainterProperty, UndoAndRedoWalkTheSameWay, ()) {
  FogPainter painter =
      painterOf(*rc::gen::inRange(1, 30), *rc::gen::inRange(1, 30), *rc::gen::inRange(0, 4));
  std::vector<std::vector<double>> states{painter.coefficients().c};
  const int strokes = *rc::gen::inRange(1, 12);
  for (int s = 0; s < strokes; ++s) {
    const auto somewhere = [&] {
      return Vec2(*rc::gen::inRange(-10, 60), *rc::gen::inRange(0, 50));
    };
    const FogBrush brush{
        *rc::gen::element(FogBrush::Kind::kAdd, FogBrush::Kind::kRemove, FogBrush::Kind::kSmooth),
        0.5 + *rc::gen::inRange(0, 20), 0.1 * *rc::gen::inRange(1, 20),
        0.1 * *rc::gen::inRange(0, 11)};
    painter.paint(brush, somewhere(), somewhere(), 0.3);
    for (const double value : painter.coefficients().c) RC_ASSERT(value >= 0 && value <= kMax);
    if (painter.coefficients().c != states.back())
      states.push_back(painter.coefficients().c);
  }
  for (std::size_t i = states.size() - 1; i > 0; --i) {
    RC_ASSERT(painter.undo());
    RC_ASSERT(painter.coefficients().c == states[i - 1]);
  }
  RC_ASSERT(!painter.canUndo());
  for (std::size_t i = 1; i < states.size(); ++i) {
    RC_ASSERT(painter.redo());
    RC_ASSERT(painter.coefficients().c == states[i]);
  }
  RC_ASSERT(!painter.canRedo());
}

}  // namespace
}  // namespace volute
