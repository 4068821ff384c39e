// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/shadow_intervals.hpp"

#include <gtest/gtest.h>

#include <random>

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TriangleScene soup(int count, double size) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<Triangle> triangles(count);
  for (Triangle& triangle : triangles) {
    const Vec3 middle = point();
    for (Vec3& corner : triangle.corners) corner = middle + size * (point() - Vec3::Constant(0.5));
  }
  return *TriangleScene::build(std::move(triangles), {}, TriangleScene::Execution::kReference);
}

TriangleScene plate(double x0, double x1, double z) {
  return *TriangleScene::build({{{Vec3(x0, -1, z), Vec3(x1, -1, z), Vec3(x1, 1, z)}},
                                {{Vec3(x0, -1, z), Vec3(x1, 1, z), Vec3(x0, 1, z)}}});
}

bool blocked(const TriangleScene& scene, const Vec3& from, const LightPoint& light) {
  const Vec3 way = light.far ? light.place : Vec3(light.place - from);
  const Segment segment{from, way.normalized(), 0, light.far ? kInfinity : way.norm()};
  std::uint8_t answer = 0;
  scene.occluded({&segment, 1}, {&answer, 1});
  return answer == 1;
}

/// Random points of random segments against a ray to the light each.
void expectAsRays(const TriangleScene& scene, const LightPoint& light, bool infinite) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.5, 1.5);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<Interval> dark;
  int darkPoints = 0, points = 0, wrong = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 from = point(), to = point();
    const double length = (to - from).norm();
    const Segment segment{from, (to - from) / length, infinite ? -kInfinity : 0.1,
                          infinite ? kInfinity : length};
    scene.shadows(segment, light, dark);
    for (std::size_t k = 0; k < dark.size(); ++k) {
      ASSERT_LT(dark[k].begin, dark[k].end);
      ASSERT_TRUE(dark[k].begin >= segment.begin && dark[k].end <= segment.end);
      ASSERT_TRUE(k == 0 || dark[k].begin > dark[k - 1].end);
    }
    for (int n = 0; n < 40; ++n) {
      const double s = 0.1 + (length - 0.1) * (uniform(random) + 0.5) / 2;
      bool inside = false, close = false;
      for (const Interval& part : dark) {
        inside |= s > part.begin && s < part.end;
        close |= std::abs(s - part.begin) < 1e-7 || std::abs(s - part.end) < 1e-7;
      }
      if (close || s >= length)
        continue;
      ++points, darkPoints += inside;
      wrong += inside != blocked(scene, segment.at(s), light);
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(points, 10000);
  EXPECT_GT(darkPoints, points / 20);
  EXPECT_LT(darkPoints, points - points / 20);
}

TEST(ShadowIntervals, ALightOnATriangleIsNotShadowedByIt) {
  const TriangleScene scene = plate(-1, 1, 0.7);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Interval> dark;
  for (int i = 0; i < 300; ++i) {
    const LightPoint light{Vec3(uniform(random), uniform(random), 0.7), false};
    const Vec3 from(3 * uniform(random), 3 * uniform(random), 0.6 + uniform(random));
    const Vec3 way = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
    scene.shadows({from, way, 0, 4}, light, dark);
    double length = 0;
    for (const Interval& part : dark) length += part.length();
    EXPECT_LT(length, 1e-6) << i;
  }
}

TEST(ShadowIntervals, OfASunAreWhatRaysToItSay) {
  for (const auto& scene : {soup(40, 0.5), soup(1500, 0.06)}) {
    expectAsRays(scene, {Vec3(1, -0.3, 0.8)}, false);
    expectAsRays(scene, {Vec3(0, 0, 2)}, true);
  }
}

/// Hills, closed, with a soup of leaves above: places that many triangles cover together.
std::vector<Triangle> hills(int cells, int leaves) {
  const auto corner = [&](int i, int j) {
    const double x = double(i) / cells, y = double(j) / cells;
    return Vec3(x, y, 0.25 + 0.2 * std::sin(9 * x + 2 * y) * std::cos(7 * y));
  };
  std::vector<Triangle> triangles;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      triangles.push_back({{corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)}});
      triangles.push_back({{corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)}});
    }
  }
  const TriangleScene above = soup(leaves, 0.03);
  triangles.insert(triangles.end(), above.triangles().begin(), above.triangles().end());
  return triangles;
}

