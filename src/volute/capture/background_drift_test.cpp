// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/background_drift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr int kWide = 40, kTall = 30;

/// A wall that is lit from one side.
Image litWall() {
  Image image(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = 0.2F + 0.01F * static_cast<float>(x) + 0.05F * static_cast<float>(c);
  return image;
}

Image noisy(Image image, float sigma) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  for (float& value : image.pixels) value += sigma * normal(random);
  return image;
}

const std::vector<std::uint8_t> kEveryPixel(static_cast<std::size_t>(kWide) * kTall, 1);

TEST(BackgroundDrift, FindsGainAndOffsetInSpiteOfOtherThings) {
  BackgroundDrift expectedDrift{{0.95, 1.1, 1.02}, {0.01, 0, -0.005}};
  Image picture = noisy(expectedDrift.applied(litWall()), 0.002F);
  for (int y = 0; y < 12; ++y)
    for (int x = 4; x < 18; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) += 0.4F;  // somebody passes by
  const auto found = findBackgroundDrift(picture, litWall(), kEveryPixel);
  ASSERT_TRUE(found);
  const Image expected = expectedDrift.applied(litWall()), seen = found->applied(litWall());
  for (std::size_t i = 0; i < seen.pixels.size(); ++i)
    ASSERT_NEAR(seen.pixels[i], expected.pixels[i], 1e-3);
}

TEST(BackgroundDrift, AFlatBackgroundChangesItsGain) {
  Image flat(kWide, kTall), brighter(kWide, kTall);
  std::ranges::fill(flat.pixels, 0.5F);
  std::ranges::fill(brighter.pixels, 0.53F);
  const auto found = findBackgroundDrift(brighter, flat, kEveryPixel);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->applied(flat).at(3, 3), 0.53, 1e-4);
  EXPECT_NEAR(found->gain[0], 1.06, 1e-3);
}

TEST(BackgroundDrift, SteadyBackgroundsStay) {
  EXPECT_FALSE(findBackgroundDrift(litWall(), litWall(), kEveryPixel));
  EXPECT_FALSE(findBackgroundDrift(noisy(litWall(), 0.01F), litWall(), kEveryPixel));
}

TEST(BackgroundDrift, OtherChangesAreNone) {
  Image moved(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x)
      for (int c = 0; c < 3; ++c) moved.at(x, y, c) = (x / 5 + y / 5) % 2 == 0 ? 0.9F : 0.1F;
  EXPECT_FALSE(findBackgroundDrift(moved, litWall(), kEveryPixel));
  std::vector<std::uint8_t> few(kEveryPixel.size(), 0);
  std::fill_n(few.begin(), 60, 1);
  const BackgroundDrift drift{{1.1, 1.1, 1.1}, {}};
  EXPECT_FALSE(findBackgroundDrift(drift.applied(litWall()), litWall(), few));
}

TEST(Pedestal, IsFoundUnderNoiseOfAboutAStepOfWhatIsStored) {
  Image picture(40, 40, 3);
  const std::vector<std::uint8_t> all(40 * 40, 1);
  std::mt19937 random(1);
  for (const float noise : {0.0F, 0.3F, 0.5F, 0.8F, 2.0F}) {
    std::normal_distribution<float> off(0, 1);
    for (float& value : picture.pixels)
      value = std::max(0.0F, std::round(12 + noise * off(random))) / 255;
    const auto found = findPedestal(picture, all);
    ASSERT_TRUE(found) << noise;
    EXPECT_NEAR(found->mean(), 12 / 255.0, 0.2 / 255) << noise;
    // Without it noise is cut off at 0 and stays.
    for (float& value : picture.pixels)
      value = std::max(0.0F, std::round(noise * off(random))) / 255;
    EXPECT_FALSE(findPedestal(picture, all)) << noise;
  }
}

TEST(Pedestal, IsFoundFarBelowTheBrightestPixel) {
  Image picture(40, 40, 3);
  std::vector<std::uint8_t> all(40 * 40, 1);
  std::fill_n(all.begin(), 100, 0);
  std::mt19937 random(1);
  std::normal_distribution<float> off(0, 0.5F);
  for (const int level : {2, 8}) {
    for (float& value : picture.pixels)
      value = static_cast<float>(srgbDecode(std::round(level + off(random)) / 255));
    std::fill_n(picture.pixels.begin(), 300, 1.0F);
    const auto found = findPedestal(picture, all);
    ASSERT_TRUE(found) << level;
    EXPECT_NEAR(found->mean(), srgbDecode(level / 255.0), 1e-5);
  }
}

TEST(BackgroundDrift, PixelsBesideTheVolumeMissIt) {
  const Box3 box{Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)};
  const Camera camera = Camera::pinhole({Vec3(0, -5, 0), Vec3::Zero()}, 30, kWide, kTall);
  const auto beside = pixelsBeside(camera, box);
  EXPECT_EQ(beside[0], 1);
  EXPECT_EQ(beside[(kTall / 2) * kWide + kWide / 2], 0);
  const auto count = std::ranges::count(beside, 1);
  EXPECT_GT(count, kWide * kTall / 2);
  EXPECT_LT(count, kWide * kTall - 100);
}

}  // namespace
}  // namespace volute
