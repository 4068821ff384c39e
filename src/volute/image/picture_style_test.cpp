// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/picture_style.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>

#include "volute/image/srgb.hpp"

namespace volute {
namespace {

/// A second writing of Hill's curve, from its publication: rows of both matrices, and the fit.
double hillGrey(double v) {
  const double in = v * (0.59719 + 0.35458 + 0.04823);
  const double a = in * (in + 0.0245786) - 0.000090537;
  const double b = in * (0.983729 * in + 0.4329510) + 0.238081;
  return a / b * (1.60475 - 0.53108 - 0.07367);
}

TEST(Tone, FilmicGreyFollowsTheFit) {
  for (const double v : {0.01, 0.18, 0.5, 1.0, 4.0, 30.0}) {
    const Rgb shown = toneMapped(ToneCurve::kFilmic, Rgb::Constant(v));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], std::min(1.0, hillGrey(v)), 2e-4) << v;
  }
}

TEST(Tone, AgxShowsMiddleGreyAndItsEnds) {
  // 0.18 is at 10 of 16.5 stops: the polynomial there, to the power of 2.2.
  const double x = 10 / 16.5;
  const double sigmoid = 15.5 * std::pow(x, 6) - 40.14 * std::pow(x, 5) + 31.96 * std::pow(x, 4) -
                         6.868 * std::pow(x, 3) + 0.4298 * x * x + 0.1191 * x - 0.00232;
  // Rows of the matrix sum to 1 + 1e-4.
  EXPECT_NEAR(toneMapped(ToneCurve::kAgx, Rgb::Constant(0.18))[1], std::pow(sigmoid, 2.2), 2e-4);
  EXPECT_NEAR(toneMapped(ToneCurve::kAgx, Rgb::Zero())[0], 0, 1e-9);
  EXPECT_NEAR(toneMapped(ToneCurve::kAgx, Rgb::Constant(1e4))[2], 1, 5e-3);
}

TEST(ToneCurve, AShoulderKeepsHuesAndWhatIsDark) {
  const Rgb flame(1, 0.6, 0.2);
  double last = 0;
  for (const double light : {0.1, 0.5, 0.7, 0.9, 1.5, 4.0, 30.0}) {
    const Rgb shown = toneMapped(ToneCurve::kShoulder, light * flame);
    EXPECT_GT(shown[0], last) << light;
    EXPECT_LT(shown[0], 1) << light;
    EXPECT_NEAR(shown[1] / shown[0], 0.6, 1e-12);
    EXPECT_NEAR(shown[2] / shown[0], 0.2, 1e-12);
    EXPECT_TRUE(light > 0.7 || std::abs(shown[0] - light) < 1e-12) << light;
    last = shown[0];
  }
  EXPECT_NEAR(toneMapped(ToneCurve::kShoulder, Rgb::Constant(0.701))[0], 0.701, 1e-5);
}

TEST(ToneCurve, AShoulderLeavesThinSmokeBeforeWhiteAsItIs) {
  for (const double grey : {0.7, 0.8, 0.95, 1.0})
    EXPECT_NEAR(toneMapped(ToneCurve::kShoulder, Rgb::Constant(grey))[0], grey, 1e-12);
  EXPECT_EQ(toneMapped(ToneCurve::kShoulder, Rgb::Constant(3))[1], 1);
  EXPECT_NEAR(toneMapped(ToneCurve::kShoulder, Rgb(1, 0.99, 0.98))[0], 1, 4e-3);
}

TEST(Tone, BrightLightGrowsAndLosesItsColour) {
  const Rgb fire(1, 0.3, 0.02);
  for (const ToneCurve tone : {ToneCurve::kFilmic, ToneCurve::kAgx}) {
    double before = -1, purity = 2;
    for (const double exposure : {0.1, 0.5, 2.0, 8.0, 60.0}) {
      const Rgb shown = toneMapped(tone, exposure * fire);
      EXPECT_GE(shown.minCoeff(), 0);
      EXPECT_LE(shown.maxCoeff(), 1);
      EXPECT_GE(shown.sum(), before);
      const double now = 1 - shown.minCoeff() / shown.maxCoeff();
      EXPECT_LE(now, purity + 1e-9);
      before = shown.sum(), purity = now;
    }
    EXPECT_LT(purity, 0.45) << nameOf(tone);  // yellow that is clipped would have 1
  }
}

