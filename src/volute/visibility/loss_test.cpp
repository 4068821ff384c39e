// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/loss.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/visibility/eyes.hpp"
#include "volute/visibility/testing.hpp"
#include "volute/visibility/verdict.hpp"

namespace volute {
namespace {

constexpr double kNeverLost = std::numeric_limits<double>::infinity();

std::vector<SightTarget> bothSigns() {
  const SafetySign east{.name = "east",
                        .position = Vec3(30, 2, 2),
                        .normal = Vec3(-1, 0, 0),
                        .law = visibilityLaw("jin-reflecting").value(),
                        .angle = {}};
  const SafetySign west{.name = "west",
                        .position = Vec3(0, 2, 2),
                        .normal = Vec3(1, 0, 0),
                        .law = visibilityLaw("jin-emitting").value(),
                        .angle = {}};
  return {{east, east.position}, {west, west.position}};
}

/// Sightings of one sign, C = 3, head on, by their depths.
Sighting at(double depth, bool blocked = false) {
  const SightTarget sign = bothSigns()[0];
  return judge(sign.sign, Vec3(20, 2, 2),
               {.depth = depth, .low = 0.5 * depth, .high = 2 * depth, .blocked = blocked});
}

SignLoss oneLoss(const std::vector<SightTarget>& signs) {
  return SignLoss(std::span(signs).first(1), {{0}}, 1);
}

TEST(SignLoss, FollowsTheClosedFormBetweenStoredTimes) {
  const auto signs = bothSigns();
  const auto plan = floorPlan(Room(0), Room::bounds(), 2, 0.5).value();
  std::vector<Vec3> eyes;
  for (std::size_t i = 0; i < plan.size(); ++i) eyes.push_back(plan.at(i));
  std::vector<Sighting> seen(eyes.size() * 2);
  SignLoss loss(signs, {{0, 1}, {0}}, eyes.size());
  for (int t = 0; t <= 100; t += 7) {
    lookAround(Room(0.01 * t), signs, eyes, seen);  // K grows by 0.01 each second
    loss.update(t, seen);
  }
  int never = 0;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const bool hidden[] = {seen[i].blocked, seen[eyes.size() + i].blocked};
    // Lost when K d > C; at 0 s behind the wall.
    const auto lost = [&](int s, double band) {
      const double distance = (eyes[i] - signs[static_cast<std::size_t>(s)].sign.position).norm();
      const double t = hidden[s] ? 0 : (s == 0 ? 3 : 8) / (0.01 * distance * band);
      return t > 98 ? kNeverLost : t;
    };
    const double east = lost(0, 1), any = std::max(east, lost(1, 1));
    if (std::isinf(any)) {
      ASSERT_EQ(loss.times(0).none[i], kNeverLost);
    } else {
      ASSERT_NEAR(loss.times(0).none[i], any, 1e-9 * (1 + any));
      ASSERT_NEAR(loss.times(0).down[i], 7 * std::floor(any / 7), 1e-9);
      ASSERT_NEAR(loss.times(0).up[i], 7 * std::ceil(any / 7), 1e-9);
    }
    if (!hidden[0] && std::isfinite(lost(0, 0.8))) {
      ASSERT_NEAR(loss.times(1).none[i], east, 1e-9 * (1 + east));
      ASSERT_NEAR(loss.earliest(1).none[i], lost(0, 1.2), 1e-6 * (1 + east));
      ASSERT_NEAR(loss.latest(1).none[i], lost(0, 0.8), 1e-6 * (1 + east));
    }
    never += std::isinf(any);
  }
  EXPECT_GT(never, 0);
}

TEST(SignLoss, ADoorClosesAtItsOwnTimeAndNotBefore) {
  const auto signs = bothSigns();
  SignLoss loss = oneLoss(signs);
  loss.update(0, std::vector{at(1)});
  loss.update(13.7, std::vector{at(1.5)});        // until then
  loss.update(13.7, std::vector{at(1.5, true)});  // from then on
  loss.update(20, std::vector{at(2, true)});
  for (const RoundTime round : {RoundTime::kDown, RoundTime::kNone, RoundTime::kUp})
    EXPECT_EQ(loss.times(0).by(round)[0], 13.7);
}

/// A sign behind a shutter: from where none is in sight nothing is lost until one is.
TEST(SignLoss, ALossBeginsWhereASignComesIntoSight) {
  const auto signs = bothSigns();
  const Sighting shut = at(1, true);
  SignLoss loss = oneLoss(signs);
  loss.update(0, std::vector{shut});
  loss.update(5, std::vector{shut});
  EXPECT_FALSE(loss.inSight(0)[0]);
  EXPECT_EQ(loss.times(0).up[0], 0);  // while none is
  loss.update(5, std::vector{at(1)});
  loss.update(10, std::vector{at(5)});
  EXPECT_TRUE(loss.inSight(0)[0]);
  EXPECT_TRUE(loss.inSightLater(0)[0]);
  EXPECT_EQ(loss.times(0).down[0], 5);
  EXPECT_DOUBLE_EQ(loss.times(0).none[0], 7.5);
  EXPECT_EQ(loss.times(0).up[0], 10);
  // Into smoke.
  SignLoss late = oneLoss(signs);
  late.update(0, std::vector{shut});
  late.update(5, std::vector{shut});
  late.update(5, std::vector{at(9)});
  EXPECT_EQ(late.times(0).down[0], 5);
  EXPECT_EQ(late.times(0).up[0], 5);
  // Where it is not known whether it is seen then, nothing was lost before.
  SignLoss open = oneLoss(signs);
  open.update(0, std::vector{shut});
  open.update(5, std::vector{judge(signs[0].sign, Vec3(20, 2, 2), {.covered = false})});
  EXPECT_EQ(open.times(0).known[0], 5);
  // What is not known after the end is not known of it alone.
  SignLoss kept = oneLoss(signs);
  kept.update(0, std::vector{shut});
  kept.update(5, std::vector{shut});
  kept.loseRest();
  EXPECT_TRUE(kept.times(0).complete(0));
  kept.update(6, std::vector{at(1)});
  kept.loseRest();
  EXPECT_EQ(kept.times(0).known[0], 6);
}

TEST(SignLoss, TheFirstLossCountsThoughItIsSeenAgain) {
  const auto signs = bothSigns();
  SignLoss loss = oneLoss(signs);
  loss.update(0, std::vector{at(2)});
  loss.update(10, std::vector{at(4)});
  loss.update(20, std::vector{at(0)});
  EXPECT_EQ(loss.times(0).down[0], 0);
  EXPECT_DOUBLE_EQ(loss.times(0).none[0], 5);
  EXPECT_EQ(loss.times(0).up[0], 10);
  EXPECT_DOUBLE_EQ(loss.earliest(0).none[0], 0);  // 2 x 2 > 3
  EXPECT_EQ(loss.latest(0).none[0], kNeverLost);  // 0.5 x 4 < 3
}

/// One sign is lost before the other comes into view: for a while none is seen.
TEST(SignLoss, AGapBetweenTwoSignsIsALoss) {
  auto signs = bothSigns();
  signs[1].sign = signs[0].sign;
  SignLoss loss(signs, {{0, 1}}, 1);
  loss.update(0, std::vector{at(2), at(9)});
  loss.update(10, std::vector{at(7), at(1)});
  EXPECT_DOUBLE_EQ(loss.times(0).none[0], 2);
  SignLoss joined(signs, {{0, 1}}, 1);
  joined.update(0, std::vector{at(2), at(5)});
  joined.update(10, std::vector{at(4), at(0)});  // until 5, from 4 on
  EXPECT_EQ(joined.times(0).none[0], kNeverLost);
}

TEST(SignLoss, WhatIsNeverSeenIsLostAtOnce) {
  const auto signs = bothSigns();
  SignLoss loss = oneLoss(signs);
  loss.update(3, std::vector{at(9)});
  loss.update(10, std::vector{at(1)});
  EXPECT_EQ(loss.times(0).down[0], 3);
  EXPECT_EQ(loss.times(0).up[0], 3);
  // Unknown smoke is not clear air.
  SignLoss unknown = oneLoss(signs);
  Sighting outside = judge(signs[0].sign, Vec3(20, 2, 2), {.covered = false});
  unknown.update(0, std::vector{at(1)});
  unknown.update(10, std::vector{outside});
  EXPECT_FALSE(unknown.times(0).complete(0));
  EXPECT_EQ(unknown.times(0).known[0], 0);
  EXPECT_EQ(unknown.times(0).none[0], kNeverLost);
  EXPECT_TRUE(std::isnan(unknown.times(0).answers(RoundTime::kDown)[0]));
  unknown.update(20, std::vector{at(1)});
  EXPECT_EQ(unknown.times(0).none[0], kNeverLost);
  unknown.update(30, std::vector{at(9)});  // at the latest then
  EXPECT_EQ(unknown.times(0).none[0], 30);
  EXPECT_EQ(unknown.times(0).known[0], 0);
  // What is lost before the data end is lost.
  SignLoss before = oneLoss(signs);
  before.update(0, std::vector{at(1)});
  before.update(10, std::vector{at(9)});
  before.update(20, std::vector{outside});
  EXPECT_TRUE(before.times(0).complete(0));
  EXPECT_DOUBLE_EQ(before.times(0).none[0], 2.5);
}

TEST(LevelWatch, InterpolatesAndKeepsTheFirst) {
  LevelWatch rising(3, 60), falling(1, 0.15, true);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  rising.update(0, std::vector{20.0, 20.0, 70.0});
  rising.update(10, std::vector{100.0, nan, 70.0});
  rising.update(20, std::vector{20.0, 80.0, 70.0});
  EXPECT_DOUBLE_EQ(rising.times().none[0], 5);
  EXPECT_EQ(rising.times().down[0], 0);
  EXPECT_EQ(rising.times().up[0], 10);
  EXPECT_EQ(rising.times().none[1], 20);  // at the latest: not known since when
  EXPECT_EQ(rising.times().known[1], 0);
  EXPECT_EQ(rising.times().none[2], 0);
  EXPECT_TRUE(rising.times().complete(0) && rising.times().complete(2));
  falling.update(0, std::vector{0.2});
  falling.update(10, std::vector{0.1});
  EXPECT_DOUBLE_EQ(falling.times().none[0], 5);
}

TEST(LevelWatch, SaysUntilWhenItIsKnown) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LevelWatch watch(4, 60);
  watch.update(0, std::vector{20.0, nan, 20.0, 20.0});
  watch.update(10, std::vector{30.0, nan, 80.0, 20.0});
  watch.update(20, std::vector{nan, nan, nan, 20.0});
  EXPECT_EQ(watch.times().known[0], 10);
  EXPECT_EQ(watch.times().known[1], -kNeverLost);
  EXPECT_TRUE(watch.times().complete(2));  // reached before
  EXPECT_TRUE(watch.times().complete(3));
  EXPECT_EQ(knownJson(watch.times().known[0]), Json(10.0));
  EXPECT_EQ(knownJson(watch.times().known[1]), Json(false));
  EXPECT_EQ(knownJson(watch.times().known[2]), Json(true));
}

TEST(LevelWatch, NothingIsReachedBeforeSomebodyIsThere) {
  LevelWatch watch(2, 60);
  watch.update(0, std::vector{90.0, 20.0});
  LevelWatch late(1, 60);
  late.begin(0, 30);
  late.note(0, 40, 90, {40, 40});
  EXPECT_EQ(late.times().down[0], 30);
  EXPECT_EQ(late.times().none[0], 30);
  EXPECT_EQ(late.times().up[0], 40);
  // Nor is the stored time before that of a value in between.
  LevelWatch between(1, 60);
  between.begin(0, 30);
  between.note(0, 32, 50, {20, 40});
  between.note(0, 34, 70, {20, 40});
  EXPECT_EQ(between.times().down[0], 30);
  EXPECT_EQ(between.times().none[0], 33);
  EXPECT_EQ(between.times().up[0], 40);
}

TEST(RoundTime, HasNames) {
  EXPECT_EQ(roundTime("down").value(), RoundTime::kDown);
  EXPECT_EQ(roundTime("up").value(), RoundTime::kUp);
  EXPECT_FALSE(roundTime("nearest"));
}

}  // namespace
}  // namespace volute
