// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/polygon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

using Corners = std::vector<Vec3>;

double areaOf(const Corners& corners) {
  const auto triangles = trianglesOf(corners);
  if (!triangles)
    return -1;
  double area = 0;
  for (const auto& [a, b, c] : *triangles)
    area += (corners[b] - corners[a]).cross(corners[c] - corners[a]).norm() / 2;
  return area;
}

bool covers(const Corners& corners, double x, double y) {
  const auto inside = [&](const Vec3& a, const Vec3& b) {
    return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x()) >= 0;
  };
  return std::ranges::any_of(*trianglesOf(corners), [&](const auto& t) {
    const Vec3 &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
    return inside(a, b) && inside(b, c) && inside(c, a);
  });
}

TEST(Polygon, ConcaveOnesAreTheSameFigureFromEachCorner) {
  Corners l = {{0, 0, 1}, {4, 0, 1}, {4, 1, 1}, {1, 1, 1}, {1, 4, 1}, {0, 4, 1}};
  for (std::size_t first = 0; first < l.size(); ++first) {
    std::ranges::rotate(l, l.begin() + 1);
    EXPECT_NEAR(areaOf(l), 7, 1e-12) << first;
    EXPECT_EQ(trianglesOf(l)->size(), l.size() - 2);
    EXPECT_TRUE(covers(l, 3.9, 0.5) && covers(l, 0.5, 3.9)) << first;
    EXPECT_FALSE(covers(l, 2, 2)) << first;
    Corners turned = l;
    std::ranges::reverse(turned);
    EXPECT_NEAR(areaOf(turned), 7, 1e-12) << first;
    for (Vec3& corner : turned) corner = Vec3(corner.z(), corner.x(), corner.y());
    EXPECT_NEAR(areaOf(turned), 7, 1e-12) << first;
  }
}

TEST(Polygon, ConvexOnesAreFans) {
  const Corners square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_EQ(*trianglesOf(square),
            (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(trianglesOf(Corners(5, Vec3(1, 2, 3)))->size(), 3U) << "without area";
}

TEST(Polygon, HolesThatABridgeJoinsStayOpen) {
  const Corners frame = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                         {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  EXPECT_NEAR(areaOf(frame), 12, 1e-12);
  EXPECT_FALSE(covers(frame, 2, 2));
}

TEST(Polygon, OneThatCrossesItselfEnds) {
  EXPECT_LE(trianglesOf(Corners{{0, 0, 0}, {3, 2, 0}, {3, 0, 0}, {0, 1, 0}, {1, 3, 0}})->size(),
            3U);
  Corners star;
  for (int i = 0; i < 7; ++i)
    star.emplace_back(std::cos(6 * M_PI * i / 7), std::sin(6 * M_PI * i / 7), 0);
  EXPECT_LE(trianglesOf(star)->size(), 5U);
}

/// A comb, and a coast line, of so many corners.
TEST(Polygon, LargeOnesTakeStepsForEachCorner) {
  constexpr int kTeeth = 50'000;
  Corners comb = {{0, -1, 0}, {kTeeth, -1, 0}};
  for (int i = kTeeth; i-- > 0;) {
    comb.emplace_back(i + 0.75, 0, 0);
    comb.emplace_back(i + 0.5, 1, 0);
    comb.emplace_back(i + 0.25, 0, 0);
  }
  EXPECT_NEAR(areaOf(comb) / kTeeth, 1 + 0.25 - 0.25 / kTeeth, 1e-3);
  Corners coast;
  double area = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double angle = 2 * M_PI * i / 100'000;
    coast.push_back((10 + std::sin(300 * angle) + 0.1 * std::sin(7000 * angle)) *
                    Vec3(std::cos(angle), std::sin(angle), 0));
  }
  for (std::size_t i = 0; i < coast.size(); ++i)
    area += coast[i].cross(coast[(i + 1) % coast.size()]).z() / 2;
  EXPECT_NEAR(areaOf(coast), area, 1e-6 * area);
}

/// A bay of 30,000 corners in a wall that is a million times as long, and an outline that goes
/// around 100,000 times.
TEST(Polygon, CornersMayLieCloseTogetherOrOnEachOther) {
  constexpr int kTeeth = 10'000;
  Corners wall = {{0, -1e6, 0}, {1e6, -1e6, 0}, {1e6, 0, 0}};
  for (int i = kTeeth; i-- > 0;) {
    wall.emplace_back((i + 0.75) / kTeeth, 0, 0);
    wall.emplace_back((i + 0.5) / kTeeth, 1 + std::sin(0.01 * i), 0);
    wall.emplace_back((i + 0.25) / kTeeth, 0, 0);
  }
  EXPECT_NEAR(areaOf(wall), 1e12, 100);  // thousands of slivers a million long, each rounded
  Corners around;
  for (int i = 0; i < 300'000; ++i)
    around.push_back(Vec3(i % 3 == 1 ? 1 : 0, i % 3 == 2 ? 1 : 0, 0));
  const auto count = trianglesOf(around)->size();
  EXPECT_TRUE(count >= 1 && count < 10) << count;
}

}  // namespace
}  // namespace volute
