// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "volute/image/bitmap_text.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/compare.hpp"
#include "volute/image/drawing.hpp"
#include "volute/image/picture_tiles.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Srgb, EveryByteComesBack) {
  Image image(256, 1, 1);
  for (int i = 0; i < 256; ++i) image.at(i, 0) = static_cast<float>(srgbDecode(i / 255.0));
  const auto bytes = toSrgb8(image);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(bytes[i], i);
  EXPECT_NEAR(srgbDecode(0.5), 0.21404114, 1e-8);
}

/// As IEC 61966-2-1 has it, one value after the other.
std::uint8_t byteByFormula(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * srgbEncode(value)));
}

void expectFormula(const Image& image) {
  const auto bytes = toSrgb8(image);
  int wrong = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] == byteByFormula(image.pixels[i]))
      continue;
    EXPECT_EQ(bytes[i], byteByFormula(image.pixels[i]))
        << std::hexfloat << image.pixels[i] << " at " << i;
    if (++wrong == 5)
      return;
  }
}

TEST(Srgb, BytesAreThoseOfTheFormulaWhereTheyChange) {
  constexpr int kAround = 2000;  // floats on each side of a change
  Image image(255, 2 * kAround, 1);
  for (int byte = 1; byte < 256; ++byte) {
    auto value = static_cast<float>(srgbDecode((byte - 0.5) / 255));
    for (int i = 0; i < kAround; ++i) value = std::nextafter(value, 0.0F);
    EXPECT_EQ(byteByFormula(value), byte - 1);
    for (int i = 0; i < 2 * kAround; ++i) {
      image.at(byte - 1, i) = value;
      value = std::nextafter(value, 1.0F);
    }
    EXPECT_EQ(byteByFormula(value), byte);
  }
  expectFormula(image);
}

TEST(Srgb, BytesAreThoseOfTheFormulaForAnyFloat) {
  std::mt19937 random(1);
  Image image(1024, 512, 1);
  for (float& value : image.pixels)
    value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  expectFormula(image);
  std::uniform_real_distribution<float> shown(0, 1.001F);
  for (float& value : image.pixels) value = shown(random);
  expectFormula(image);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Image ends(11, 1, 1);
  ends.pixels = {0,
                 -0.0F,
                 -1,
                 1,
                 std::nextafter(1.0F, 0.0F),
                 std::nextafter(1.0F, 2.0F),
                 static_cast<float>(kNan),
                 -static_cast<float>(kNan),
                 kInfinity,
                 -kInfinity,
                 std::numeric_limits<float>::denorm_min()};
  expectFormula(ends);
}

TEST(Srgb, ClampsWhatNoDisplayShows) {
  EXPECT_EQ(srgbEncode(-1), 0);
  EXPECT_DOUBLE_EQ(srgbEncode(7), 1);
  EXPECT_EQ(srgbEncode(kNan), 0);
  EXPECT_EQ(srgbDecode(kNan), 0);
  EXPECT_DOUBLE_EQ(srgbEncode(std::numeric_limits<double>::infinity()), 1);
}

TEST(Exposure, BringsTheBrightPartToOne) {
  Image image(10, 10, 1);
  for (int i = 0; i < 100; ++i) image.pixels[i] = static_cast<float>(i);
  const double factor = suggestExposure(image, 1);
  EXPECT_DOUBLE_EQ(factor, 1 / 99.0);
  EXPECT_FLOAT_EQ(exposed(image, factor).pixels[99], 1);
  EXPECT_EQ(suggestExposure(Image(3, 3)), 1);
  EXPECT_EQ(toSrgb8(image, factor)[99], 255);
}

TEST(ColorMap, MatchesTheTablesAtSomePoints) {
  struct Known {
    ColorMap map;
    double t;
    Rgb color;
  };

  for (const auto& [map, t, color] :
       {Known{ColorMap::kViridis, 0, Rgb(68, 1, 84)},
        Known{ColorMap::kViridis, 127 / 255.0, Rgb(33, 144, 141)},
        Known{ColorMap::kViridis, 1, Rgb(253, 231, 37)}, Known{ColorMap::kInferno, 0, Rgb(0, 0, 4)},
        Known{ColorMap::kInferno, 127 / 255.0, Rgb(187, 55, 84)},
        Known{ColorMap::kInferno, 1, Rgb(252, 255, 164)},
        Known{ColorMap::kPlasma, 0, Rgb(13, 8, 135)},
        Known{ColorMap::kPlasma, 127 / 255.0, Rgb(203, 70, 121)},
        Known{ColorMap::kPlasma, 1, Rgb(240, 249, 33)}}) {
    EXPECT_LT((displayColor(map, t) - color / 255).abs().maxCoeff(), 0.02) << t;
  }
  Image quantity(3, 1, 1);
  quantity.pixels = {2, 4, static_cast<float>(kNan)};
  const Image colors = colorMapped(quantity, ColorMap::kViridis, 2, 4);
  EXPECT_NEAR(srgbEncode(colors.at(1, 0, 0)), displayColor(ColorMap::kViridis, 1)[0], 1e-6);
  EXPECT_EQ(colors.at(2, 0, 1), colors.at(0, 0, 1));
}

