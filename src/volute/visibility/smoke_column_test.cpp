// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/smoke_column.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace volute {
namespace {

using ::testing::HasSubstr;

using SmokeOver = std::function<double(double time, const Vec3& point)>;

/// A room of 12 x 10 m, from x = 20 and y = 0, whose eyes are 2 m above its floor.
struct SmokyRoom {
  FloorPlan plan{Vec3(20.25, 0.25, 2), 0.5, 24, 20, {}};
  std::vector<std::size_t> places;
  std::vector<Vec3> eyes;
  std::vector<double> floors;

  explicit SmokyRoom(const std::function<double(const Vec3&)>& floor = [](const Vec3&) {
    return 0.0;
  }) {
    plan.places.assign(plan.size(), Place::kGas);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      if (std::isinf(floor(plan.at(i))))
        continue;
      places.push_back(i);
      eyes.push_back(plan.at(i));
      floors.push_back(floor(plan.at(i)));
    }
  }

  SmokeColumn seen(const SmokeOver& smoke, const std::vector<double>& times) const {
    SmokeColumn column(plan, places, eyes, floors);
    for (const double time : times) {
      std::vector<double> here, below;
      for (const Vec3& eye : eyes) here.push_back(smoke(time, eye));
      for (const Vec3& point : column.below()) below.push_back(smoke(time, point));
      column.update(time, here, below);
    }
    return column;
  }
};

/// Over a fire at x = 25, y = 4 m from 5 s on, and a layer that is down at the eyes after 30 s.
double smokeOfFire(double time, const Vec3& p) {
  const double width = 0.3 + 0.13 * p.z();
  const double away = (p - Vec3(25, 4, 0)).head<2>().norm() / width;
  const double column = time >= 5 ? 6 * std::exp(-away * away / 2) / (1 + 0.25 * p.z()) : 0;
  return column + 2 / (1 + std::exp((6 - 4.5 * time / 30 - p.z()) / 0.2));
}

TEST(SmokeColumn, IsWhereTheFirstSmokeReachesDownToTheFloor) {
  const SmokyRoom room;
  const SmokeColumn column = room.seen(smokeOfFire, {0, 5, 10, 15, 20, 25, 30, 35});
  const std::vector<bool> in = column.eyes();
  ASSERT_EQ(in.size(), room.eyes.size());
  for (std::size_t i = 0; i < in.size(); ++i) {
    const double away = (room.eyes[i] - Vec3(25, 4, 2)).head<2>().norm();
    EXPECT_TRUE(in[i] || away > 1.3) << away;
    EXPECT_TRUE(!in[i] || away < 3) << away;
    EXPECT_TRUE(in[i] || smokeOfFire(15, room.eyes[i]) < SmokeColumn::kSmoke);
  }
  EXPECT_THAT(column.words(), HasSubstr("x = 25.0, y = 4.0 m"));
  EXPECT_THAT(column.words(), HasSubstr("first at 5 s"));
}

TEST(SmokeColumn, IsFollowedWhileItSways) {
  const SmokyRoom room;
  const auto sways = [](double time, const Vec3& p) {
    return smokeOfFire(time, p - Vec3(time > 12 && time < 18 ? 0.35 * p.z() : 0, 0, 0));
  };
  const std::vector<bool> still = room.seen(smokeOfFire, {0, 5, 10, 15, 20}).eyes();
  const std::vector<bool> swaying = room.seen(sways, {0, 5, 10, 15, 20}).eyes();
  for (std::size_t i = 0; i < still.size(); ++i) {
    EXPECT_TRUE(swaying[i] || !still[i]);
    EXPECT_TRUE(swaying[i] || sways(15, room.eyes[i]) < 0.3);
  }
}

TEST(SmokeColumn, IsNoneOfLayersJetsAndRoomsThatFill) {
  const std::vector<double> times{0, 5, 10, 15, 20, 25, 30, 35, 40};
  const SmokyRoom room;
  // A layer that comes down on one side first, and a jet below a lintel.
  EXPECT_TRUE(room.seen(
                      [](double time, const Vec3& p) {
                        return p.z() > 4 - 0.1 * time + 0.1 * (p.x() - 20) ? 1.0 : 0.0;
                      },
                      times)
                  .eyes()
                  .empty());
  EXPECT_TRUE(room.seen(
                      [](double time, const Vec3& p) {
                        return time > 0 && p.z() > 1.7 && p.x() < 21.5 && std::abs(p.y() - 5) < 1
                                   ? 0.8
                                   : 0.0;
                      },
                      times)
                  .eyes()
                  .empty());
  // All of it at once, and a closet of 2 x 2 m whose door is open, at once from floor to ceiling.
  EXPECT_TRUE(room.seen([](double time, const Vec3&) { return 0.1 * time; }, times).eyes().empty());
  const SmokyRoom closet([](const Vec3& p) {
    const bool wall = p.x() < 22.5 && p.y() < 2.5 && (p.x() > 22 || p.y() > 2);
    return wall && !(p.x() > 22 && p.y() < 0.5) ? std::numeric_limits<double>::infinity() : 0.0;
  });
  EXPECT_TRUE(
      closet
          .seen([](double time,
                   const Vec3& p) { return time > 0 && p.x() < 22 && p.y() < 2 ? 1.0 : 0.0; },
                times)
          .eyes()
          .empty());
}

TEST(SmokeColumn, IsNoneThatComesUpFromALowerStorey) {
  const SmokyRoom hole([](const Vec3& p) {
    return (p - Vec3(25, 4, p.z())).norm() < 0.8 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  });
  EXPECT_TRUE(hole.seen(smokeOfFire, {0, 5, 10, 15}).eyes().empty());
}

TEST(SmokeColumn, IsNoneAfterOtherSmoke) {
  const SmokyRoom room;
  const auto late = [](double time, const Vec3& p) {
    return smokeOfFire(time - 5, p) + (time >= 5 && p.x() < 22 && p.z() > 1.5 ? 1 : 0);
  };
  EXPECT_TRUE(room.seen(late, {0, 5, 10, 15, 20}).eyes().empty());
}

TEST(SmokeColumn, IsNoneWhereTheSmokeIsNotKnown) {
  const SmokyRoom room;
  const auto layer = [](double time, const Vec3& p) {
    return p.z() < 1.8 ? std::numeric_limits<double>::quiet_NaN() : smokeOfFire(time, p);
  };
  EXPECT_TRUE(room.seen(layer, {0, 5, 10, 15}).eyes().empty());
}

}  // namespace
}  // namespace volute
