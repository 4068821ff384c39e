// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <set>

#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/spatial_order.hpp"
#include "volute/tetmesh/tet_field.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

const Box3 kBox{Vec3(-1, 0.5, 2), Vec3(1, 2, 3)};

std::string errorOf(std::vector<Vec3> vertices, std::vector<Tet> tets) {
  const auto mesh = TetMesh::build(std::move(vertices), std::move(tets), "room.vtu");
  return mesh ? "" : mesh.error().message;
}

const std::vector<Vec3> kCorners{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1),
                                 Vec3(1, 1, 1)};

TEST(TetMesh, LinksFaces) {
  const auto mesh = TetMesh::build(kCorners, {{3, 1, 2, 0}, {4, 1, 2, 3}}, "two");
  ASSERT_TRUE(mesh.has_value());
  const TetMesh& two = **mesh;
  EXPECT_EQ(two.faces().size(), 7u);
  EXPECT_EQ(two.boundary().size(), 6u);
  EXPECT_EQ(two.tets()[0], (Tet{0, 1, 2, 3}));
  EXPECT_EQ(two.opposite(0), 4 + 3);  // across from vertex 0: the tet whose vertex 3 is number 4
  EXPECT_EQ(two.opposite(7), 0);
  EXPECT_EQ(two.opposite(1), TetMesh::kBoundary);
  EXPECT_DOUBLE_EQ(two.volume(0), 1.0 / 6);
}

TEST(TetMesh, FillsItsBox) {
  const auto mesh = boxMesh(kBox, {4, 3, 5}, 0.25, 1);
  double volume = 0;
  for (std::size_t t = 0; t < mesh->tets().size(); ++t)
    volume += mesh->volume(static_cast<std::int32_t>(t));
  EXPECT_NEAR(volume, kBox.size().prod(), 1e-12);
  EXPECT_EQ(mesh->boundary().size(), 4u * (12 + 15 + 20));
  EXPECT_GT(hallMesh(0.42, 1)->tets().size(), 100000u);
  for (std::size_t i = 0; i < mesh->opposites().size(); ++i) {
    const std::int32_t other = mesh->opposite(static_cast<std::int32_t>(i));
    if (other != TetMesh::kBoundary) {
      ASSERT_EQ(mesh->opposite(other), static_cast<std::int32_t>(i));
    }
  }
}

TEST(TetMesh, SaysWhatIsWrong) {
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 2, 3}}),
              HasSubstr("1 vertices belong to no tet, vertex 4"));
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 2, 5}}), HasSubstr("tet 0 has vertex 5"));
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 2, -1}}), HasSubstr("vertex -1"));
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 1, 3}}), HasSubstr("no volume"));
  EXPECT_THAT(errorOf(kCorners, {}), HasSubstr("no cells"));
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 2, 3}, {0, 1, 2, 4}}), HasSubstr("same side"));
  EXPECT_THAT(errorOf(kCorners, {{0, 1, 2, 3}, {0, 1, 2, 3}, {1, 2, 3, 4}}),
              HasSubstr("room.vtu: the face"));
  auto broken = kCorners;
  broken[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(errorOf(broken, {{0, 1, 2, 3}, {1, 2, 3, 4}}), HasSubstr("vertex 2 is at"));
}

TEST(SpatialOrder, MovesVerticesAndTets) {
  const auto mesh = boxMesh(kBox, {3, 4, 2}, 0.2, 9);
  std::vector<Vec3> vertices(mesh->vertices().rbegin(), mesh->vertices().rend());
  std::vector<Tet> tets(mesh->tets().begin(), mesh->tets().end());
  for (Tet& tet : tets) {
    for (std::int32_t& v : tet) v = static_cast<std::int32_t>(vertices.size()) - 1 - v;
  }
  const auto oldVertices = vertices;
  const auto oldTets = tets;
  const MeshOrder order = reorderInSpace(vertices, tets);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    EXPECT_EQ(vertices[i], oldVertices[order.vertexFrom[i]]);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int k = 0; k < 4; ++k)
      EXPECT_EQ(vertices[tets[t][k]], oldVertices[oldTets[order.tetFrom[t]][k]]);
  }
  EXPECT_TRUE(TetMesh::build(vertices, tets, "moved").has_value());
}

TEST(TetField, ChecksValues) {
  std::vector<float> values{1, 0, -0.5F};
  EXPECT_THAT(checkField(values, Negatives::kRefuse, "smoke").error().message,
              HasSubstr("value 2 is -0.5"));
  EXPECT_EQ(checkField(values, Negatives::kClamp, "smoke").value(), 1u);
  EXPECT_EQ(values[2], 0);
  values[1] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(checkField(values, Negatives::kClamp, "smoke").error().message, HasSubstr("value 1"));
}

