// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_project.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/gl/weight_table.hpp"
#include "volute/tetmesh/segment_weights.hpp"

namespace volute {
namespace {

/// The outline is convex, and the shadow of the whole tet is in it.
TEST(TetProject, TheOutlineHoldsTheTet) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  int seen[3] = {};
  for (int i = 0; i < 400; ++i) {
    const auto mesh =
        TetMesh::build({point(), point(), point(), point()}, {Tet{0, 1, 2, 3}}, "one");
    if (!mesh)
      continue;
    const auto vertices = (*mesh)->vertices();
    ViewOrigin view{3 * point(), point().normalized(), i % 2 == 0};
    if (i % 5 == 0)
      view.eye = 0.25 * (vertices[0] + vertices[1] + vertices[2] + vertices[3]);
    const ProjectedTet tet = projectTet(eyeShares(**mesh, 0, view));
    ++seen[static_cast<int>(tet.shape)];
    auto corners = tet.corners;
    std::ranges::sort(corners);
    EXPECT_EQ(corners, (std::array<std::int8_t, 4>{0, 1, 2, 3}));
    if (tet.shape == TetClass::kAround) {
      EXPECT_EQ(tet.sides, 0);
      continue;
    }
    ASSERT_EQ(tet.sides, tet.shape == TetClass::kQuad ? 4 : 3);
    // All vertices are on one side of the plane through the eye and a side of the outline.
    double turn = 0;
    for (int k = 0; k < tet.sides; ++k) {
      const Vec3 a = vertices[tet.corners[k]], b = vertices[tet.corners[(k + 1) % tet.sides]];
      const Vec3 sight = view.orthographic ? view.forward : Vec3(a - view.eye);
      const Vec3 normal = sight.cross(b - a);
      for (const Vec3& vertex : vertices) {
        const double side = normal.dot(vertex - a);
        if (std::abs(side) < 1e-12)
          continue;
        turn = turn == 0 ? side : turn;
        EXPECT_GT(side * turn, 0);
      }
    }
  }
  for (const int count : seen) EXPECT_GT(count, 20);
}

/// Bilinear between the table's points, as a device looks it up.
SegmentWeights look(const std::vector<float>& table, int side, double d0, double d1) {
  const double x = d0 / (1 + d0) * (side - 1), y = d1 / (1 + d1) * (side - 1);
  const int i = std::min(static_cast<int>(x), side - 2),
            j = std::min(static_cast<int>(y), side - 2);
  const auto at = [&](int channel) {
    const auto texel = [&](int a, int b) { return table[2 * ((j + b) * side + i + a) + channel]; };
    return std::lerp(std::lerp(texel(0, 0), texel(1, 0), x - i),
                     std::lerp(texel(0, 1), texel(1, 1), x - i), y - j);
  };
  return {at(0), at(1)};
}

TEST(WeightTable, IsWithinItsBounds) {
  constexpr int kSide = 512;
  const auto table = weightTable(kSide);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0, worstThin = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool thin = i % 2 == 0;
    const auto depth = [&] {
      return thin ? 8 * uniform(random) : std::pow(10, 4 * uniform(random) - 2);
    };
    const double d0 = depth(), d1 = depth();
    const auto exact = segmentWeights(d0, d1), found = look(table, kSide, d0, d1);
    double& largest = thin ? worstThin : worst;
    largest = std::max({largest, std::abs(exact.w0 - found.w0), std::abs(exact.w1 - found.w1)});
  }
  EXPECT_LE(worstThin, 2e-5);
  EXPECT_LE(worst, 2e-4);
}

}  // namespace
}  // namespace volute
