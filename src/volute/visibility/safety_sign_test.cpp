// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/safety_sign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace volute {
namespace {

/// Uniform smoke, nothing in the way.
Sighting through(const SafetySign& sign, const Vec3& eye, double extinction) {
  const double depth = extinction * (eye - sign.position).norm();
  return judge(sign, eye, {.depth = depth, .low = depth, .high = depth});
}

SafetySign signOf(const char* law, AngleLaw angle = {}) {
  return {.name = "exit", .law = visibilityLaw(law).value(), .angle = angle};
}

TEST(Sign, IsSeenAsFarAsJinSays) {
  // K = 0.3: 10 m and 26.67 m.
  for (const auto& [law, c] : {std::pair("jin-reflecting", 3.0), {"jin-emitting", 8.0}}) {
    const SafetySign sign = signOf(law);
    const double most = c / 0.3;
    const Sighting near = through(sign, Vec3(most - 0.01, 0, 0), 0.3);
    const Sighting far = through(sign, Vec3(most + 0.01, 0, 0), 0.3);
    EXPECT_TRUE(near.visible && near.certainly && near.possibly);
    EXPECT_FALSE(far.visible || far.certainly || far.possibly);
    EXPECT_NEAR(far.visibility(), most, 1e-12);
    EXPECT_NEAR(far.meanExtinction(), 0.3, 1e-12);
    EXPECT_NEAR(far.distance, most + 0.01, 1e-12);
    EXPECT_NEAR(far.angle, 0, 1e-12);
  }
  const Sighting clear = through(signOf("jin-reflecting"), Vec3(500, 0, 0), 0);
  EXPECT_TRUE(clear.visible);
  EXPECT_TRUE(std::isinf(clear.visibility()));
}

TEST(Sign, AvertedIsNotSeenButStillMeasured) {
  const Sighting behind = through(signOf("jin-emitting"), Vec3(-2, 1, 0), 0.1);
  EXPECT_FALSE(behind.visible || behind.possibly);
  EXPECT_EQ(behind.visibility(), 0);
  EXPECT_NEAR(behind.meanExtinction(), 0.1, 1e-12);
  EXPECT_NEAR(behind.angle, 180 - std::atan(0.5) * 180 / M_PI, 1e-5);
  // In its plane it is a line.
  EXPECT_FALSE(through(signOf("jin-emitting"), Vec3(0, 3, 0), 0).visible);
}

TEST(Sign, AngleLawsShortenTheDistance) {
  const Vec3 at60 = 4 * Vec3(0.5, std::sqrt(0.75), 0);
  const auto visibility = [&](AngleLaw angle) {
    return through(signOf("jin-reflecting", angle), at60, 0.3).visibility();
  };
  EXPECT_NEAR(visibility({AngleLaw::Kind::kFront}), 10, 1e-9);
  EXPECT_NEAR(visibility({AngleLaw::Kind::kCosine}), 5, 1e-9);
  EXPECT_NEAR(visibility({AngleLaw::Kind::kAny}), 10, 1e-9);
  EXPECT_NEAR(visibility({AngleLaw::Kind::kLimit, 61}), 10, 1e-9);
  EXPECT_EQ(visibility({AngleLaw::Kind::kLimit, 59}), 0);
  EXPECT_TRUE(through(signOf("3", {AngleLaw::Kind::kAny}), Vec3(-1, 0, 0), 0).visible);
  for (const char* name : {"front", "any", "cosine"}) EXPECT_EQ(nameOf(*angleLaw(name)), name);
  EXPECT_FALSE(angleLaw("sine").has_value());
  EXPECT_EQ(nameOf(AngleLaw{AngleLaw::Kind::kLimit, 60}), "limit 60");
}

TEST(Sign, RoundingLeavesItOpen) {
  const SafetySign sign = signOf("jin-reflecting");
  const Sighting open = judge(sign, Vec3(5, 0, 0), {.depth = 2.9, .low = 2.5, .high = 3.3});
  EXPECT_TRUE(open.visible && open.possibly);
  EXPECT_FALSE(open.certainly);
  const Sighting over = judge(sign, Vec3(5, 0, 0), {.depth = 3.1, .low = 2.5, .high = 3.3});
  EXPECT_TRUE(!over.visible && over.possibly && !over.certainly);
}

TEST(Sign, BehindAWallOrInTheUnknownIsNotSeen) {
  const SafetySign sign = signOf("jin-reflecting");
  const Sighting wall =
      judge(sign, Vec3(5, 0, 0), {.depth = 0.5, .low = 0.5, .high = 0.5, .blocked = true});
  EXPECT_FALSE(wall.visible || wall.possibly);
  EXPECT_NEAR(wall.meanExtinction(), 0.1, 1e-12);
  EXPECT_NEAR(wall.visibility(), 30, 1e-9);
  const Sighting unknown =
      judge(sign, Vec3(5, 0, 0), {.depth = 0.5, .low = 0.5, .high = 0.5, .covered = false});
  EXPECT_FALSE(unknown.visible || unknown.certainly);
  EXPECT_TRUE(unknown.possibly);
  EXPECT_TRUE(std::isnan(unknown.depth) && std::isnan(unknown.meanExtinction()));
  EXPECT_TRUE(std::isinf(unknown.high));
}

}  // namespace
}  // namespace volute
