// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/inner_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

constexpr double kInwards = 1e-3;

double distanceToWalls(const Box3& box, const Vec3& point) {
  return std::min((point - box.min).minCoeff(), (box.max - point).minCoeff());
}

TEST(InnerPoints, AreAsFarFromAllWallsOfARoom) {
  const Box3 room{Vec3(-1, 2, 0), Vec3(3, 5, 2.5)};
  const auto mesh = boxMesh(room, {4, 3, 5}, 0, 1);
  const auto inner = innerVertices(*mesh, kInwards);
  ASSERT_EQ(inner.size(), mesh->vertices().size());
  int onWalls = 0;
  for (std::size_t v = 0; v < inner.size(); ++v) {
    const Vec3& before = mesh->vertices()[v];
    if (distanceToWalls(room, before) > 1e-9) {
      EXPECT_EQ(inner[v], before);
      continue;
    }
    ++onWalls;
    EXPECT_GE(distanceToWalls(room, inner[v]), 0.999 * kInwards) << before;
    EXPECT_LE((inner[v] - before).norm(), 2.5 * kInwards) << before;
  }
  EXPECT_GT(onWalls, 50);
}

TEST(InnerPoints, OfATetAreAsFarFromItsFaces) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(1, 1, 1)}, {1, 1, 1}, 0, 1);
  for (std::int32_t tet = 0; tet < static_cast<std::int32_t>(mesh->tets().size()); ++tet) {
    const Tet& corners = mesh->tets()[tet];
    const Vec3 middle = 0.5 * (mesh->vertices()[corners[0]] + mesh->vertices()[corners[1]]);
    const auto shares = mesh->shares(tet, innerPoint(*mesh, tet, middle, kInwards));
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_GE(shares[k] / mesh->slopes(tet)[k].norm(), 0.999 * kInwards);
  }
}

TEST(InnerPoints, WallsOfFloatsAreRoundedMoreWhereCoordinatesAreLarge) {
  const Vec3 small(2, 2, 2), large(2000, 2000, 2000), far(500'000, 5'700'000, 0);
  const auto rounding = [](const Vec3& from, const Vec3& size) {
    return wallRounding(*boxMesh({from, from + size}, {1, 1, 1}, 0, 1));
  };
  EXPECT_NEAR(rounding(Vec3::Zero(), small), 3e-5, 1e-6);
  EXPECT_NEAR(rounding(far, large), 0.02 + 0.34, 1e-2);
  EXPECT_LT(rounding(far, small), 0.05) << "floats would not tell its corners apart";
  EXPECT_NEAR(rounding(far + Vec3(0.1, 0.1, 0.1), small), 3e-5, 1e-6) << "no floats";
}

}  // namespace
}  // namespace volute
