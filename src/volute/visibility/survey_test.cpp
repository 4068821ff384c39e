// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/survey.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/visibility/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

class Remarks final : public Progress {
 public:
  void remark(const Remark& remark) override { text_ += remark.sentence; }

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
