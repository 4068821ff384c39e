// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/split_cells.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace volute {
namespace {

using ::testing::HasSubstr;

/// n^3 hexahedra of a unit cube, whose vertices are numbered at random; every second one as a
/// polyhedron, or as two wedges.
CellSoup cubes(int n, bool mixed) {
  CellSoup soup;
  std::vector<std::int64_t> number((n + 1) * (n + 1) * (n + 1));
  std::iota(number.begin(), number.end(), 0);
  std::mt19937 random(5);
  for (std::size_t i = number.size() - 1; i > 0; --i)
    std::swap(number[i], number[random() % (i + 1)]);
  soup.vertices.resize(number.size());
  const auto at = [&](int x, int y, int z) { return number[(z * (n + 1) + y) * (n + 1) + x]; };
  for (int z = 0; z <= n; ++z) {
    for (int y = 0; y <= n; ++y) {
      for (int x = 0; x <= n; ++x) soup.vertices[at(x, y, z)] = Vec3(x, y, z) / n;
    }
  }
  const auto add = [&](CellShape shape, const std::vector<std::int64_t>& cell) {
    soup.shapes.push_back(shape);
    soup.offsets.push_back(static_cast<std::int64_t>(soup.connectivity.size()));
    soup.connectivity.insert(soup.connectivity.end(), cell.begin(), cell.end());
  };
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const std::int64_t c[8] = {
            at(x, y, z),     at(x + 1, y, z),     at(x + 1, y + 1, z),     at(x, y + 1, z),
            at(x, y, z + 1), at(x + 1, y, z + 1), at(x + 1, y + 1, z + 1), at(x, y + 1, z + 1)};
        if (!mixed || (x + y + z) % 2 == 0) {
          add(CellShape::kHexahedron, {c, c + 8});
        } else {
          std::vector<std::int64_t> cell{6};
          for (const auto& f : {std::array{0, 1, 2, 3},
                                {4, 5, 6, 7},
                                {0, 1, 5, 4},
                                {1, 2, 6, 5},
                                {2, 3, 7, 6},
                                {3, 0, 4, 7}}) {
            cell.push_back(4);
            for (const int i : f) cell.push_back(c[i]);
          }
          add(CellShape::kPolyhedron, cell);
        }
      }
    }
  }
  soup.offsets.push_back(static_cast<std::int64_t>(soup.connectivity.size()));
  return soup;
}

double volumeOf(const TetMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) sum += mesh.volume(static_cast<int>(t));
  return sum;
}

TEST(SplitCells, MeetsItsNeighbours) {
  for (const bool mixed : {false, true}) {
    const CellSoup soup = cubes(4, mixed);
    const auto split = splitCells(soup, "cubes");
    ASSERT_TRUE(split.has_value());
    const auto mesh = TetMesh::build(soup.vertices, split->tets, "cubes");
    ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
    EXPECT_NEAR(volumeOf(**mesh), 1, 1e-12);
    // A gap between two cells would show as a boundary inside.
    EXPECT_EQ((*mesh)->boundary().size(), 6u * 16 * 2);
  }
}

TEST(SplitCells, SplitsWedgesAndPyramids) {
  CellSoup soup;
  soup.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0),  Vec3(0, 0, 1),
                   Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1), Vec3(.5, .5, 2)};
  soup.shapes = {CellShape::kWedge, CellShape::kWedge, CellShape::kPyramid};
  soup.connectivity = {0, 1, 2, 4, 5, 6, 0, 2, 3, 4, 6, 7, 4, 5, 6, 7, 8};
  soup.offsets = {0, 6, 12, 17};
  const auto split = splitCells(soup, "house").value();
  const auto mesh = TetMesh::build(soup.vertices, split.tets, "house");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  EXPECT_NEAR(volumeOf(**mesh), 1 + 1.0 / 3, 1e-12);
  EXPECT_EQ(split.cellOf.size(), 3u + 3 + 2);
}

TEST(SplitCells, TetsStayAsTheyAre) {
  CellSoup soup;
  soup.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)};
  soup.shapes = {CellShape::kTet, CellShape::kTet};
  soup.connectivity = {3, 1, 0, 2, 1, 2, 4, 0};
  soup.offsets = {0, 4, 8};
  const auto split = splitCells(soup, "two").value();
  EXPECT_EQ(split.tets, (std::vector<Tet>{{3, 1, 0, 2}, {1, 2, 4, 0}}));
  EXPECT_EQ(split.cellOf, (std::vector<std::int32_t>{0, 1}));
  EXPECT_TRUE(split.added.places.empty());
}

TEST(SplitCells, SaysWhatIsWrongWithATet) {
  CellSoup sound;
  sound.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  sound.shapes = {CellShape::kTet, CellShape::kTet};
  sound.connectivity = {0, 1, 2, 3, 0, 1, 2, 3};
  sound.offsets = {0, 4, 8};
  const auto messageOf = [](const CellSoup& soup) { return splitCells(soup, "a").error().message; };
  CellSoup soup = sound;
  soup.connectivity[6] = 0;
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 1 "));
  soup.connectivity[6] = -1;
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 1 has vertex -1; there are 4 vertices"));
  soup.connectivity[6] = 4;
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 1 has vertex 4; there are 4 vertices"));
  soup = sound;
  soup.vertices[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(messageOf(soup),
              HasSubstr("a: vertex 3 is at (0, inf, 1); expected metres, less than 1e30"));
  soup = sound;
  soup.offsets = {0, 4, 7};
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 1 does not have the vertices of its shape"));
  soup.offsets = {0, 4, 9};
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 1 lies at 4 to 9 of 8 indices"));
  soup.offsets = {4, 0, 4};
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 0 lies at 4 to 0 of 8 indices"));
  soup.offsets = {-4, 0, 4};
  EXPECT_THAT(messageOf(soup), HasSubstr("a: cell 0 lies at -4 to 0 of 8 indices"));
}

TEST(SplitCells, SaysWhatIsWrong) {
  CellSoup soup;
  soup.vertices.resize(4, Vec3::Zero());
  soup.shapes = {CellShape::kPyramid};
  soup.connectivity = {0, 1, 2, 3};
  soup.offsets = {0, 4};
  EXPECT_THAT(splitCells(soup, "a.vtu").error().message, HasSubstr("a.vtu: cell 0 does not have"));
  soup.shapes = {CellShape::kTet};
  soup.connectivity[2] = 9;
  EXPECT_THAT(splitCells(soup, "a.vtu").error().message, HasSubstr("vertex 9"));
  soup.offsets[1] = 8;
  EXPECT_THAT(splitCells(soup, "a.vtu").error().message, HasSubstr("0 to 8"));
  soup.shapes = {CellShape::kPolyhedron};
  soup.offsets[1] = 4;
  soup.connectivity = {1, 5, 0, 1};
  EXPECT_THAT(splitCells(soup, "a.vtu").error().message, HasSubstr("does not have"));
}

}  // namespace
}  // namespace volute
