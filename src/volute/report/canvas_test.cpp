// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/canvas.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace volute {
namespace {

using testing::HasSubstr;

TEST(Canvas, drawsTheSameIntoPixelsAndVectors) {
  const Rgb red(1, 0, 0), blue(0, 0, 1);
  Image image(40, 30, 3);
  SvgCanvas svg(40, 30);
  const auto pixels = imageCanvas(image);
  for (Canvas* canvas : {pixels.get(), static_cast<Canvas*>(&svg)}) {
    canvas->rect(0, 0, 40, 30, Rgb::Ones());
    canvas->rect(10, 5, 20, 15, red);
    canvas->triangle({25, 5}, {35, 5}, {25, 25}, blue);
  }
  EXPECT_EQ(image.at(15, 10, 0), 1);
  EXPECT_EQ(image.at(15, 10, 1), 0);
  EXPECT_EQ(image.at(20, 10, 1), 1) << "the end does not belong to it";
  EXPECT_EQ(image.at(27, 7, 0), 0);
  EXPECT_EQ(image.at(34, 20, 0), 1) << "beyond the longest side";
  const std::string file = svg.finish();
  EXPECT_THAT(file,
              HasSubstr("<rect x='10.00' y='5.00' width='10.00' height='10.00' fill='#ff0000'/>"));
  EXPECT_THAT(file, HasSubstr("points='25.00,5.00 35.00,5.00 25.00,25.00' fill='#0000ff'"));
}

TEST(Canvas, hatchesAreInStepFromRectangleToRectangle) {
  Image whole(64, 16, 1), parts(64, 16, 1);
  imageCanvas(whole)->hatch(0, 0, 64, 16, Rgb::Ones());
  const auto canvas = imageCanvas(parts);
  canvas->hatch(0, 0, 32, 16, Rgb::Ones());
  canvas->hatch(32, 0, 64, 16, Rgb::Ones());
  int inked = 0;
  for (int y = 2; y < 14; ++y) {
    for (int x = 2; x < 62; ++x) {
      inked += whole.at(x, y) > 0.5F;
      if (x < 29 || x > 35) {
        EXPECT_NEAR(whole.at(x, y), parts.at(x, y), 1e-5) << x << ", " << y;
      }
    }
  }
  EXPECT_GT(inked, 60);
  EXPECT_LT(inked, 360);
}

TEST(Canvas, textOfVectorsIsEscaped) {
  SvgCanvas svg(10, 10);
  svg.text("a < b & c", 0, 0, Rgb::Zero(), Canvas::Anchor::kEnd);
  EXPECT_THAT(svg.finish(), HasSubstr("text-anchor='end'>a &lt; b &amp; c</text>"));
}

}  // namespace
}  // namespace volute
