// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/light_blockers.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

std::vector<Triangle> squareAround(const Vec3& centre, double half) {
  const Vec3 a = centre - Vec3(half, half, 0), x(2 * half, 0, 0), y(0, 2 * half, 0);
  return {{{a, a + x, a + x + y}, 0}, {{a, a + x + y, a + y}, 0}};
}

/// A roof of 8 x 8 m, 5 m above `place`.
Blocks roofAbove(const Vec3& place) {
  return blocksOf(*TriangleScene::build(squareAround(place + Vec3(0, 0, 5), 4)));
}

bool stops(const Blocks& blocks, const Vec3& from, const Vec3& direction, double length = 100) {
  const Segment segment{from, direction, 0, length};
  std::uint8_t blocked = 0;
  blocks({&segment, 1}, {&blocked, 1});
  return blocked != 0;
}

TEST(SceneGeometry, AWallShadesWhatIsNearItAlsoWhereCoordinatesAreLarge) {
  for (const Vec3& place :
       {Vec3(0, 0, 0), Vec3(500'000, 4'500'000, 120), Vec3(500'000, 5'700'000, 120)}) {
    const Blocks blocks = roofAbove(place);
    EXPECT_TRUE(stops(blocks, place + Vec3(1, 0.5, 3), Vec3::UnitZ())) << place;
    EXPECT_TRUE(stops(blocks, place + Vec3(1, 0.5, 4.99), Vec3::UnitZ())) << place;
    EXPECT_FALSE(stops(blocks, place + Vec3(1, 0.5, 3), -Vec3::UnitZ()));
    EXPECT_FALSE(stops(blocks, place + Vec3(1, 0.5, 5), Vec3::UnitZ())) << "a point on the wall";
  }
}

TEST(SceneGeometry, AShadeKeepsOffALampOverAnyGround) {
  for (const double ground : {5.0, 1e3, 1e4, 1e5}) {
    auto triangles = squareAround(Vec3(0, 0, 0), ground);
    for (const Triangle& triangle : squareAround(Vec3(0, 0, 3.9), 0.2))
      triangles.push_back(triangle);
    const Blocks blocks = blocksOf(*TriangleScene::build(std::move(triangles)));
    EXPECT_TRUE(stops(blocks, Vec3(0.1, 0.05, 1), Vec3::UnitZ(), 3)) << "a lamp 10 cm above it";
    EXPECT_FALSE(stops(blocks, Vec3(0.1, 0.05, 1), Vec3::UnitZ(), 2.9)) << "a lamp in its plane";
  }
}

}  // namespace
}  // namespace volute
