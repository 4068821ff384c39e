// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/stored_values.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace volute {
namespace {

/// Noise on a slope, in whole numbers of so many bits, clipped.
Image ramp(int most, int limit, int channels = 3) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Image image(96, 64, channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < channels; ++c) {
        const double light = most * (x / 95.0) * (c == 0 ? 1 : 0.6) + 3 * normal(random);
        image.at(x, y, c) =
            static_cast<float>(std::clamp(std::round(light), 0.0, 1.0 * limit) / 65535);
      }
  return image;
}

TEST(StoredValues, PlateausAreWhereManyPixelsReadTheLargestValue) {
  for (const auto& [limit, bits] :
       {std::pair(1023, 10), std::pair(4095, 12), std::pair(16383, 14)}) {
    const auto plateau = plateauOf(ramp(2 * limit, limit));
    ASSERT_TRUE(plateau.has_value()) << limit;
    EXPECT_EQ(bitsOf(plateau->value), bits);
    EXPECT_GT(plateau->share, 0.3);
    EXPECT_FALSE(plateauOf(ramp(limit, limit + 100)).has_value()) << limit;
  }
  Image words = ramp(2 * 4095, 4095);  // the same values in a file of 32 bits
  constexpr double kWord = 4294967295.0;
  for (float& value : words.pixels) value = static_cast<float>(value * (65535 / kWord));
  const auto inWords = plateauOf(words, kWord);
  ASSERT_TRUE(inWords.has_value());
  EXPECT_EQ(bitsOf(inWords->value, kWord), 12);
  EXPECT_EQ(bitsHolding(words, kWord), 12);
  const auto other = plateauOf(ramp(9000, 5000));
  ASSERT_TRUE(other.has_value());
  EXPECT_FALSE(bitsOf(other->value).has_value());
}

/// A smooth hill of light, as 16 bits store it, each channel up to its limit.
Image hill(double most, const std::array<double, 3>& limits) {
  Image image(48, 40, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double light =
            most * std::exp(-(std::pow(x - 23.3, 2) + std::pow(y - 19.6, 2)) / 120);
        image.at(x, y, c) =
            static_cast<float>(std::round(65535 * std::min(light, limits[c])) / 65535);
      }
  return image;
}

TEST(StoredValues, ChannelsMayStopAtDifferentValues) {
  const auto limits = channelLimits(hill(2, {1, 0.65, 0.8}), 1);
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ((*limits)[0], 1);
  EXPECT_NEAR((*limits)[1], 0.65, 1e-4);
  EXPECT_NEAR((*limits)[2], 0.8, 1e-4);
  EXPECT_FALSE(channelLimits(hill(2, {1, 1, 1}), 1).has_value());
  EXPECT_FALSE(channelLimits(hill(2, {1, 3, 3}), 1).has_value());
  EXPECT_FALSE(channelLimits(hill(0.9, {1, 1, 1}), 1).has_value());
  Image coloured = hill(2, {1, 1, 1});
  for (std::size_t i = 1; i < coloured.pixels.size(); i += 3)
    coloured.pixels[i] *= 0.3F + 0.0001F * static_cast<float>(i % 1000);
  EXPECT_FALSE(channelLimits(coloured, 1).has_value()) << "green has no limit";
}

TEST(StoredValues, FloatsThatWereIntegersAreKnown) {
  Image bytes = hill(0.9, {1, 1, 1}), light = bytes, divided = bytes;
  for (std::size_t i = 0; i < light.pixels.size(); ++i) {
    bytes.pixels[i] = std::round(255 * light.pixels[i]);
    divided.pixels[i] = bytes.pixels[i] / 255;
    light.pixels[i] = 200 * std::sqrt(light.pixels[i]);
  }
  EXPECT_NEAR(countsOf(bytes), 230, 2);
  EXPECT_EQ(countsOf(light), 0);
  EXPECT_EQ(countsOf(divided), 0);
  EXPECT_TRUE(areDividedIntegers(divided));
  EXPECT_FALSE(areDividedIntegers(bytes));
  EXPECT_FALSE(areDividedIntegers(light));
  for (float& value : light.pixels) value /= 200;
  EXPECT_FALSE(areDividedIntegers(light));
}

TEST(StoredValues, EvenPicturesAndFullFilesHaveNone) {
  Image even(40, 30, 1);
  std::ranges::fill(even.pixels, 0.25F);
  EXPECT_FALSE(plateauOf(even).has_value());
  EXPECT_FALSE(plateauOf(ramp(2 * 65535, 65535)).has_value()) << "the most that a file can hold";
  EXPECT_FALSE(plateauOf(Image(40, 30, 3)).has_value());
  EXPECT_FALSE(plateauOf(Image()).has_value());
}

TEST(StoredValues, MosaicsDifferByThePlaceOfThePixel) {
  Image image = ramp(30000, 40000, 1);
  EXPECT_FALSE(isMosaic(image));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) image.at(x, y) *= x % 2 == 0 ? 1 : 0.7F;
  EXPECT_TRUE(isMosaic(image));
  EXPECT_FALSE(isMosaic(ramp(30000, 40000, 3)));
  EXPECT_FALSE(isMosaic(Image()));
}

}  // namespace
}  // namespace volute
