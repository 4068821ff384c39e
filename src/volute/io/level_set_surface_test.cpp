// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/level_set_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "volute/io/surface_file.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr int kVoxels = 40;
constexpr double kRadius = 0.3;

VolumeInfo volume() {
  VolumeInfo info;
  info.frames = 1;
  info.x = info.y = info.z = kVoxels;
  info.bounds = {Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)};
  info.fillDefaults();
  return info;
}

/// Distances to a sphere in a band of three voxels; the inside beyond it in leaves.
Bricks sphere() {
  const VolumeInfo info = volume();
  const double voxel = info.voxelSize().x(), band = 3 * voxel;
  std::vector<float> values;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const Vec3 at = info.bounds.min + voxel * Vec3(x + 0.5, y + 0.5, z + 0.5);
        values.push_back(static_cast<float>(std::clamp(at.norm() - kRadius, -band, band)));
      }
  const auto background = static_cast<float>(band);
  return Bricks::fromDense(info, values, {background, background, background});
}

using Corner = std::tuple<double, double, double>;

Corner cornerOf(const Vec3& at) {
  return {at.x(), at.y(), at.z()};
}

std::shared_ptr<const LevelSetSurface> surfaceOf(const Bricks& bricks,
                                                 const std::optional<GridMatrix>& place = {}) {
  auto surface = LevelSetSurface::make(bricks, volume(), place, 1 << 30);
  EXPECT_TRUE(surface.has_value());
  return surface.value_or(nullptr);
}

std::vector<Triangle> piecesOf(const CurvedSurface& surface) {
  std::vector<Triangle> triangles;
  surface.addTriangles(3, triangles);
  return triangles;
}

TEST(LevelSetSurface, PiecesAreClosedAndWhereTheDistanceIsZero) {
  const auto surface = surfaceOf(sphere());
  std::map<std::pair<Corner, Corner>, int> edges;
  double area = 0, farthest = 0;
  Box3 around;
  for (const Triangle& triangle : piecesOf(*surface)) {
    EXPECT_EQ(triangle.material, 3u);
    EXPECT_GE(triangle.normal().dot(triangle.corners[0]), 0);
    area += 0.5 * triangle.normal().norm();
    for (int i = 0; i < 3; ++i) {
      const Vec3& from = triangle.corners[i];
      around.extend(from);
      farthest = std::max(farthest, std::abs(from.norm() - kRadius));
      const Corner a = cornerOf(from), b = cornerOf(triangle.corners[(i + 1) % 3]);
      if (a != b)
        ++edges[std::minmax(a, b)];
    }
  }
  // Trilinear distances are off by about voxel^2 / (4 radius).
  const double voxel = 1.0 / kVoxels;
  EXPECT_LT(farthest, voxel * voxel / (2 * kRadius));
  EXPECT_NEAR(area, 4 * std::numbers::pi * kRadius * kRadius, 0.005 * area);
  for (const auto& [edge, count] : edges) EXPECT_EQ(count % 2, 0);
  EXPECT_GE((around.min - surface->bounds().min).minCoeff(), 0);
  EXPECT_GE((surface->bounds().max - around.max).minCoeff(), 0);
  EXPECT_LT((surface->bounds().size() - around.size()).maxCoeff(), 2 * voxel);
}

Mat3 sheared() {
  return turnAbout(Vec3(1, 2, 3).normalized(), 0.7) * Mat3(1, 0.4, 0, 0, 1.5, 0.2, 0, 0, -2);
}

/// The trilinear distance at a place among voxels; NaN where a voxel has none.
double distanceAt(const Bricks& bricks, const Vec3& at) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    VoxelIndex voxel{}, origin{};
    for (int axis = 0; axis < 3; ++axis) {
      const double low = std::floor(at[axis]);
      const int side = corner >> axis & 1;
      weight *= side ? at[axis] - low : 1 - (at[axis] - low);
      const auto i = static_cast<std::size_t>(axis);
      voxel[i] = static_cast<std::int64_t>(low) + side;
      origin[i] = voxel[i] >> 3 << 3;
    }
    const std::size_t leaf = bricks.find(origin);
    if (leaf == bricks.leaves().size())
      return std::numeric_limits<double>::quiet_NaN();
    sum += weight *
           bricks.values(leaf)[static_cast<std::size_t>(
               ((voxel[2] - origin[2]) * 8 + voxel[1] - origin[1]) * 8 + voxel[0] - origin[0])];
  }
  return sum;
}