TEST(Tone, NoneChangesNothingAndOthersTakeAnything) {
  const Rgb odd(-1, 7, 1e30);
  EXPECT_TRUE((toneMapped(ToneCurve::kNone, odd) == odd).all());
  const double inf = std::numeric_limits<double>::infinity();
  for (const ToneCurve tone : {ToneCurve::kFilmic, ToneCurve::kAgx}) {
    const Rgb shown = toneMapped(tone, {std::nan(""), inf, -inf});
    EXPECT_TRUE((shown >= 0).all() && (shown <= 1).all());
  }
}

TEST(Glow, KeepsTheSumOfLightAndSpreadsAPoint) {
  for (const int width : {64, 61}) {
    Image image(width, 48);
    image.at(10, 20, 0) = 100, image.at(0, 0, 1) = 7, image.at(width - 1, 47, 2) = 3;
    const Image out = withGlow(image, 0.3);
    for (int c = 0; c < 3; ++c) {
      double before = 0, after = 0;
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < width; ++x) before += image.at(x, y, c), after += out.at(x, y, c);
      }
      EXPECT_NEAR(after, before, 2e-5 * before) << width << " " << c;
    }
    EXPECT_GT(out.at(10, 20), 70);
    EXPECT_GT(out.at(13, 20), 0);
    EXPECT_LT(out.at(13, 20), out.at(11, 20));
  }
}

TEST(Glow, IsLinear) {
  Image a(32, 24, 1), b(32, 24, 1), both(32, 24, 1);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    a.pixels[i] = static_cast<float>(i % 7), b.pixels[i] = static_cast<float>((i * i) % 11);
    both.pixels[i] = 2 * a.pixels[i] + b.pixels[i];
  }
  const Image ga = withGlow(a, 0.5), gb = withGlow(b, 0.5), g = withGlow(both, 0.5);
  for (std::size_t i = 0; i < g.pixels.size(); ++i)
    EXPECT_NEAR(g.pixels[i], 2 * ga.pixels[i] + gb.pixels[i], 1e-4);
}

TEST(Dither, KeepsMeansAndHasNoStepAboveOneLevel) {
  Image image(512, 64, 3);  // a gradient over 12 levels, as a dark sky has it
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = static_cast<float>(srgbDecode((20 + 12.0 * x / image.width) / 255));
    }
  }
  Image dithered = image;
  dither(dithered);
  const auto bytes = toSrgb8(dithered);
  double sum = 0;
  int longest = 0, run = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t i = 3 * (static_cast<std::size_t>(y) * 512 + x);
      const double level = 20 + 12.0 * x / 512;
      EXPECT_LE(std::abs(bytes[i] - level), 1);
      sum += bytes[i] - level;
      const bool same = x > 0 && bytes[i] == bytes[i - 3];
      run = same ? run + 1 : 0;
      longest = std::max(longest, run);
      if (x > 0) {
        EXPECT_LE(std::abs(bytes[i] - bytes[i - 3]), 1);
      }
    }
  }
  EXPECT_NEAR(sum / (512 * 64), 0, 0.02);
  const auto meanOf = [](const Image& of) {
    return std::accumulate(of.pixels.begin(), of.pixels.end(), 0.0) /
           static_cast<double>(of.pixels.size());
  };
  EXPECT_NEAR(meanOf(dithered) / meanOf(image), 1, 2e-4);
  EXPECT_LT(longest, 30);  // rounded, bands are 43 pixels wide
}

TEST(Dither, LeavesWhatADisplayShows) {
  Image image(256, 8, 1);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 256; ++x) image.at(x, y) = static_cast<float>(srgbDecode(x / 255.0));
  }
  const auto before = toSrgb8(image);
  dither(image);
  EXPECT_EQ(toSrgb8(image), before);
  Image odd(3, 1, 1);
  odd.pixels = {std::nanf(""), -2, 1e9F};
  dither(odd);
  EXPECT_EQ(toSrgb8(odd), (std::vector<std::uint8_t>{0, 0, 255}));
}

TEST(Edges, AreStepsAndNotGradients) {
  Image image(40, 4, 1);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double level = x < 20 ? 8 * x : x < 30 ? 200 : 215;
      image.at(x, y) = static_cast<float>(srgbDecode(level / 255));
    }
  }
  const auto edges = edgePixels(image);
  for (int x = 0; x < 40; ++x)
    EXPECT_EQ(edges[static_cast<std::size_t>(x)], x == 19 || x == 20 || x == 29 || x == 30) << x;
}

