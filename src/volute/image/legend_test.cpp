// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/legend.hpp"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "volute/image/text.hpp"

namespace volute {
namespace {

using Sizes = std::vector<std::pair<int, int>>;

const std::vector<std::string> kLines{"slice of local visibility", "S = C / K, C = 3, at z = 1.8 m",
                                      "soot-density [g/m3]", "Km = 8700 m2/kg", "t = 70.00 s"};
const ColorScale kScale{ColorMap::kViridis, 30, 0, "m or more"};

std::string wordsIn(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, " "));
}

TEST(Legend, FitsIntoPicturesOfEverySize) {
  const Sizes sizes{{3840, 2160}, {1920, 1080}, {800, 600}, {400, 300}, {400, 1200},
                    {320, 200},   {240, 180},   {200, 900}, {160, 120}, {96, 64},
                    {40, 40},     {24, 400},    {8, 8},     {1, 1}};
  for (const auto& [width, height] : sizes) {
    for (const bool bar : {false, true}) {
      const auto layout =
          layOutLegend(width, height, kLines, bar ? std::optional(kScale) : std::nullopt);
      if (layout.width == 0)
        continue;
      EXPECT_GE(layout.x, 0) << width;
      EXPECT_GE(layout.y, 0) << width;
      EXPECT_LE(layout.x + layout.width, width);
      EXPECT_LE(layout.y + layout.height, height);
      EXPECT_LT(layout.barWidth, layout.width);
      for (const std::string& line : layout.lines)
        EXPECT_LT(textSize(line, TextStyle::ofDots(layout.dot)).width, layout.width)
            << width << ": " << line;
    }
  }
}

TEST(Legend, SmallPicturesLoseNoWords) {
  for (const auto& [width, height] :
       Sizes{{1920, 1080}, {400, 300}, {240, 180}, {160, 120}, {200, 900}}) {
    const auto layout = layOutLegend(width, height, kLines, kScale);
    EXPECT_EQ(wordsIn(layout.lines), wordsIn(kLines)) << width;
    EXPECT_GT(layout.barWidth, 0) << width;
  }
  EXPECT_EQ(layOutLegend(400, 300, kLines, kScale).lines, kLines);
  EXPECT_EQ(layOutLegend(1920, 1080, kLines, kScale).dot, 3);
  EXPECT_EQ(layOutLegend(200, 900, kLines, kScale).dot, 1);
}

TEST(Legend, WordsThatAreTooLongAreCut) {
  const auto layout = layOutLegend(64, 200, {"a photometric-picture"}, std::nullopt);
  EXPECT_EQ(layout.lines, (std::vector<std::string>{"a", "photomet", "ric-pict", "ure"}));
}

TEST(Legend, IsDrawnOntoItsGroundAlone) {
  for (const auto& [width, height] : Sizes{{400, 300}, {200, 150}, {96, 64}}) {
    Image image(width, height, 3);
    std::ranges::fill(image.pixels, 1.0F);
    const auto layout = layOutLegend(width, height, kLines, kScale);
    drawLegend(image, kLines, kScale);
    int ink = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool inside = x >= layout.x && x < layout.x + layout.width && y >= layout.y &&
                            y < layout.y + layout.height;
        EXPECT_EQ(image.at(x, y, 0) != 1, inside) << x << ", " << y;
        ink += image.at(x, y, 0) > 0.3F;
        // A margin remains around the letters.
        if (inside && (x < layout.x + 3 || x >= layout.x + layout.width - 3)) {
          EXPECT_EQ(image.at(x, y, 0), 0.08F);
        }
      }
    }
    EXPECT_GT(ink, 100);
  }
}

}  // namespace
}  // namespace volute
