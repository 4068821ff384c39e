// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/triangle_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

using Execution = TriangleScene::Execution;
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// Triangles of about `size` in the unit cube.
std::vector<Triangle> triangleSoup(int count, double size, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<Triangle> triangles(count);
  for (Triangle& triangle : triangles) {
    const Vec3 middle = point();
    for (Vec3& corner : triangle.corners) corner = middle + size * (point() - Vec3::Constant(0.5));
  }
  return triangles;
}

std::vector<Segment> randomSegments(int count, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 1.5);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  std::vector<Segment> segments(count);
  for (Segment& segment : segments) {
    const Vec3 from = point(), to = point();
    const double length = (to - from).norm();
    segment = {from, (to - from) / length, 0, length};
  }
  return segments;
}

/// A closed surface: a sphere of flat triangles around the origin.
std::vector<Triangle> sphere(double radius, int rows, int columns) {
  const auto at = [&](int row, int column) {
    if (row == 0 || row == rows)
      return Vec3(0, 0, row == 0 ? radius : -radius);
    const double theta = std::numbers::pi * row / rows;
    const double phi = 2 * std::numbers::pi * (column % columns) / columns;
    return Vec3(radius * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                              std::cos(theta)));
  };
  std::vector<Triangle> triangles;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      triangles.push_back({{at(r, c), at(r + 1, c), at(r + 1, c + 1)}});
      triangles.push_back({{at(r, c), at(r + 1, c + 1), at(r, c + 1)}});
    }
  }
  return triangles;
}

/// Every triangle by its plane and its three sides, one after the other: what the trees must find.
Hit bruteForce(std::span<const Triangle> triangles, const Segment& segment, double* nearEdge) {
  Hit hit;
  *nearEdge = kNoEnd;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Vec3 normal = triangles[i].normal();
    const auto& [a, b, c] = triangles[i].corners;
    const double s = normal.dot(a - segment.origin) / normal.dot(segment.direction);
    if (!(s > segment.begin && s < segment.end))
      continue;
    const Vec3 p = segment.at(s);
    const double area = normal.squaredNorm();
    const double least =
        std::min({(b - a).cross(p - a).dot(normal) / area, (c - b).cross(p - b).dot(normal) / area,
                  (a - c).cross(p - c).dot(normal) / area});
    *nearEdge = std::min(*nearEdge, std::abs(least));
    if (least >= 0 && s < hit.distance)
      hit = {s, i};
  }
  return hit;
}

class Executions : public ::testing::TestWithParam<Execution> {
 protected:
  TriangleScene build(std::vector<Triangle> triangles) const {
    return *TriangleScene::build(std::move(triangles), {}, GetParam());
  }
};

INSTANTIATE_TEST_SUITE_P(Every, Executions,
                         ::testing::Values(Execution::kFast, Execution::kReference),
                         [](const auto& info) {
                           return info.param == Execution::kFast ? "Fast" : "Reference";
                         });

TEST_P(Executions, FindsWhatBruteForceFinds) {
  const auto triangles = triangleSoup(300, 0.4);
  const TriangleScene scene = build(triangles);
  const auto segments = randomSegments(2000);
  std::vector<Hit> hits(segments.size());
  std::vector<std::uint8_t> blocked(segments.size());
  scene.nearest(segments, hits);
  scene.occluded(segments, blocked);
  int found = 0, judged = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    double nearEdge = 0;
    const Hit expected = bruteForce(triangles, segments[i], &nearEdge);
    if (nearEdge < 1e-5)
      continue;  // single precision may take the other side
    ++judged;
    found += expected.found();
    ASSERT_EQ(hits[i].found(), expected.found()) << i;
    EXPECT_EQ(blocked[i], expected.found() ? 1 : 0);
    if (!expected.found())
      continue;
    EXPECT_EQ(hits[i].triangle, expected.triangle);
    EXPECT_NEAR(hits[i].distance, expected.distance, 1e-11);
  }
  EXPECT_GT(judged, 1900);
  EXPECT_GT(found, 500);
}

TEST_P(Executions, ClosedSurfacesLeakNowhere) {
  const TriangleScene scene = build(sphere(3, 20, 40));
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Segment> segments;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 d = Vec3(normal(random), normal(random), normal(random)).normalized();
    segments.push_back({0.1 * d, d, 0, kNoEnd});
  }
  // Through the corners and along the edges, where two or more triangles meet.
  for (const Triangle& triangle : scene.triangles()) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = triangle.corners[k], &b = triangle.corners[(k + 1) % 3];
      for (double share : {0.0, 0.25, 0.5})
        segments.push_back({Vec3::Zero(), (a + share * (b - a)).normalized(), 0, kNoEnd});
    }
  }
  std::vector<std::uint8_t> blocked(segments.size());
  scene.occluded(segments, blocked);
  for (std::size_t i = 0; i < segments.size(); ++i) ASSERT_EQ(blocked[i], 1) << i;
}