/// Nothing is met before it is crossed, and nothing crossed is passed over, in a ball and in noise
/// whose cells have several sheets, turned, sheared and mirrored.
TEST(LevelSetSurface, RaysMeetItWhereTheDistanceIsZero) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<float> noise(kVoxels * kVoxels * kVoxels);
  for (float& value : noise) value = static_cast<float>(number(random));
  const GridMatrix place = gridMatrix(sheared(), Vec3(5, -3, 2));
  const Vec3 voxel = volume().voxelSize();
  for (const Bricks& bricks : {sphere(), Bricks::fromDense(volume(), noise, {2, 2, 2})}) {
    const auto surface = surfaceOf(bricks, place);
    int met = 0;
    for (int ray = 0; ray < 400; ++ray) {
      const auto point = [&] {
        return Vec3(sheared() * (0.8 * Vec3(number(random), number(random), number(random))) +
                    Vec3(5, -3, 2));
      };
      const Vec3 from = point(), to = point();
      const Segment segment{from, (to - from).normalized(), 0, (to - from).norm()};
      const auto distance = [&](double s) {
        const Vec3 own = sheared().inverse() * (segment.at(s) - Vec3(5, -3, 2));
        return distanceAt(bricks,
                          (own - volume().bounds.min).cwiseQuotient(voxel) - Vec3::Constant(0.5));
      };
      const auto hit = surface->nearest(segment);
      met += hit.has_value();
      const double end = hit.value_or(segment.end);
      constexpr int kSteps = 4000;
      double last = distance(0);
      for (int i = 1; i <= kSteps; ++i) {
        const double s = end * (i - 0.01) / kSteps, now = distance(s);
        ASSERT_FALSE(last * now < 0 && s < end - 1e-9) << "passed over at " << s << " of " << end;
        last = now;
      }
      if (hit) {
        EXPECT_LT(std::abs(distance(*hit)), 1e-9);
      }
    }
    EXPECT_GT(met, 50);
  }
}

/// Of a ball: within a degree, from outside and from inside.
TEST(LevelSetSurface, NormalsAreThoseOfTheBall) {
  const auto still = surfaceOf(sphere());
  const auto moved = still->moved(Mat4(2, 0, 0, 1, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1));
  std::mt19937 random(7);
  std::normal_distribution<double> number;
  for (int i = 0; i < 500; ++i) {
    const Vec3 way = Vec3(number(random), number(random), number(random)).normalized();
    for (const double sign : {-1.0, 1.0}) {
      const Segment segment{Vec3(way * (sign < 0 ? 1 : 0)), sign * way, 0, 2};
      const auto hit = still->nearest(segment);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(segment.at(*hit).norm(), kRadius, 1e-3);
      const Vec3 normal = still->outward(segment, *hit);
      EXPECT_NEAR(normal.norm(), 1, 1e-12);
      EXPECT_GT(normal.dot(way), std::cos(1.0 / 180 * std::numbers::pi));
    }
    const Segment there{2 * way + Vec3(1, 0, 0), -way, 0, 2};
    const auto hit = moved->nearest(there);
    ASSERT_TRUE(hit);
    EXPECT_NEAR((there.at(*hit) - Vec3(1, 0, 0)).norm(), 2 * kRadius, 2e-3);
  }
}

TEST(LevelSetSurface, MovesWithTheMatrixAndIsRefusedWhereItIsTooLarge) {
  const Mat3 stretched = Vec3(1, 2, 3).asDiagonal();
  const auto surface = surfaceOf(sphere(), gridMatrix(stretched, Vec3(5, 0, 0)));
  EXPECT_GT(piecesOf(*surface).size(), 4000u);
  for (const Triangle& triangle : piecesOf(*surface))
    for (const Vec3& corner : triangle.corners)
      EXPECT_NEAR((corner - Vec3(5, 0, 0)).cwiseQuotient(Vec3(1, 2, 3)).norm(), kRadius, 1e-3);
  EXPECT_EQ(LevelSetSurface::make(sphere(), volume(), std::nullopt, 1000).error().code,
            ErrorCode::kTooLarge);
}

#if VOLUTE_HAS_VDB

TEST(LevelSetSurface, IsReadFromAFile) {
  const testing::TempFolder folder;
  GridTarget target{volume(), {}};
  target.info.name = "hull";
  target.description.type = "float";
  target.description.gridClass = "level set";
  const Bricks bricks = sphere();
  target.description.background[0] = bricks.background()[0];
  GridTarget fog{volume(), {.type = "float", .gridClass = "fog volume"}};
  ASSERT_VALUE(auto sink, createCacheSink(folder / "a.vdb", {fog, target}, {}));
  const std::vector<Bricks> both{
      Bricks::fromDense(fog.info, std::vector<float>(kVoxels * kVoxels * kVoxels, 1.0F)), bricks};
  ASSERT_TRUE(sink->writeFrame(both).has_value());
  ASSERT_TRUE(sink->finish().has_value());
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.vdb"));
  EXPECT_EQ(mesh.materials.size(), 1u);
  ASSERT_EQ(mesh.curved.size(), 1u);
  const auto triangles = piecesOf(*mesh.curved[0].surface);
  ASSERT_GT(triangles.size(), 1000u);
  for (const Triangle& triangle : triangles)
    for (const Vec3& corner : triangle.corners) EXPECT_NEAR(corner.norm(), kRadius, 2e-3);
  EXPECT_EQ(readSurfaces(folder / "a.vdb", 100000).error().code, ErrorCode::kTooLarge);

  ASSERT_VALUE(auto other, createCacheSink(folder / "b.vdb", {fog}, {}));
  ASSERT_TRUE(other->writeFrame(std::span(both).first(1)).has_value());
  ASSERT_TRUE(other->finish().has_value());
  const auto refused = readSurfaces(folder / "b.vdb");
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("has no level set"), std::string::npos);
}

#endif

}  // namespace
}  // namespace volute