TEST(CompareImages, MeasuresAsStated) {
  Image a(2, 1, 1);
  Image b(2, 1, 1);
  a.pixels = {0, 4};
  b.pixels = {0, 3};
  const auto difference = compareImages(a, b);
  ASSERT_TRUE(difference);
  EXPECT_DOUBLE_EQ(difference->maxError, 1);
  EXPECT_DOUBLE_EQ(difference->rms, std::sqrt(0.5));
  EXPECT_DOUBLE_EQ(difference->relativeRms, std::sqrt(0.5) / 4);
  EXPECT_DOUBLE_EQ(difference->psnr, -20 * std::log10(std::sqrt(0.5) / 4));
  EXPECT_TRUE(std::isinf(compareImages(a, a)->psnr));
}

TEST(CompareImages, RefusesOtherSizesAndShowsNan) {
  EXPECT_FALSE(compareImages(Image(2, 2), Image(2, 3)));
  EXPECT_FALSE(compareImages(Image(2, 2, 1), Image(2, 2, 3)));
  EXPECT_FALSE(compareImages(Image(), Image()));
  Image a(2, 1, 1);
  a.pixels[0] = static_cast<float>(kNan);
  EXPECT_TRUE(std::isnan(compareImages(a, Image(2, 1, 1))->maxError));
}

TEST(Drawing, LinesHaveTheirWidthAndRectanglesAreCut) {
  Image image(20, 20, 1);
  drawLine(image, 2, 10, 18, 10, 4, Rgb::Ones());
  float column = 0;
  for (int y = 0; y < 20; ++y) column += image.at(10, y);
  EXPECT_NEAR(column, 4, 0.01);
  EXPECT_EQ(image.at(19, 0), 0);
  fillRect(image, -5, -5, 2, 100, Rgb::Constant(0.5));
  EXPECT_EQ(image.at(1, 19), 0.5F);
  EXPECT_EQ(image.at(2, 19), 0);
}

TEST(Drawing, LinesCoverWhatIsNearThem) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20, 60), width(0.2, 7);
  for (int n = 0; n < 300; ++n) {
    std::array<double, 4> end;
    for (double& one : end) one = n % 3 == 0 ? std::round(place(random)) : place(random);
    auto [x0, y0, x1, y1] = end;
    if (n % 5 == 0)
      y1 = y0 + (n % 2) * 1e-12;
    if (n % 7 == 0)
      x1 = x0;
    const double half = 0.5 * width(random);
    Image image(40, 30, 1);
    drawLine(image, x0, y0, x1, y1, 2 * half, Rgb::Ones());
    // Whole pixels beyond the ends are cut.
    const auto inside = [&](int pixel, double a, double b) {
      return pixel >= std::floor(std::min(a, b) - half) && pixel < std::ceil(std::max(a, b) + half);
    };
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const double px = x + 0.5 - x0, py = y + 0.5 - y0;
        const double length = std::hypot(x1 - x0, y1 - y0);
        const double share =
            length > 0
                ? std::clamp((px * (x1 - x0) + py * (y1 - y0)) / length, 0.0, length) / length
                : 0;
        const double off = std::hypot(px - share * (x1 - x0), py - share * (y1 - y0));
        const double cover = std::clamp(half + 0.5 - off, 0.0, 1.0);
        EXPECT_NEAR(image.at(x, y), inside(x, x0, x1) && inside(y, y0, y1) ? cover : 0, 1e-6)
            << n << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(PictureTiles, CoverThePictureOnceTheMiddleFirst) {
  for (const auto& [width, height, about] :
       {std::array{300, 200, 4}, {1280, 800, 63}, {5, 3, 10}, {700, 65, 1}}) {
    const std::vector<PictureTile> tiles = pictureTiles(width, height, about);
    std::vector<int> covered(static_cast<std::size_t>(width) * height, 0);
    for (const PictureTile& tile : tiles) {
      EXPECT_GE(tile.width, std::min(width, 64));
      EXPECT_GE(tile.height, std::min(height, 64));
      for (int y = tile.top; y < tile.top + tile.height; ++y) {
        for (int x = tile.left; x < tile.left + tile.width; ++x)
          ++covered[static_cast<std::size_t>(y) * width + x];
      }
    }
    EXPECT_TRUE(std::ranges::all_of(covered, [](int times) { return times == 1; }));
    EXPECT_LE(std::abs(tiles[0].left + 0.5 * tiles[0].width - 0.5 * width), 0.5 * tiles[0].width);
    EXPECT_LE(std::abs(tiles[0].top + 0.5 * tiles[0].height - 0.5 * height), 0.5 * tiles[0].height);
  }
}

}  // namespace
}  // namespace volute
