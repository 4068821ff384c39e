// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/optical_depth.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace volute {
namespace {

/// One row of grey pixels.
Image greyRow(std::initializer_list<float> values) {
  Image image(static_cast<int>(values.size()), 1);
  std::size_t i = 0;
  for (const float value : values) {
    std::fill_n(&image.pixels[i], 3, value);
    i += 3;
  }
  return image;
}

TEST(OpticalDepth, FollowsBeerAndLambert) {
  const Image light = greyRow({1, 0.5F, 0.25F, 1.1F}), back = greyRow({1, 1, 0.5F, 1});
  const OpticalDepths found = opticalDepths(light, back, {}, 0);
  for (int x = 0; x < 4; ++x)
    EXPECT_FLOAT_EQ(found.depth.at(x, 0, 1), std::log(back.at(x, 0) / light.at(x, 0)));
  EXPECT_LT(found.depth.at(3, 0), 0) << "noise above the background is kept";
  EXPECT_EQ(found.weight, (std::vector<float>{1, 0.5F, 0.25F, 1}));
  EXPECT_EQ(found.atLeast, (std::vector<std::uint8_t>{0, 0, 0, 0}));
  EXPECT_EQ(found.opaqueShare, 0);
}

TEST(OpticalDepth, WhatLetsNoLightThroughIsABound) {
  const Image light = greyRow({0.04F, 0, -0.01F, 0.5F}), back = greyRow({1, 1, 1, 1});
  const OpticalDepths found = opticalDepths(light, back, {}, 0.05);
  for (int x = 0; x < 3; ++x) {
    EXPECT_FLOAT_EQ(found.depth.at(x, 0), -std::log(0.05F));
    EXPECT_EQ(found.atLeast[static_cast<std::size_t>(x)], 7);
    EXPECT_EQ(found.weight[static_cast<std::size_t>(x)], 0);
  }
  EXPECT_FLOAT_EQ(found.weight[3], 0.5F);
  EXPECT_DOUBLE_EQ(found.opaqueShare, 0.75);
}

TEST(OpticalDepth, OpaquePartsTellALevelThatWasLeftIn) {
  constexpr int kSide = 64;
  const auto levelOf = [](double depth, double rim, double level) {
    Image light(kSide, kSide), back(kSide, kSide);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double r = std::hypot(x - 31.5, y - 31.5) / 24,
                     lamp = 1 - 0.3 * x / static_cast<double>(kSide);
        const double seen = lamp * std::exp(-depth / (1 + std::exp((r - 1) / rim)));
        for (int c = 0; c < 3; ++c) {
          back.at(x, y, c) = static_cast<float>(level + (1 - level) * lamp);
          light.at(x, y, c) = static_cast<float>(level + (1 - level) * seen);
        }
      }
    return opticalDepths(light, back, {}, 0).levelLeft;
  };
  EXPECT_NEAR(levelOf(12, 0.05, 0.03), 0.03, 0.003);
  EXPECT_EQ(levelOf(12, 0.05, 0), 0);
  EXPECT_EQ(levelOf(3, 0.3, 0), 0);
  EXPECT_EQ(levelOf(1, 0.05, 0.03), 0) << "nothing is opaque";
}

TEST(OpticalDepth, NothingIsKnownWithoutABackgroundOrPixel) {
  const Image light = greyRow({0.5F, 0.0005F, 0.5F}), back = greyRow({1, 0.001F, 1});
  const std::vector<float> counts{0, 1, 1};
  const OpticalDepths found = opticalDepths(light, back, counts, 0);
  EXPECT_EQ(found.weight, (std::vector<float>{0, 0, 0.5F})) << "masked, dark, seen";
  EXPECT_EQ(found.atLeast, (std::vector<std::uint8_t>{0, 0, 0}));
  EXPECT_EQ(found.depth.at(0, 0), 0);
}

}  // namespace
}  // namespace volute
