// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>

#include "volute/media/fds/fds_triangle_sheets.hpp"

namespace volute {
namespace {

/// A floor of two triangles at z = 1 and a wall of one at x = 2, of other levels.
FdsIsoFrame floorAndWall() {
  return {{{0, 0, 1}, {4, 0, 1}, {4, 4, 1}, {0, 4, 1}, {2, -9, -9}, {2, 9, -9}, {2, 0, 9}},
          {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}},
          {0, 0, 1}};
}

TEST(FdsTriangleSheets, EachTakesItsShareAndHasItsColour) {
  const FdsIsoFrame frame = floorAndWall();
  const Rgb colours[] = {Rgb(1, 0.5, 0.25), Rgb(0, 1, 0)};
  const auto sheets = FdsTriangleSheets::build({&frame, 1}, colours);
  ASSERT_TRUE(sheets) << sheets.error().message;
  const Segment down{Vec3(3, 1, 3), -Vec3::UnitZ(), 0, 5};
  Radiance seen;
  sheets->radiance({&down, 1}, {&seen, 1});
  EXPECT_NEAR(seen.transmittance, 0.6, 1e-9);
  EXPECT_NEAR(seen.emitted[0], 0.4, 1e-9) << "what faces up has all of its colour";
  EXPECT_NEAR(seen.emitted[2], 0.1, 1e-9);
  // Through the common edge of two triangles: once.
  const Segment edge{Vec3(3, 3, 3), -Vec3::UnitZ(), 0, 5};
  EXPECT_EQ(sheets->crossings(edge).size(), 1U);
  // Through the floor, then through the wall, which is upright.
  const Segment both{Vec3(3.5, 1, 2), Vec3(-1, 0, -1).normalized(), 0, 5};
  ASSERT_EQ(sheets->crossings(both).size(), 2U);
  EXPECT_NEAR(sheets->crossings(both)[0].distance, std::sqrt(2), 1e-6);
  sheets->radiance({&both, 1}, {&seen, 1});
  EXPECT_NEAR(seen.transmittance, 0.36, 1e-9);
  EXPECT_NEAR(seen.emitted[0], 0.4, 1e-9);
  EXPECT_NEAR(seen.emitted[1], 0.4 * 0.5 + 0.6 * 0.4 * 0.55, 1e-6);
  double depth = 0;
  sheets->opticalDepth({&both, 1}, {&depth, 1});
  EXPECT_NEAR(depth, -2 * std::log(0.6), 1e-9);
  const Segment above{Vec3(3.5, 1, 2), Vec3::UnitY(), 0, 5};
  EXPECT_TRUE(sheets->crossings(above).empty());
}

TEST(FdsTriangleSheets, AFlatOneHasBounds) {
  FdsIsoFrame frame = floorAndWall();
  frame.triangles.resize(2);
  frame.levels.resize(2);
  const Rgb colours[] = {Rgb::Ones()};
  const auto sheets = FdsTriangleSheets::build({&frame, 1}, colours);
  ASSERT_TRUE(sheets);
  EXPECT_FALSE(sheets->bounds().empty());
  EXPECT_TRUE(sheets->bounds().contains(Vec3(1, 1, 1)));
}

TEST(FdsTriangleSheets, ManySheetsEndWhereNothingPasses) {
  FdsIsoFrame frame;
  for (int i = 0; i < 100; ++i) {
    const float z = 0.1F * static_cast<float>(i);
    const std::int32_t first = 3 * i;
    frame.vertices.insert(frame.vertices.end(), {{0, 0, z}, {9, 0, z}, {0, 9, z}});
    frame.triangles.push_back({first, first + 1, first + 2});
    frame.levels.push_back(0);
  }
  const Rgb colours[] = {Rgb::Ones()};
  const auto sheets = FdsTriangleSheets::build({&frame, 1}, colours);
  ASSERT_TRUE(sheets);
  const Segment up{Vec3(1, 1, -1), Vec3::UnitZ(), 0, 50};
  EXPECT_EQ(sheets->crossings(up).size(), 64U);
  Radiance seen;
  sheets->radiance({&up, 1}, {&seen, 1});
  EXPECT_LT(seen.transmittance, 1e-13);
  EXPECT_NEAR(seen.emitted[0], 1, 1e-9);
}

}  // namespace
}  // namespace volute
