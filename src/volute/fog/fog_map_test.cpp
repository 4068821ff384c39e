// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "volute/fog/fog_medium.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

Image grey(int width, int height, float value = 0.5F) {
  Image image(width, height, 1);
  for (float& pixel : image.pixels) pixel = value;
  return image;
}

TEST(FogMap, FirstImageRowIsTheLargestY) {
  Image image = grey(3, 2, 0);
  image.at(2, 0) = 1;  // top right
  const FogMap map = *FogMap::fromImage(image, {.sigmaMax = 0.25});
  EXPECT_DOUBLE_EQ(map.coefficients.at(2, 1), 0.25);
  EXPECT_DOUBLE_EQ(map.coefficients.sum(), 0.25);
}

TEST(FogMap, CoefficientsPeakAtHalfTheOrder) {
  for (int degree = 0; degree <= 3; ++degree) {
    for (int levels : {0, 3}) {
      Image image = grey(7, 5, 0);
      image.at(4, 3) = 1;  // column 4, row 1 from below
      const FogPlacement placement{.origin = Vec3(10, 20, 5), .cell = 2, .sigmaMax = 1};
      const FogMedium fog = *FogMedium::make(*FogMap::fromImage(image, placement), {},
                                             {.degree = degree, .levels = levels});
      const Vec3 peak =
          placement.origin + 2 * Vec3(4 + (degree + 1) / 2.0, 1 + (degree + 1) / 2.0, 0);
      const double there = fog.extinction(peak);
      EXPECT_NEAR(there, std::pow(bspline(degree, (degree + 1) / 2.0), 2), 1e-12);
      if (degree > 0) {
        EXPECT_LT(fog.extinction(peak + Vec3(0.3, 0, 0)), there);
        EXPECT_NEAR(fog.extinction(peak + Vec3(0.3, 0, 0)), fog.extinction(peak - Vec3(0.3, 0, 0)),
                    1e-12);
      }
      EXPECT_EQ(fog.bounds().min.head<2>(), placement.origin.head<2>());
      EXPECT_LT((fog.bounds().max.head<2>() -
                 (placement.origin + 2 * Vec3(7 + degree, 5 + degree, 0)).head<2>())
                    .norm(),
                1e-12);
    }
  }
}

TEST(FogMap, TinyMapsAreMaps) {
  for (auto [width, height] : {std::pair(1, 1), std::pair(1, 9), std::pair(9, 1)}) {
    for (int degree = 0; degree <= 3; ++degree) {
      const FogMedium fog =
          *FogMedium::make(*FogMap::fromImage(grey(width, height), {.sigmaMax = 0.2}), {},
                           {.degree = degree, .levels = 2});
      const Segment along{Vec3(-1, (height + degree) / 2.0 + 1e-6, 0), Vec3::UnitX(), 0, 100};
      double depth = 0;
      fog.opticalDepth({&along, 1}, {&depth, 1});
      EXPECT_GT(depth, 0);
      EXPECT_LE(depth, 0.1 * width + 1e-12);
    }
  }
}

TEST(FogMap, ColourOnRequestOnly) {
  Image image(2, 2, 3);
  image.at(0, 0, 1) = 1;
  const auto refused = FogMap::fromImage(image, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("3 channels"));
  const FogMap map = *FogMap::fromImage(image, {.sigmaMax = 1}, FogColour::kLuma);
  EXPECT_DOUBLE_EQ(map.coefficients.at(0, 1), 0.7152);
}

TEST(FogMap, GreyInThreeChannels) {
  Image image(2, 1, 3);
  for (int c = 0; c < 3; ++c) image.at(1, 0, c) = 0.25F;
  const auto map = FogMap::fromImage(image, {.sigmaMax = 2});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_NEAR(map->coefficients.at(1, 0), 0.5, 1e-12);
  EXPECT_EQ(map->coefficients.at(0, 0), 0);
}