TEST_P(Executions, EndsAreOpen) {
  const Triangle floor{{Vec3(-10, -10, 2), Vec3(10, -10, 2), Vec3(0, 20, 2)}};
  const TriangleScene scene = build({floor, {{Vec3(-9, 0, 9), Vec3(9, 0, 9), Vec3(0, 9, 9)}}});
  const auto blocked = [&](double begin, double end) {
    const Segment up{Vec3(0.1, 0.2, 0), Vec3::UnitZ(), begin, end};
    std::uint8_t answer = 7;
    scene.occluded({&up, 1}, {&answer, 1});
    return answer == 1;
  };
  EXPECT_TRUE(blocked(0, 3));
  EXPECT_FALSE(blocked(0, 2));
  EXPECT_FALSE(blocked(2, 5));
  EXPECT_TRUE(blocked(std::nextafter(2.0, 0), 5));
  EXPECT_TRUE(blocked(0, std::nextafter(2.0, 3)));
  EXPECT_FALSE(blocked(3, 3));
  EXPECT_TRUE(blocked(-kNoEnd, kNoEnd));
}

TEST_P(Executions, DistancesAreThoseOfDoubleFarFromTheOrigin) {
  // A metre behind a wall at 10 km: single precision there has steps of a millimetre.
  const Vec3 far(12345.678, -9876.543, 456.789);
  const auto wall = [&](double x) {
    return Triangle{{far + Vec3(x, -5, -5), far + Vec3(x, 5, -5), far + Vec3(x, 0, 8)}};
  };
  const TriangleScene scene = build({wall(0), wall(1)});
  const Segment ray{far - 3 * Vec3::UnitX(), Vec3::UnitX(), 0, kNoEnd};
  Hit hit;
  scene.nearest({&ray, 1}, {&hit, 1});
  EXPECT_EQ(hit.triangle, 0u);
  EXPECT_NEAR(hit.distance, 3, 1e-11);
}

TEST_P(Executions, LineOfOrthographicCamerasBeginsNowhere) {
  const TriangleScene scene = build(sphere(1, 12, 24));
  const Segment line{Vec3(0.01, 0.02, 50), Vec3(0, 0, -1), -kNoEnd, kNoEnd};
  Hit hit;
  scene.nearest({&line, 1}, {&hit, 1});
  ASSERT_TRUE(hit.found());
  EXPECT_NEAR(hit.distance, 49, 0.02);
}

TEST_P(Executions, NothingAndTrianglesWithoutAreaAreNotMet) {
  const TriangleScene scene = build({{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}}});
  const Segment down{Vec3(0.5, 0, 1), -Vec3::UnitZ(), 0, 9};
  Hit hit;
  scene.nearest({&down, 1}, {&hit, 1});
  EXPECT_FALSE(hit.found());
  TriangleScene().nearest({&down, 1}, {&hit, 1});
  EXPECT_FALSE(hit.found());
  EXPECT_TRUE(TriangleScene().empty());
}

TEST(TriangleScene, ManyTrianglesAnswerAsSoonAsTheyAreThere) {
  const auto triangles = triangleSoup(20'000, 0.02);
  const auto segments = randomSegments(400);
  std::vector<Hit> expected(segments.size());
  const auto reference = TriangleScene::build(triangles, {}, Execution::kReference).value();
  reference.nearest(segments, expected);
  const auto fast = TriangleScene::build(triangles).value();
  std::vector<std::vector<Hit>> found(4, std::vector<Hit>(segments.size()));
  std::vector<std::thread> threads;
  for (auto& hits : found) threads.emplace_back([&] { fast.nearest(segments, hits); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& hits : found) {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      EXPECT_EQ(hits[i].triangle, expected[i].triangle);
      if (expected[i].found()) {
        EXPECT_NEAR(hits[i].distance, expected[i].distance, 1e-9);
      }
    }
  }
  // One that nobody asks goes before its tree is there.
  EXPECT_FALSE(TriangleScene::build(triangles).value().empty());
}

/// Beside a scene, at once and while its tree is built.
TEST(TriangleScene, LeavesLoopsTheirThreads) {
  const int before = threadCount();
  for (const int count : {2, 30'000}) {
    std::vector<Triangle> triangles;
    for (int i = 0; i < count; ++i) {
      const Vec3 at(i, 0, 0);
      triangles.push_back({.corners = {at, at + Vec3::UnitX(), at + Vec3::UnitY()}});
    }
    const auto scene = TriangleScene::build(std::move(triangles));
    ASSERT_TRUE(scene);
    const Segment segments[] = {{Vec3(0.25, 0.25, 1), -Vec3::UnitZ(), 0, 2}};
    Hit hits[1];
    scene->nearest(segments, hits);
    EXPECT_TRUE(hits[0].found());
    EXPECT_EQ(threadCount(), before) << count;
  }
}

TEST(TriangleScene, TransformsMoveCorners) {
  Mat4 mirror = Mat4::Identity();
  mirror(0, 0) = -2;
  mirror(2, 3) = 5;
  const Triangle one{{Vec3(1, 2, 3), Vec3(0, 0, 0), Vec3(4, 0, 0)}, 3};
  const auto moved = transformed({&one, 1}, mirror);
  EXPECT_EQ(moved[0].corners[0], Vec3(-2, 2, 8));
  EXPECT_EQ(moved[0].material, 3u);
}

TEST(TriangleScene, WrongInputIsNamed) {
  using ::testing::HasSubstr;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto bad = TriangleScene::build({{{Vec3(0, 0, nan), Vec3(1, 0, 0), Vec3(0, 1, 0)}}});
  EXPECT_THAT(bad.error().message, HasSubstr("triangle 0"));
  const auto missing = TriangleScene::build({{{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()}, 2}});
  EXPECT_THAT(missing.error().message, HasSubstr("material 2"));
}

}  // namespace
}  // namespace volute
