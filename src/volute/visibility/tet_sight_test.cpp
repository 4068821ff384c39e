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