TEST(TetField, AveragesCellsByVolume) {
  const auto mesh = TetMesh::build(kCorners, {{0, 1, 2, 3}, {1, 2, 3, 4}}, "two").value();
  const float cells[] = {3, 6};
  const auto points = cellToPoint(*mesh, cells, {});
  EXPECT_FLOAT_EQ(points[0], 3);
  EXPECT_FLOAT_EQ(points[4], 6);
  EXPECT_FLOAT_EQ(points[1], (3 * 1 + 6 * 2) / 3.0F);  // volumes 1/6 and 2/6
  const auto inverses = cellToPoint(*mesh, cells, {}, CellMean::kInverses);
  EXPECT_FLOAT_EQ(inverses[0], 3);
  EXPECT_FLOAT_EQ(inverses[1], 1 / ((1 / 3.0F + 2 / 6.0F) / 3));
  const float weights[] = {4, 1}, none[] = {0, 0};
  const auto weighted = cellToPoint(*mesh, cells, {}, CellMean::kValues, weights);
  EXPECT_FLOAT_EQ(weighted[1], (3 * 4 + 6 * 2) / 6.0F);
  EXPECT_EQ(cellToPoint(*mesh, cells, {}, CellMean::kValues, none)[1], 0);
}

RC_GTEST_PROP(TetMesh, SlopesGiveGradientsOfAffineFields, ()) {
  const auto mesh = boxMesh(kBox, {3, 2, 2}, 0.25, 3);
  const Vec3 slope(*rc::gen::inRange(-9, 9), *rc::gen::inRange(-9, 9), *rc::gen::inRange(-9, 9));
  std::vector<float> values;
  for (const Vec3& v : mesh->vertices()) values.push_back(static_cast<float>(slope.dot(v)));
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(mesh->tets().size()); ++t) {
    Vec3 gradient = Vec3::Zero();
    for (int k = 0; k < 4; ++k) gradient += double{values[mesh->tets()[t][k]]} * mesh->slopes(t)[k];
    RC_ASSERT((gradient - slope).norm() < 1e-4);
  }
}

TEST(TetLocator, FindsPoints) {
  const auto mesh = hallMesh(1.0, 4);
  const TetLocator locator(mesh);
  for (std::size_t t = 0; t < mesh->tets().size(); t += 7) {
    Vec3 centre = Vec3::Zero();
    for (const std::int32_t v : mesh->tets()[t]) centre += 0.25 * mesh->vertices()[v];
    ASSERT_EQ(locator.find(centre), static_cast<std::int32_t>(t));
  }
  EXPECT_EQ(locator.find(Vec3(-0.1, 1, 1)), -1);
  EXPECT_EQ(locator.find(Vec3(5.3, 3.3, 2)), -1);  // in a column
  EXPECT_GE(locator.find(mesh->vertices()[10]), 0);
}

/// All crossings by asking every tet.
double lengthByEveryTet(const TetMesh& mesh, const Segment& segment) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    const auto at = mesh.shares(static_cast<std::int32_t>(t), segment.origin);
    const auto slopes = mesh.slopes(static_cast<std::int32_t>(t));
    Interval range{segment.begin, segment.end};
    for (int k = 0; k < 4; ++k) {
      const double slope = slopes[k].dot(segment.direction);
      if (slope > 0)
        range.begin = std::max(range.begin, -at[k] / slope);
      else if (slope < 0)
        range.end = std::min(range.end, -at[k] / slope);
      else if (at[k] < 0)
        range.end = range.begin;
    }
    sum += range.length();
  }
  return sum;
}

RC_GTEST_PROP(TetLocator, CrossesWhatEveryTetSays, ()) {
  static const auto mesh = hallMesh(1.5, 5);
  static const TetLocator locator(mesh);
  const auto coordinate = [](int to) { return *rc::gen::inRange(-3000, to + 3000) / 1000.0; };
  const Vec3 from(coordinate(28000), coordinate(12000), coordinate(6000));
  const Vec3 to(coordinate(28000), coordinate(12000), coordinate(6000));
  RC_PRE((to - from).norm() > 0.1);
  const Segment segment{from, (to - from).normalized(), 0, (to - from).norm()};
  std::vector<TetCrossing> crossings;
  locator.crossings(segment, crossings);
  double sum = 0;
  for (const TetCrossing& crossing : crossings) sum += crossing.end - crossing.begin;
  RC_ASSERT(std::abs(sum - lengthByEveryTet(*mesh, segment)) < 1e-9);
}

}  // namespace
}  // namespace volute
