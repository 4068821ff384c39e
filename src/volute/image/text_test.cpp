// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr TextStyle kStyles[] = {{Typeface::kSans, 16}, {Typeface::kMono, 20}};

Image lineOf(std::string_view text, const TextStyle& style) {
  const TextSize size = textSize(text, style);
  Image image(size.width + 4, size.height + 4, 1);
  drawText(image, text, 2, 2, style, Rgb::Ones());
  return image;
}

float inkOf(const Image& image) {
  float sum = 0;
  for (const float value : image.pixels) sum += value;
  return sum;
}

TEST(Text, IsWithinItsSize) {
  for (const TextStyle& style : kStyles) {
    for (const auto* text : {"Ljpqy_@|", "k\xCE\xB1 \xE2\x89\xA4 7 m\xC2\xB2", "\xC3\x84g"}) {
      const Image image = lineOf(text, style);
      EXPECT_GT(inkOf(image), 50) << text;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          EXPECT_GE(image.at(x, y), 0);
          EXPECT_LE(image.at(x, y), 1);
          if (x == 0 || y == 0 || x == image.width - 1 || y == image.height - 1) {
            EXPECT_EQ(image.at(x, y), 0) << text << " " << x << " " << y;
          }
        }
      }
    }
  }
}

TEST(Text, LettersOfDotsAreSixOfThemWide) {
  for (const int dot : {1, 2, 3, 7}) {
    const int wide = textSize("iiWW", TextStyle::ofDots(dot)).width;
    EXPECT_GE(wide, 23 * dot) << dot;
    EXPECT_LE(wide, 24 * dot) << dot;
  }
}

TEST(Text, UpwardsIsTextTurned) {
  for (const TextStyle& style : kStyles) {
    const TextSize size = textSize("Ly 7", style);
    Image flat(size.width, size.height, 1), turned(size.height, size.width, 1);
    drawText(flat, "Ly 7", 0, 0, style, Rgb::Ones());
    drawTextUpwards(turned, "Ly 7", 0, size.width, style, Rgb::Ones());
    for (int y = 0; y < flat.height; ++y) {
      for (int x = 0; x < flat.width; ++x)
        EXPECT_EQ(flat.at(x, y), turned.at(y, size.width - 1 - x));
    }
    EXPECT_GT(inkOf(turned), 50);
  }
}

TEST(Text, WhatIsNoUtf8IsDrawnAsQuestionMarks) {
  for (const auto* text : {"a\xC3", "a\xFF", "a\x80", "a\xC0"})
    EXPECT_EQ(lineOf(text, kStyles[0]).pixels, lineOf("a?", kStyles[0]).pixels);
}

TEST(Text, StaysInsideAndIsDrawnByManyThreads) {
  const Image alone = lineOf("visibility 30 m", kStyles[0]);
  parallelFor(64, [&](std::size_t) {
    EXPECT_EQ(lineOf("visibility 30 m", kStyles[0]).pixels, alone.pixels);
  });
  Image image(7, 5, 3);
  for (const int x : {-100, -3, 0, 5, 100}) {
    for (const int y : {-100, -9, 0, 3, 100})
      drawText(image, "#W@", x, y, kStyles[0], Rgb(1, 0.5, 0.25));
  }
  EXPECT_NEAR(image.at(3, 2, 2), 0.25F * image.at(3, 2, 0), 1e-6);
}

}  // namespace
}  // namespace volute
