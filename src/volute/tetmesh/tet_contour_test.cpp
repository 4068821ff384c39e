// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_contour.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

double areaOf(const ContourSurface& surface) {
  double area = 0;
  for (const auto& t : surface.triangles) {
    const Vec3& a = surface.vertices[t[0]];
    area += 0.5 * (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm();
  }
  return area;
}

TEST(ContourSlice, CutsWhereAndAsItShould) {
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(3, 4, 2)}, {5, 6, 4}, 0.25, 7);
  std::vector<float> field;
  for (const Vec3& v : mesh->vertices())
    field.push_back(static_cast<float>(1 + 2 * v.x() - v.y() + 0.5 * v.z()));
  const auto slice = contourSlice(*mesh, Vec3::UnitZ(), 0.7, field);
  EXPECT_NEAR(areaOf(slice), 12, 1e-9);
  ASSERT_EQ(slice.values.size(), slice.vertices.size());
  for (std::size_t i = 0; i < slice.vertices.size(); ++i) {
    const Vec3& v = slice.vertices[i];
    EXPECT_NEAR(v.z(), 0.7, 1e-12);
    EXPECT_NEAR(slice.values[i], 1 + 2 * v.x() - v.y() + 0.35, 1e-5);
  }
  for (const auto& t : slice.triangles) {
    const Vec3 normal = (slice.vertices[t[1]] - slice.vertices[t[0]])
                            .cross(slice.vertices[t[2]] - slice.vertices[t[0]]);
    EXPECT_LE(normal.z(), 1e-12);  // its front is where z is less
  }
}

TEST(ContourSlice, MeetsWholeFacesOnce) {
  // A regular mesh cut along its own faces, and at its border.
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(2, 2, 2)}, {2, 2, 2}, 0, 1);
  const std::vector<float> field(mesh->vertices().size(), 1);
  EXPECT_NEAR(areaOf(contourSlice(*mesh, Vec3::UnitX(), 1, field)), 4, 1e-12);
  EXPECT_NEAR(areaOf(contourSlice(*mesh, Vec3::UnitX(), 0, field)), 4, 1e-12);
  EXPECT_TRUE(contourSlice(*mesh, Vec3::UnitX(), 2, field).triangles.empty());
  EXPECT_TRUE(contourSlice(*mesh, Vec3::UnitX(), 5, field).triangles.empty());
}

TEST(ContourSurface, IsClosed) {
  const auto mesh = boxMesh({Vec3::Zero(), Vec3(2, 2, 2)}, {8, 8, 8}, 0.2, 3);
  std::vector<float> field;
  for (const Vec3& v : mesh->vertices())
    field.push_back(static_cast<float>((v - Vec3(1, 1, 1)).squaredNorm()));
  const auto ball = contourSurface(*mesh, field, 0.49);
  EXPECT_TRUE(ball.values.empty());
  EXPECT_NEAR(areaOf(ball), 4 * 3.14159265 * 0.49, 0.5);
  // Each edge is run through once in each direction, unless a triangle shrank to it.
  std::map<std::pair<int, int>, int> runs;
  for (const auto& t : ball.triangles) {
    for (int k = 0; k < 3; ++k) ++runs[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : runs) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((runs.count({edge.second, edge.first})), 1u);
  }
}

}  // namespace
}  // namespace volute
