// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/mesh_shape.hpp"

#include <gtest/gtest.h>

#include "volute/tetmesh/split_cells.hpp"

namespace volute {
namespace {

/// Unit cubes at these places.
MeshShape shapeOfCubes(const std::vector<std::array<int, 3>>& cubes) {
  constexpr int kSize = 5;
  std::vector<std::int64_t> numbers(kSize * kSize * kSize, -1);
  CellSoup soup;
  soup.offsets = {0};
  for (const auto& cube : cubes) {
    for (const auto& c : {std::array{0, 0, 0},
                          {1, 0, 0},
                          {1, 1, 0},
                          {0, 1, 0},
                          {0, 0, 1},
                          {1, 0, 1},
                          {1, 1, 1},
                          {0, 1, 1}}) {
      const int x = cube[0] + c[0], y = cube[1] + c[1], z = cube[2] + c[2];
      auto& number = numbers[static_cast<std::size_t>((z * kSize + y) * kSize + x)];
      if (number < 0) {
        number = static_cast<std::int64_t>(soup.vertices.size());
        soup.vertices.emplace_back(x, y, z);
      }
      soup.connectivity.push_back(number);
    }
    soup.shapes.push_back(CellShape::kHexahedron);
    soup.offsets.push_back(static_cast<std::int64_t>(soup.connectivity.size()));
  }
  const auto split = splitCells(soup, "cubes").value();
  return shapeOf(*TetMesh::build(split.vertices(soup), split.tets, "cubes").value());
}

TEST(MeshShape, TellsConvexFromNot) {
  const MeshShape one = shapeOfCubes({{0, 0, 0}});
  EXPECT_TRUE(one.convex);
  EXPECT_EQ(one.parts, 1);
  EXPECT_NEAR(one.volume, 1, 1e-12);
  EXPECT_TRUE(shapeOfCubes({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).convex);
  EXPECT_FALSE(shapeOfCubes({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).convex);
  const MeshShape two = shapeOfCubes({{0, 0, 0}, {2, 0, 0}});
  EXPECT_EQ(two.parts, 2);
  EXPECT_FALSE(two.convex);
  EXPECT_NEAR(two.volume, 2, 1e-12);
  std::vector<std::array<int, 3>> shell;
  for (int i = 0; i < 27; ++i) {
    if (i != 13)
      shell.push_back({i % 3, i / 3 % 3, i / 9});
  }
  EXPECT_FALSE(shapeOfCubes(shell).convex);
  EXPECT_EQ(shapeOfCubes(shell).parts, 1);
}

}  // namespace
}  // namespace volute
