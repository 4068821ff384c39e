// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/light_blockers.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

/// A roof of 8 x 8 m, 5 m above `place`.
Blocks roofAbove(const Vec3& place) {
  const Vec3 a = place + Vec3(-4, -4, 5), x(8, 0, 0), y(0, 8, 0);
  const auto roof = TriangleScene::build({{{a, a + x, a + x + y}, 0}, {{a, a + x + y, a + y}, 0}});
  return blocksOf(*roof);
}

bool stops(const Blocks& blocks, const Vec3& from, const Vec3& direction) {
  const Segment segment{from, direction, 0, 100};
  std::uint8_t blocked = 0;
  blocks({&segment, 1}, {&blocked, 1});
  return blocked != 0;
}

TEST(SceneGeometry, AWallShadesWhatIsNearItAlsoWhereCoordinatesAreLarge) {
  for (const Vec3& place : {Vec3(0, 0, 0), Vec3(500'000, 4'500'000, 120)}) {
    const Blocks blocks = roofAbove(place);
    EXPECT_TRUE(stops(blocks, place + Vec3(1, 0.5, 3), Vec3::UnitZ())) << place;
    EXPECT_FALSE(stops(blocks, place + Vec3(1, 0.5, 3), -Vec3::UnitZ()));
    EXPECT_FALSE(stops(blocks, place + Vec3(1, 0.5, 5), Vec3::UnitZ())) << "a vertex on the wall";
  }
}

}  // namespace
}  // namespace volute
