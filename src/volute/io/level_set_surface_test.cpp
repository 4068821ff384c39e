// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/level_set_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "volute/io/surface_file.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"

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

TEST(LevelSetSurface, IsClosedAndWhereTheDistanceIsZero) {
  const Bricks bricks = sphere();
  std::vector<Triangle> triangles;
  ASSERT_TRUE(addLevelSet(bricks, volume(), std::nullopt, 3, 1 << 30, triangles).has_value());
  std::map<std::pair<Corner, Corner>, int> edges;
  double area = 0, farthest = 0;
  for (const Triangle& triangle : triangles) {
    EXPECT_EQ(triangle.material, 3u);
    area += 0.5 * triangle.normal().norm();
    for (int i = 0; i < 3; ++i) {
      const Vec3& from = triangle.corners[i];
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
}

TEST(LevelSetSurface, MovesWithTheMatrixAndIsRefusedWhereItIsTooLarge) {
  const Bricks bricks = sphere();
  const Mat3 stretched = Vec3(1, 2, 3).asDiagonal();
  std::vector<Triangle> triangles;
  const GridMatrix place = gridMatrix(stretched, Vec3(5, 0, 0));
  ASSERT_TRUE(addLevelSet(bricks, volume(), place, 0, 1 << 30, triangles).has_value());
  for (const Triangle& triangle : triangles)
    for (const Vec3& corner : triangle.corners)
      EXPECT_NEAR((corner - Vec3(5, 0, 0)).cwiseQuotient(Vec3(1, 2, 3)).norm(), kRadius, 1e-3);
  triangles.clear();
  EXPECT_EQ(addLevelSet(bricks, volume(), std::nullopt, 0, 1000, triangles).error().code,
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
  ASSERT_GT(mesh.triangles.size(), 1000u);
  for (const Triangle& triangle : mesh.triangles)
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
