// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/timeline.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

Timeline threeFrames() {
  Timeline timeline;
  timeline.setTimes({1, 1.5, 2.5});
  return timeline;
}

TEST(Timeline, SeeksWithinItsFrames) {
  Timeline timeline = threeFrames();
  EXPECT_EQ(timeline.time(), 1);
  timeline.seek(1.7);
  EXPECT_EQ(timeline.frame(), 1);
  timeline.seek(99);
  EXPECT_EQ(timeline.time(), 2.5);
  timeline.seek(-99);
  EXPECT_EQ(timeline.time(), 1);
  EXPECT_EQ(timeline.frame(), 0);
}

TEST(Timeline, PlaysAtItsSpeedAndBeginsAgain) {
  Timeline timeline = threeFrames();
  timeline.advance(1);
  EXPECT_EQ(timeline.time(), 1) << "it does not play yet";
  timeline.play(true);
  timeline.setSpeed(2);
  timeline.advance(0.5);
  EXPECT_DOUBLE_EQ(timeline.time(), 2);
  timeline.advance(0.7);  // the last frame lasts a second, as the one before it
  EXPECT_DOUBLE_EQ(timeline.time(), 3.4);
  EXPECT_EQ(timeline.frame(), 2);
  timeline.advance(0.1);
  EXPECT_NEAR(timeline.time(), 1.1, 1e-12);
}

TEST(Timeline, StepsFromFrameToFrameAndStops) {
  Timeline timeline = threeFrames();
  timeline.play(true);
  timeline.step(1);
  EXPECT_FALSE(timeline.playing());
  EXPECT_EQ(timeline.time(), 1.5);
  timeline.step(5);
  EXPECT_EQ(timeline.time(), 2.5);
  timeline.step(-1);
  EXPECT_EQ(timeline.time(), 1.5);
}

TEST(Timeline, ShowsWholeFramesWhileItPlays) {
  Timeline timeline = threeFrames();
  timeline.seek(1.2);
  EXPECT_EQ(timeline.snapshotTime(), 1.2) << "at rest as a person says";
  timeline.play(true);
  EXPECT_EQ(timeline.snapshotTime(), 1);
  EXPECT_EQ(timeline.ahead(5), (std::vector<double>{1.5, 2.5}));
  timeline.seek(2.6);
  EXPECT_EQ(timeline.snapshotTime(), 2.5);
  EXPECT_EQ(timeline.ahead(1), (std::vector<double>{1}));
}

TEST(Timeline, ShowsTwentyFiveSnapshotsASecondOfWhatIsInterpolated) {
  Timeline timeline;
  timeline.setTimes({0, 10});
  timeline.setInterpolates(true);
  timeline.setSpeed(2);
  timeline.play(true);
  timeline.advance(1.01);
  EXPECT_DOUBLE_EQ(timeline.snapshotTime(), 2);
  const auto ahead = timeline.ahead(3);
  ASSERT_EQ(ahead.size(), 3);
  for (const double time : ahead) {
    timeline.seek(time + 0.03);
    EXPECT_EQ(timeline.snapshotTime(), time) << "to the last bit: snapshots are found by it";
  }
  EXPECT_DOUBLE_EQ(ahead[2], 2.24);
  timeline.seek(9.999);
  EXPECT_DOUBLE_EQ(timeline.ahead(1)[0], 10);
}

TEST(Timeline, OneFrameDoesNotPlay) {
  Timeline timeline;
  timeline.play(true);
  EXPECT_FALSE(timeline.playing());
  timeline.setTimes({});
  EXPECT_EQ(timeline.frames(), 1);
}

TEST(Timeline, TheRateIsThatOfFramesWithoutGaps) {
  Timeline timeline;
  timeline.setTimes({0.04, 0.08, 0.12, 0.2, 0.24, 0.36});
  EXPECT_NEAR(timeline.rate(), 25, 1e-9);
  timeline.setTimes({1});
  EXPECT_EQ(timeline.rate(), 0);
}

}  // namespace
}  // namespace volute
