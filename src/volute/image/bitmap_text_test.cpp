// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/bitmap_text.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace volute {
namespace {

std::vector<float> drawn(std::string_view text, int scale = 1) {
  const TextSize size = textSize(text, scale);
  Image image(size.width, size.height, 1);
  drawText(image, text, 0, 0, scale, Rgb::Ones());
  return image.pixels;
}

TEST(BitmapText, DrawsEachLetterInItsOwnWay) {
  std::set<std::vector<float>> shapes;
  for (char letter = ' '; letter <= '~'; ++letter) shapes.insert(drawn(std::string(1, letter)));
  EXPECT_EQ(shapes.size(), 95u);
  EXPECT_EQ(drawn("\xc3"), drawn("?"));
}

TEST(BitmapText, ShowsALetterUpright) {
  const std::vector<float> letter = {
      1, 1, 1, 1, 1,  //
      1, 0, 0, 0, 0,  //
      1, 1, 1, 1, 0,  //
      1, 0, 0, 0, 0,  //
      1, 0, 0, 0, 0,  //
      1, 0, 0, 0, 0,  //
      1, 0, 0, 0, 0,  //
      0, 0, 0, 0, 0,
  };
  EXPECT_EQ(drawn("F"), letter);
}

TEST(BitmapText, ScalesAndStaysInside) {
  EXPECT_EQ(textSize("ab", 3).width, 33);
  EXPECT_EQ(textSize("ab", 3).height, 24);
  EXPECT_EQ(textSize("", 2).width, 0);
  Image image(7, 5, 3);
  for (const int x : {-100, -3, 0, 5, 100}) {
    for (const int y : {-100, -3, 0, 3, 100}) drawText(image, "#W@", x, y, 2, Rgb(1, 0.5, 0.25));
  }
  EXPECT_EQ(image.at(0, 0, 2), 0.25F * image.at(0, 0, 0));
}

}  // namespace
}  // namespace volute
