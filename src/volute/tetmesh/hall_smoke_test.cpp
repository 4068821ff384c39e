// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/hall_smoke.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

double most(const TetMesh& mesh, const std::vector<float>& soot, const Box3& where) {
  double most = 0;
  for (std::size_t i = 0; i < soot.size(); ++i) {
    if (where.contains(mesh.vertices()[i]))
      most = std::max<double>(most, soot[i]);
  }
  return most;
}

TEST(HallSmoke, FillsTheRoomAndThenTheHall) {
  const auto mesh = hallMesh(0.8, 1);
  const Box3 room{Vec3(21, 0, 4), Vec3(28, 12, 6)};
  const Box3 hall{Vec3(9, 0, 5), Vec3(19, 12, 6)};
  const Box3 behindCurtain{Vec3(0, 0, 5), Vec3(7, 12, 6)};
  const Box3 floor{Vec3(0, 0, 0), Vec3(19, 12, 1)};
  const auto at = [&](double time, const Box3& where) {
    return most(*mesh, hallSmoke(mesh->vertices(), time, 1), where);
  };
  EXPECT_EQ(at(0, room), 0);
  EXPECT_GT(at(30, room), 0.05);
  EXPECT_LT(at(15, hall), 1e-3);
  EXPECT_GT(at(80, hall), 0.01);
  EXPECT_LT(at(40, behindCurtain), 5e-3);
  EXPECT_GT(at(120, behindCurtain), 0.01);
  EXPECT_LT(at(50, floor), 5e-3);
}

TEST(HallSmoke, IsSootInAnyState) {
  const auto mesh = hallMesh(1.2, 1);
  for (const double time : {0.0, 3.0, 22.0, 23.0, 60.0, 1e6}) {
    for (const float value : hallSmoke(mesh->vertices(), time, 7)) {
      EXPECT_TRUE(std::isfinite(value));
      EXPECT_GE(value, 0);
      EXPECT_LT(value, 3);
    }
  }
  EXPECT_EQ(hallSmoke(mesh->vertices(), 50, 7), hallSmoke(mesh->vertices(), 50, 7));
  EXPECT_NE(hallSmoke(mesh->vertices(), 50, 7), hallSmoke(mesh->vertices(), 50, 8));
}

}  // namespace
}  // namespace volute
