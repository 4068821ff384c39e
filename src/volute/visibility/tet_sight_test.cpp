// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/tet_sight.hpp"

#include <gtest/gtest.h>

#include <random>

#include "volute/tetmesh/made_meshes.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {
namespace {

Sight look(const SightSnapshot& snapshot, const SightLine& line) {
  Sight sight;
  snapshot.look({&line, 1}, {&sight, 1});
  return sight;
}

TetSightSnapshot snapshotOf(const std::shared_ptr<const TetMesh>& mesh, std::vector<float> field) {
  return {std::make_shared<const TetLocator>(mesh), std::move(field)};
}

TEST(TetSight, ALinearFieldIsExact) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 4, 3)}, {6, 4, 3}, 0.2, 5);
  std::vector<float> field;
  const auto value = [](const Vec3& p) { return 0.5 + 0.1 * p[0] - 0.05 * p[1] + 0.2 * p[2]; };
  for (const Vec3& vertex : mesh->vertices()) field.push_back(static_cast<float>(value(vertex)));
  const TetSightSnapshot snapshot = snapshotOf(mesh, field);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.01, 0.99);
  for (int i = 0; i < 500; ++i) {
    const auto point = [&] {
      return Vec3(6 * share(random), 4 * share(random), 3 * share(random));
    };
    const SightLine line{point(), point()};
    const Sight sight = look(snapshot, line);
    EXPECT_NEAR(sight.depth, line.length() * value(0.5 * (line.eye + line.target)), 2e-6);
    EXPECT_FALSE(sight.blocked);
    EXPECT_TRUE(sight.covered);
  }
  const Vec3 centre(3, 2, 1.5);
  double k = 0;
  snapshot.extinction({&centre, 1}, {&k, 1});
  EXPECT_NEAR(k, value(centre), 1e-6);
}

TEST(TetSight, AThinWallIsOpaqueAndAFloor) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 4, 3)}, {6, 4, 3}, 0, 5);
  const std::vector<ThinWall> walls{{Vec3(3, 0, 0), Vec3(3, 2, 0), Vec3(3, 2, 3)},
                                    {Vec3(3, 0, 0), Vec3(3, 2, 3), Vec3(3, 0, 3)},
                                    {Vec3(0, 2, 1), Vec3(2, 2, 1), Vec3(0, 4, 1)}};
  const std::vector<float> field(mesh->vertices().size(), 0.5F);
  const auto locator = std::make_shared<const TetLocator>(
      mesh, std::make_shared<const std::vector<ThinWall>>(walls));
  const TetSightSnapshot snapshot(locator, field);
  const auto blocked = [&](const Vec3& eye, const Vec3& target) {
    const Sight sight = look(snapshot, {eye, target});
    EXPECT_NEAR(sight.depth, 0.5 * (target - eye).norm(), 1e-6);
    Sight weighed;
    std::vector<SightWeight> weights;
    snapshot.weigh({eye, target}, weights, weighed);
    EXPECT_EQ(weighed.blocked, sight.blocked);
    return sight.blocked;
  };
  EXPECT_TRUE(blocked(Vec3(1, 1, 1.5), Vec3(5, 1, 1.5)));
  EXPECT_TRUE(blocked(Vec3(1, 1, 1.5), Vec3(5, 1.3, 1.2)));
  EXPECT_FALSE(blocked(Vec3(1, 3, 1.5), Vec3(5, 3, 1.5))) << "beside it";
  EXPECT_FALSE(blocked(Vec3(1, 1, 1.5), Vec3(3, 1, 1.5))) << "a sign on it";
  const Vec3 points[] = {Vec3(3, 1, 1.5), Vec3(3, 3, 1.5), Vec3(3.01, 1, 1.5)};
  Place places[3];
  snapshot.places(points, places);
  EXPECT_EQ(places[0], Place::kSolid);
  EXPECT_EQ(places[1], Place::kGas);
  EXPECT_EQ(places[2], Place::kGas);
  const Vec3 eyes[] = {Vec3(0.5, 2.5, 2.6), Vec3(5, 2.5, 2.6)};
  double floors[2];
  snapshot.floors(eyes, 3, floors);
  EXPECT_NEAR(floors[0], 1, 1e-9);
  EXPECT_NEAR(floors[1], 0, 0.11);
}

