// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "volute/visibility/eyes.hpp"
#include "volute/visibility/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

class Remarks final : public Progress {
 public:
  void remark(std::string_view text) override { text_ += text; }

  std::string text_;
};

std::vector<SafetySign> twoSigns() {
  return {{.name = "east",
           .position = Vec3(30, 2, 2),
           .normal = Vec3(-1, 0, 0),
           .law = visibilityLaw("jin-reflecting").value(),
           .angle = {}},
          {.name = "west",
           .position = Vec3(0, 2, 2),
           .normal = Vec3(1, 0, 0),
           .law = visibilityLaw("jin-emitting").value(),
           .angle = {}}};
}

TEST(Survey, LossTimesFollowTheClosedForm) {
  Remarks progress;
  const auto signs = placeSigns(Room(0), twoSigns(), Room::bounds(), progress).value();
  EXPECT_EQ(progress.text_, "");
  const auto plan = floorPlan(Room(0), Room::bounds(), 2, 0.5).value();
  std::vector<Vec3> eyes;
  for (std::size_t i = 0; i < plan.size(); ++i) eyes.push_back(plan.at(i));
  std::vector<Sighting> seen(eyes.size() * 2);
  LossTimes any(eyes.size()), east(eyes.size());
  const std::size_t both[] = {0, 1}, first[] = {0};
  for (int t = 0; t <= 100; ++t) {
    lookAround(Room(0.01 * t), signs, eyes, seen);  // K grows by 0.01 each second
    updateLoss(any, t, both, seen);
    updateLoss(east, t, first, seen);
  }
  int never = 0;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const double toEast = (eyes[i] - Vec3(30, 2, 2)).norm();
    const double toWest = (eyes[i] - Vec3(0, 2, 2)).norm();
    // Lost at the first whole second with K d > C; at 0 s behind the wall.
    const auto lost = [](double c, double d, double band) {
      const double t = std::floor(c / (0.01 * d * band)) + 1;
      return t > 100 ? std::numeric_limits<double>::infinity() : t;
    };
    const bool blocked = seen[i].blocked;
    const bool westBlocked = seen[eyes.size() + i].blocked;
    const double timeEast = blocked ? 0 : lost(3, toEast, 1);
    const double timeWest = westBlocked ? 0 : lost(8, toWest, 1);
    ASSERT_EQ(east.time[i], timeEast);
    ASSERT_EQ(any.time[i], std::max(timeEast, timeWest));
    if (!blocked) {
      ASSERT_EQ(east.earliest[i], lost(3, toEast, 1.2));
      ASSERT_EQ(east.latest[i], lost(3, toEast, 0.8));
    }
    never += std::isinf(any.time[i]);
  }
  EXPECT_GT(never, 0);
}

TEST(Survey, ASignInsideOfAWallIsMovedOutAndOneFartherInIsAnError) {
  Remarks progress;
  std::vector<SafetySign> signs = twoSigns();
  signs[0].position = Vec3(20.8, 7, 2);
  signs[0].normal = Vec3(1, 0, 0);
  const auto moved = placeSigns(Room(0), signs, Room::bounds(), progress).value();
  EXPECT_NEAR(moved[0].target[0], 21.0, 0.011);
  EXPECT_THAT(progress.text_, HasSubstr("'east' is inside"));
  signs[0].normal = Vec3(-1, 0, 0);
  EXPECT_THAT(placeSigns(Room(0), signs, Room::bounds(), progress).error().message,
              HasSubstr("'east' at"));
  signs[0].position = Vec3(40, 7, 2);
  EXPECT_THAT(placeSigns(Room(0), signs, Room::bounds(), progress).error().message,
              HasSubstr("0 .. 30, 0 .. 10, 0 .. 3 m"));
}

}  // namespace
}  // namespace volute