TEST(ShadowIntervals, OfASunAreThoseOfTheReference) {
  const std::vector<Triangle> few = hills(12, 40), many = hills(70, 3000);
  std::vector<Triangle> slivers = hills(5, 0);
  for (int i = 0; i < 3000; ++i) {
    const double a = 0.001 * i, x = std::fmod(0.37 * i, 1.0);
    slivers.push_back({{Vec3(x, 0, a / 3), Vec3(x + 0.0004, 0, a / 3), Vec3(1 - x, 1, a / 3)}});
  }
  // Walls along the first sun, and so many long triangles that their boxes fill the scene.
  std::vector<Triangle> walls = hills(20, 40), posts = many;
  for (int i = 0; i < 40; ++i) {
    const Vec3 foot(0.02 * i, 0.9 - 0.01 * i, 0), along = 0.2 * Vec3(0.8, -0.4, 0.35);
    const Vec3 aside = i % 2 ? Vec3(0, 0, 0.3) : Vec3(1e-7, 0, 0.3);
    walls.push_back({{foot, foot + along, foot + along + aside}});
    walls.push_back({{foot, foot + along + aside, foot + aside}});
  }
  posts.insert(posts.end(), slivers.begin(), slivers.end());
  // Surfaces with holes, turned triangles, and some that are there twice.
  std::vector<Triangle> holes = many;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    if (i % 3 == 0)
      std::swap(holes[i].corners[0], holes[i].corners[1]);
  }
  for (std::size_t i = holes.size(); i-- > 0;) {
    if (i % 7 == 0)
      holes[i] = holes[(i + 40) % holes.size()];
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.2, 1.2);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (const auto& triangles : {few, many, slivers, walls, posts, holes}) {
    const auto fast = *TriangleScene::build(triangles);
    const auto reference =
        *TriangleScene::build(triangles, {}, TriangleScene::Execution::kReference);
    std::size_t found = 0;
    for (const Vec3& sun : {Vec3(0.8, -0.4, 0.35), Vec3(0, 0, 1), Vec3(-1, 0, 0.05)}) {
      for (int i = 0; i < 150; ++i) {
        const Vec3 from = point(), to = point();
        const Segment segment{from, (to - from).normalized(), 0,
                              i % 3 ? (to - from).norm() : kInfinity};
        std::vector<Interval> dark, expected;
        fast.shadows(segment, {sun}, dark);
        reference.shadows(segment, {sun}, expected);
        for (auto* parts : {&dark, &expected}) {  // walls edge-on leave rounding
          std::erase_if(*parts, [](const Interval& part) { return part.end - part.begin < 1e-9; });
        }
        ASSERT_EQ(dark.size(), expected.size()) << triangles.size();
        for (std::size_t k = 0; k < dark.size(); ++k) {
          EXPECT_NEAR(dark[k].begin, expected[k].begin, 1e-8);
          EXPECT_NEAR(dark[k].end, expected[k].end, 1e-8);
        }
        found += dark.size();
      }
    }
    EXPECT_GT(found, 300u);
  }
}

TEST(ShadowIntervals, OfALampAreWhatRaysToItSay) {
  for (const auto& scene : {soup(40, 0.5), soup(1500, 0.06)}) {
    expectAsRays(scene, {Vec3(0.5, 0.4, 0.6), false}, false);
    expectAsRays(scene, {Vec3(-2, 1, 3), false}, true);
  }
}

TEST(ShadowIntervals, OfAPlateAreItsOwnSize) {
  const Segment ray{Vec3(-5, 0.1, 0), Vec3::UnitX(), 0, 20};
  std::vector<Interval> dark;
  plate(1, 3, 2).shadows(ray, {Vec3(0, 0, 1)}, dark);
  ASSERT_EQ(dark.size(), 1u);
  EXPECT_NEAR(dark[0].begin, 6, 1e-12);
  EXPECT_NEAR(dark[0].end, 8, 1e-12);
  // At 45 degrees it falls two metres on; a lamp at twice its height makes it twice as large.
  plate(1, 3, 2).shadows(ray, {Vec3(-1, 0, 1)}, dark);
  ASSERT_EQ(dark.size(), 1u);
  EXPECT_NEAR(dark[0].begin, 8, 1e-12);
  EXPECT_NEAR(dark[0].end, 10, 1e-12);
  plate(1, 3, 2).shadows(ray, {Vec3(0, 0.1, 4), false}, dark);
  ASSERT_EQ(dark.size(), 1u);
  EXPECT_NEAR(dark[0].begin, 7, 1e-12);
  EXPECT_NEAR(dark[0].end, 11, 1e-12);
  // Below the ray, or above the lamp, it stands in nobody's light.
  plate(1, 3, -2).shadows(ray, {Vec3(0, 0, 1)}, dark);
  EXPECT_TRUE(dark.empty());
  plate(1, 3, 5).shadows(ray, {Vec3(0, 0.1, 4), false}, dark);
  EXPECT_TRUE(dark.empty());
}

TEST(ShadowIntervals, RaysThatLeadToTheLight) {
  const TriangleScene scene = plate(-1, 1, 2);
  std::vector<Interval> dark;
  const Vec3 up = Vec3::UnitZ(), from(0.2, 0.1, 0);
  const auto expect = [&](const Segment& segment, const LightPoint& light, double begin,
                          double end) {
    scene.shadows(segment, light, dark);
    ASSERT_EQ(dark.size(), 1u);
    EXPECT_NEAR(dark[0].begin, begin, 1e-12);
    EXPECT_NEAR(dark[0].end, end, 1e-12);
  };
  expect({from, up, 0.5, 9}, {up}, 0.5, 2);
  expect({from, up, 0.5, 1}, {up}, 0.5, 1);
  expect({from, -up, -9, 3}, {up}, -2, 3);
  expect({from, up, 0, 9}, {from + 4 * up, false}, 0, 2);
  expect({from, up, 0, 9}, {from + up, false}, 2, 9);
  scene.shadows({from, up, 3, 9}, {up}, dark);
  EXPECT_TRUE(dark.empty());
}

}  // namespace
}  // namespace volute