TEST(Style, EdgesAreThoseOfEachPixelByItself) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> level(0, 0.05F);
  for (const auto& [width, height, channels] :
       {std::array{1, 1, 3}, {2, 5, 3}, {1, 7, 1}, {33, 21, 3}, {40, 2, 1}}) {
    Image image(width, height, channels);
    for (float& value : image.pixels) value = level(random);
    const auto bytes = toSrgb8(image);
    const auto edges = edgePixels(image);
    const auto at = [&](int x, int y, int c) {
      const int i = std::clamp(x, 0, image.width - 1), j = std::clamp(y, 0, image.height - 1);
      return int{bytes[static_cast<std::size_t>((j * image.width + i) * image.channels + c)]};
    };
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        bool edge = false;
        for (int c = 0; c < channels; ++c) {
          edge |= std::abs(2 * at(x, y, c) - at(x - 1, y, c) - at(x + 1, y, c)) > 12 ||
                  std::abs(2 * at(x, y, c) - at(x, y - 1, c) - at(x, y + 1, c)) > 12;
        }
        EXPECT_EQ(edges[static_cast<std::size_t>(y * width + x)], edge) << x << ", " << y;
      }
    }
  }
}

TEST(Style, FilmicOfPlainAreasIsThatOfEachPixel) {
  Image light(400, 3, 3);
  for (std::size_t i = 0; i < light.pixels.size(); ++i) {
    const std::size_t x = i / 3 % 400;
    const float plain = x < 150 ? -1 : x < 300 ? 0.3F : 0.7F;
    light.pixels[i] = (x == 380 ? 0.1F : plain) + 0.01F * static_cast<float>(i % 3);
  }
  const Image shown = developed(light, {1, ToneCurve::kFilmic, 0, false});
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 400; ++x) {
      const Rgb expected =
          toneMapped(ToneCurve::kFilmic, {light.at(x, y, 0), light.at(x, y, 1), light.at(x, y, 2)});
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(shown.at(x, y, c), static_cast<float>(expected[c])) << x << ", " << y;
    }
  }
}

TEST(Style, StepsComeInTheirOrder) {
  Image light(8, 8, 3);
  for (std::size_t i = 0; i < light.pixels.size(); ++i)
    light.pixels[i] = 0.01F * static_cast<float>(i);
  const PictureStyle style{2, ToneCurve::kFilmic, 0.2, false};
  const Image shown = developed(light, style);
  const Image glowing = withGlow(exposed(light, 2), 0.2);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const Rgb expected = toneMapped(
          ToneCurve::kFilmic, {glowing.at(x, y, 0), glowing.at(x, y, 1), glowing.at(x, y, 2)});
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown.at(x, y, c), expected[c], 1e-6);
    }
  }
}

TEST(Style, OneExposureServesAllPictures) {
  std::vector<Image> pictures(2, Image(10, 10, 1));
  for (int i = 0; i < 100; ++i) pictures[1].pixels[i] = static_cast<float>(i);
  EXPECT_DOUBLE_EQ(suggestExposure(pictures, ToneCurve::kNone, 1), 1 / 99.0);
  EXPECT_NEAR(suggestExposure(pictures, ToneCurve::kFilmic, 1), 0.6 / 50, 2e-4);
  for (float& value : pictures[1].pixels) value = value > 90 ? 99 : 2;
  EXPECT_NEAR(suggestExposure(pictures, ToneCurve::kFilmic, 1), 3 / 99.0, 1e-6);
  EXPECT_EQ(suggestExposure(std::vector<Image>{Image(3, 3)}, ToneCurve::kFilmic), 1);
}

TEST(Developed, FilmicPicturesAreTheCurveOfEachPixel) {
  Image light(173, 2);
  for (std::size_t i = 0; i < light.pixels.size(); ++i)
    light.pixels[i] = i % 7 == 0 ? -1.0F : static_cast<float>(std::exp(0.05 * (i % 400) - 12));
  light.pixels[4] = std::numeric_limits<float>::quiet_NaN();
  light.pixels[5] = std::numeric_limits<float>::infinity();
  const Image shown = developed(light, {.tone = ToneCurve::kFilmic});
  for (std::size_t p = 0; p < light.pixels.size(); p += 3) {
    const Rgb one =
        toneMapped(ToneCurve::kFilmic, {light.pixels[p], light.pixels[p + 1], light.pixels[p + 2]});
    for (int c = 0; c < 3; ++c) EXPECT_EQ(shown.pixels[p + c], static_cast<float>(one[c])) << p;
  }
}

}  // namespace
}  // namespace volute
