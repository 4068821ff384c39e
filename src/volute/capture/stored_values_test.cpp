// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/stored_values.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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