TEST(TetSight, CellsThatTouchWithoutCommonPointsAreFound) {
  std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  EXPECT_FALSE(TetLocator(TetMesh::build(points, {{0, 1, 2, 3}}, "one").value()).openContact());
  for (const Vec3& point : {Vec3(0, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    points.push_back(point);
  const auto two = TetMesh::build(points, {{0, 1, 2, 3}, {4, 5, 6, 7}}, "two").value();
  const auto place = TetLocator(two).openContact();
  ASSERT_TRUE(place);
  EXPECT_EQ(place->x(), 0);
  const auto wall = std::make_shared<const std::vector<ThinWall>>(
      std::vector{ThinWall{points[0], points[2], points[3]}});
  EXPECT_FALSE(TetLocator(two, wall).openContact());
}

TEST(TetSight, TheWalkEqualsTheSlowWayInAHallWithColumns) {
  const auto mesh = hallMesh(1.0, 2);
  const TetSightSnapshot snapshot = snapshotOf(mesh, plume(*mesh, 3, 2));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(-0.02, 1.02);
  int blocked = 0, outside = 0;
  for (int i = 0; i < 1500; ++i) {
    const auto point = [&] {
      const Vec3 shares(share(random), share(random), share(random));
      return Vec3(mesh->bounds().min + shares.cwiseProduct(mesh->bounds().size()));
    };
    const SightLine line{point(), point()};
    const Sight fast = look(snapshot, line), slow = snapshot.lookSlowly(line);
    ASSERT_NEAR(fast.depth, slow.depth, 1e-9 + 1e-9 * slow.depth);
    ASSERT_EQ(fast.blocked, slow.blocked);
    ASSERT_EQ(fast.covered, slow.covered);
    blocked += fast.blocked, outside += !fast.covered;
  }
  EXPECT_GT(blocked, 50);
  EXPECT_GT(outside, 50);
}

TEST(TetSight, LinesThroughVerticesAndAlongEdgesAreNotLost) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(4, 4, 4)}, {4, 4, 4}, 0, 1);
  const TetSightSnapshot snapshot =
      snapshotOf(mesh, std::vector<float>(mesh->vertices().size(), 0.25F));
  for (const Vec3& target : {Vec3(4, 4, 4), Vec3(4, 0, 0), Vec3(0, 4, 4), Vec3(4, 4, 0)}) {
    const Vec3 eye = Vec3(4, 4, 4) - target;
    const Sight sight = look(snapshot, {eye, target});
    EXPECT_NEAR(sight.depth, 0.25 * (target - eye).norm(), 1e-6);
    EXPECT_FALSE(sight.blocked);
  }
}

TEST(Lookout, WorkedOutLinesGiveTheSameAtEachTime) {
  const auto mesh = hallMesh(1.2, 2);
  const auto locator = std::make_shared<const TetLocator>(mesh);
  SafetySign sign;
  sign.position = mesh->bounds().centre();
  sign.law = visibilityLaw("jin-emitting").value();
  const std::vector<SightTarget> signs{{sign, sign.position}};
  std::vector<Vec3> eyes;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 at(share(random), share(random), share(random));
    eyes.emplace_back(mesh->bounds().min + at.cwiseProduct(mesh->bounds().size()));
  }
  // Enough memory, and next to none.
  for (const std::uint64_t most : {std::uint64_t{1} << 24, std::uint64_t{1000}}) {
    Lookout lookout(most);
    for (int t = 0; t < 4; ++t) {
      if (t == 3)
        eyes.pop_back();  // other eyes: nothing that is kept fits
      const TetSightSnapshot snapshot(locator, plume(*mesh, 3.0 + t, 2), 1);
      std::vector<Sighting> found(eyes.size()), expected(eyes.size());
      lookout.look(snapshot, signs, eyes, found, true);
      lookAround(snapshot, signs, eyes, expected);
      for (std::size_t i = 0; i < eyes.size(); ++i) {
        ASSERT_EQ(found[i].blocked, expected[i].blocked);
        ASSERT_EQ(found[i].covered, expected[i].covered);
        if (expected[i].covered) {
          ASSERT_NEAR(found[i].depth, expected[i].depth, 1e-6 * (1e-3 + expected[i].depth));
        }
      }
    }
  }
}

}  // namespace
}  // namespace volute