TEST(FogMap, BadInputIsNamed) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto message = [](const Result<FogMap>& map) {
    EXPECT_FALSE(map);
    return map ? std::string() : map.error().message;
  };
  EXPECT_THAT(message(FogMap::fromImage(grey(2, 2), {.sigmaMax = -1})), HasSubstr("sigma_max"));
  EXPECT_THAT(message(FogMap::fromImage(grey(2, 2), {.sigmaMax = nan})), HasSubstr("sigma_max"));
  EXPECT_THAT(message(FogMap::fromImage(grey(2, 2), {.cell = 0})), HasSubstr("cell"));
  EXPECT_THAT(message(FogMap::fromImage(grey(2, 2), {.cell = nan})), HasSubstr("cell"));
  EXPECT_THAT(message(FogMap::fromImage(grey(2, 2), {.origin = Vec3(nan, 0, 0)})),
              HasSubstr("origin"));
  EXPECT_THAT(message(FogMap::fromImage(Image(0, 0, 1), {})), HasSubstr("0 x 0"));
  Image bad = grey(3, 2);
  bad.at(1, 0) = nan;
  EXPECT_THAT(message(FogMap::fromImage(bad, {})), HasSubstr("pixel 1, 0"));
  bad.at(1, 0) = -0.1F;
  EXPECT_THAT(message(FogMap::fromImage(bad, {})), HasSubstr("pixel 1, 0"));
  SplineGrid grid(2, 2);
  grid.c[3] = -1;
  EXPECT_THAT(message(FogMap::fromCoefficients(grid, {})), HasSubstr("coefficient 3"));
  grid.c.pop_back();
  EXPECT_THAT(message(FogMap::fromCoefficients(grid, {})), HasSubstr("expected"));
}

TEST(FogMedium, BadOptionsAreNamed) {
  const FogMap map = *FogMap::fromImage(grey(4, 4), {});
  const auto message = [&](const FogOptions& options) {
    const auto fog = FogMedium::make(map, {}, options);
    EXPECT_FALSE(fog);
    return fog ? std::string() : fog.error().message;
  };
  EXPECT_THAT(message({.degree = 4}), HasSubstr("degree is 4"));
  EXPECT_THAT(message({.degree = -1}), HasSubstr("degree is -1"));
  EXPECT_THAT(message({.levels = 99}), HasSubstr("99 levels"));
  EXPECT_THAT(message({.detail = {.mu = 1.5}}), HasSubstr("mu is 1.5"));
  EXPECT_THAT(message({.detail = {.mu = std::nan("")}}), HasSubstr("mu"));
  EXPECT_THAT(message({.detail = {.cellAngle = -1}}), HasSubstr("angle"));
  EXPECT_THAT(message({.color = Rgb(-1, 0, 0)}), HasSubstr("color"));
}

TEST(FogProfile, BadProfilesAreNamed) {
  const auto message = [](const Result<FogProfile>& profile) {
    EXPECT_FALSE(profile);
    return profile ? std::string() : profile.error().message;
  };
  EXPECT_THAT(message(FogProfile::slab(3, 3)), HasSubstr("top"));
  EXPECT_THAT(message(FogProfile::slab(std::nan(""), 3)), HasSubstr("slab"));
  EXPECT_THAT(message(FogProfile::exponential(0, 0)), HasSubstr("scale height"));
  const FogProfile::Knot one[] = {{0, 1}}, falling[] = {{0, 1}, {-1, 1}},
                         large[] = {{0, 1}, {1, 2}};
  EXPECT_THAT(message(FogProfile::linear(one)), HasSubstr("1 knots"));
  EXPECT_THAT(message(FogProfile::linear(falling)), HasSubstr("knot 1"));
  EXPECT_THAT(message(FogProfile::linear(large)), HasSubstr("knot 1"));
  const FogProfile::Layer layer[] = {{0, 1, -1}};
  EXPECT_THAT(message(FogProfile::layers(layer)), HasSubstr("share"));
}

TEST(FogProfile, Values) {
  const FogProfile exponential = *FogProfile::exponential(2, 5);
  EXPECT_EQ(exponential(-1000), 1);
  EXPECT_NEAR(exponential(7), std::exp(-1), 1e-15);
  EXPECT_EQ(exponential(2 + 61 * 5.0), 0);
  EXPECT_EQ(exponential.heights().end, 2 + 60 * 5.0);
  EXPECT_EQ(exponential.seenHeights().begin, 2);
  EXPECT_EQ(exponential.seenHeights().end, 2 + 5 * 5.0);
  const FogProfile::Knot knots[] = {{0, 1}, {10, 0.5}, {30, 0}};
  const FogProfile linear = *FogProfile::linear(knots);
  EXPECT_DOUBLE_EQ(linear(5), 0.75);
  EXPECT_DOUBLE_EQ(linear(20), 0.25);
  EXPECT_EQ(linear(-0.1), 0);
  EXPECT_EQ(linear(30.1), 0);
  const FogProfile::Layer layers[] = {{0, 3, 0.5}, {2, 5, 0.25}};
  const FogProfile stacked = *FogProfile::layers(layers);
  EXPECT_DOUBLE_EQ(stacked(1), 0.5);
  EXPECT_DOUBLE_EQ(stacked(2.5), 0.75);
  EXPECT_DOUBLE_EQ(stacked(4), 0.25);
  const FogProfile::Layer beyond[] = {{2e7, 3e7, 1}};
  EXPECT_TRUE(FogProfile::layers(beyond)->heights().empty()) << "higher than any fog";
}

}  // namespace
}  // namespace volute
