// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/vertex_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

constexpr int kSpreadCells = 12;
constexpr double kSpreadEdge = 0.25;

TetLocator spreadRoom() {
  return TetLocator(boxMesh({Vec3::Zero(), Vec3::Constant(kSpreadCells * kSpreadEdge)},
                            {kSpreadCells, kSpreadCells, kSpreadCells}, 0, 1));
}

/// All that smoke as thin as air scatters, as it is drawn: linear between vertices.
double drawnLight(const TetLocator& locator, const Lamp& lamp) {
  const TetMesh& mesh = locator.mesh();
  std::vector<double> values;
  for (const Vec3& point : mesh.vertices()) values.push_back(lamp.irradiance(point)[0]);
  for (const VertexIrradiance& one : spreadIrradiance(locator, lamp))
    values[static_cast<std::size_t>(one.vertex)] = one.value[0];
  double sum = 0;
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(mesh.tets().size()); ++t) {
    for (const std::int32_t v : mesh.tets()[t])
      sum += 0.25 * mesh.volume(t) * values[static_cast<std::size_t>(v)];
  }
  return sum;
}

/// The integral of 1 / r2 over the room, by shells around the lamp: exact but for the walls' part,
/// which is found by points.
double wholeLight(const Vec3& lamp) {
  constexpr int kSteps = 120;
  constexpr double kStep = kSpreadCells * kSpreadEdge / kSteps;
  double sum = 0;
  for (int z = 0; z < kSteps; ++z) {
    for (int y = 0; y < kSteps; ++y) {
      for (int x = 0; x < kSteps; ++x) {
        const Vec3 at = kStep * Vec3(x + 0.5, y + 0.5, z + 0.5);
        sum += kStep * kStep * kStep / std::max((at - lamp).squaredNorm(), 0.05 * 0.05);
      }
    }
  }
  return sum;
}

TEST(VertexSpread, ALampIsAsStrongWhereverInItsCellItIs) {
  const TetLocator locator = spreadRoom();
  for (const Vec3& place : {Vec3(1.5, 1.5, 1.5), Vec3(1.625, 1.625, 1.625), Vec3(1.56, 1.69, 1.6),
                            Vec3(1.5, 1.625, 1.5), Vec3(1.5, 1.5, 2.99)}) {
    Lamp lamp;
    lamp.position = place;
    EXPECT_NEAR(drawnLight(locator, lamp), wholeLight(place), 0.01 * wholeLight(place)) << place;
  }
}

TEST(VertexSpread, IsNotForLampsOutsideOrAsLargeAsCells) {
  const TetLocator locator = spreadRoom();
  Lamp lamp;
  lamp.position = Vec3(1.5, 1.5, 1.5);
  EXPECT_FALSE(spreadIrradiance(locator, lamp).empty());
  lamp.radius = 0.3;
  EXPECT_TRUE(spreadIrradiance(locator, lamp).empty());
  lamp.radius = 0.05;
  lamp.position.x() = -0.01;
  EXPECT_TRUE(spreadIrradiance(locator, lamp).empty());
  lamp.position.x() = 1.5;
  lamp.kind = Lamp::Kind::kSun;
  EXPECT_TRUE(spreadIrradiance(locator, lamp).empty());
}

}  // namespace
}  // namespace volute
