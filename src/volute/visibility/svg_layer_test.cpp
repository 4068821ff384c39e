// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/svg_layer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace volute {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

Result<SvgLayer> layerOf(const std::string& text, const std::string& layer = "Rooms") {
  const auto file = std::filesystem::path(::testing::TempDir()) / "layer.svg";
  std::ofstream(file) << text;
  return readSvgLayer(file, layer);
}

void expectOutline(const PlanOutline& outline, const std::vector<Vec2>& points) {
  ASSERT_EQ(outline.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR((outline.points[i] - points[i]).norm(), 0, 1e-9) << i;
}

constexpr const char* kPlan =
    "<?xml version='1.0'?>\n<!-- a plan --><!DOCTYPE svg>\n"
    "<svg xmlns='x' width='200mm' height='100mm' viewBox='0 0 20 10'>\n"
    "<g id='layer1' inkscape:label='rooms'>\n"
    "<g transform='translate(1,2) scale(2)'><rect id='r1' x='0' y='0' width='1' height='2'/></g>\n"
    "<path inkscape:label='Lobby &amp; stairs' d='M10 0h5v5.5-.5H10z m0,6 4,0 0,2'/>\n"
    "<polygon points='0,8 2,8 2,10'/><polyline points='3,8 4,8 4,9 3,8'/><circle r='1'/>\n"
    "<path d='M0 0C1 1 2 2 3 3z'/><text x='2' y='4'><tspan>Office</tspan></text></g>\n"
    "<g id='walls'><rect width='9' height='9'/></g></svg>\n";

TEST(SvgLayer, ClosedStraightLinesAreOutlinesInSharesOfThePicture) {
  const auto layer = layerOf(kPlan);
  ASSERT_TRUE(layer) << layer.error().message;
  ASSERT_THAT(layer->outlines, SizeIs(4));
  expectOutline(layer->outlines[0], {{0.05, 0.8}, {0.15, 0.8}, {0.15, 0.4}, {0.05, 0.4}});
  EXPECT_EQ(layer->outlines[0].name, "");
  EXPECT_EQ(layer->outlines[0].where, "line 5");
  expectOutline(layer->outlines[1], {{0.5, 1}, {0.75, 1}, {0.75, 0.45}, {0.75, 0.5}, {0.5, 0.5}});
  EXPECT_EQ(layer->outlines[1].name, "Lobby & stairs");
  expectOutline(layer->outlines[3], {{0.15, 0.2}, {0.2, 0.2}, {0.2, 0.1}, {0.15, 0.2}});
  EXPECT_EQ(layer->open, 1) << "the path's second part";
  EXPECT_EQ(layer->curved, 2);
  ASSERT_THAT(layer->texts, SizeIs(1));
  EXPECT_EQ(layer->texts[0].second, "Office");
  EXPECT_NEAR(layer->texts[0].first.x(), 0.1, 1e-9);
  EXPECT_NEAR(layer->texts[0].first.y(), 0.6, 1e-9);
  EXPECT_THAT(layerOf(kPlan, "LAYER1")->outlines, SizeIs(4)) << "by its id";
}

TEST(SvgLayer, WhatIsNotUnderstoodIsRefused) {
  EXPECT_THAT(layerOf(kPlan, "Zones").error().message,
              HasSubstr("no group is labelled 'zones'; it has 'layer1', 'rooms', 'walls'"));

  const struct {
    const char *text, *says;
  } wrong[] = {{"<svg viewBox='0 0 1 1'><g id='rooms'><path d='M0 0 L x'/></g></svg>",
                "line 1: a path that is not understood"},
               {"<svg viewBox='0 0 1 1'><g id='rooms' transform='skewX(3)'/></svg>",
                "transform 'skewX' is not read"},
               {"<svg viewBox='0 0 1 1' width='3' height='1'></svg>", "of another shape"},
               {"<svg><g id='rooms'/></svg>", "no element 'svg' with a size"},
               {"<svg viewBox='0 0 1 1'><g id='rooms'>", "ends within an element"},
               {"<svg viewBox='0 0 1 1'></g></svg></svg>", "ends that did not begin"},
               {"<svg viewBox='0 0 1 1' id></svg>", "without a value in quotes"}};

  for (const auto& one : wrong) {
    const auto layer = layerOf(one.text);
    ASSERT_FALSE(layer) << one.text;
    EXPECT_THAT(layer.error().message, HasSubstr(one.says));
  }
  // Every cut ends in an error, not in areas that are not there.
  const std::string plan = kPlan;
  for (std::size_t size = 0; size + 2 < plan.size(); ++size)
    EXPECT_FALSE(layerOf(plan.substr(0, size))) << size;
}

}  // namespace
}  // namespace volute
