// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/fog/fog_testing.hpp"

namespace volute {
namespace {

using fogtest::depthOf;

FogMap map(unsigned seed) {
  return *FogMap::fromCoefficients(fogtest::map(20, 16, seed), {.cell = 1.5});
}

TEST(FogSequence, IsLinearBetweenMapsAndMovesWithTheWind) {
  const FogOptions options{.degree = 2, .levels = 2, .detail = {.cellAngle = 0.2}};
  const FogProfile profile = *FogProfile::exponential(1, 3);
  const Vec3 wind(1.5, 0.2, 0);
  const auto sequence = FogSequence::make({{1, map(1)}, {3, map(2)}}, profile, options, wind);
  ASSERT_TRUE(sequence);
  const FogMedium a = *FogMedium::make(map(1), profile, options),
                  b = *FogMedium::make(map(2), profile, options);
  for (const Segment& segment : fogtest::rays(a, 60)) {
    const auto at = [&](double time) {
      Segment blown = segment;
      blown.origin += time * wind;
      return depthOf(sequence->at(time), blown);
    };
    const double da = depthOf(a, segment), db = depthOf(b, segment);
    EXPECT_NEAR(at(-5), da, 1e-12);
    EXPECT_NEAR(at(1), da, 1e-12);
    EXPECT_NEAR(at(2.5), 0.25 * da + 0.75 * db, 1e-12);
    EXPECT_NEAR(at(9), db, 1e-12);
  }
}

TEST(FogSequence, BadFramesAreNamed) {
  const auto message = [](std::vector<FogSequence::Frame> frames) {
    const auto sequence = FogSequence::make(std::move(frames), {});
    EXPECT_FALSE(sequence);
    return sequence ? std::string() : sequence.error().message;
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(message({}), HasSubstr("at least one"));
  EXPECT_THAT(message({{1, map(1)}, {1, map(2)}}), HasSubstr("times must rise"));
  const FogMap small = *FogMap::fromCoefficients(fogtest::map(5, 5), {.cell = 1.5});
  EXPECT_THAT(message({{1, map(1)}, {2, small}}), HasSubstr("5 x 5"));
}

}  // namespace
}  // namespace volute
