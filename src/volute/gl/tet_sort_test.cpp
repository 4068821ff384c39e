// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_sort.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "volute/gl/tet_project.hpp"
#include "volute/gl/weight_table.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/segment_weights.hpp"

namespace volute {
namespace {

std::vector<std::int32_t> placesIn(const TetOrder& order) {
  std::vector<std::int32_t> places(order.tets.size(), -1);
  for (std::size_t i = 0; i < order.tets.size(); ++i)
    places[order.tets[i]] = static_cast<std::int32_t>(i);
  return places;
}

/// Faces whose nearer tet stands before the farther one.
int wrongNeighbours(const TetMesh& mesh, const TetEye& eye, const TetOrder& order) {
  const auto places = placesIn(order);
  int wrong = 0;
  for (const TetFace& face : mesh.faces()) {
    if (face.second == TetMesh::kBoundary)
      continue;
    // The face hides nothing from itself: on whose side of it is the eye? By barycentric sign.
    const double first = eyeShares(mesh, face.first / 4, eye)[face.first % 4];
    const bool firstIsNear = first > 0;
    if (first != 0)
      wrong += (places[face.first / 4] > places[face.second / 4]) != firstIsNear;
  }
  return wrong;
}

TEST(TetSort, NeighboursAreInOrderFromAnywhere) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(3, 2, 1)}, {7, 6, 5}, 0.3, 4);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-2, 4);
  for (int i = 0; i < 20; ++i) {
    TetEye eye{Vec3(uniform(random), uniform(random), uniform(random))};
    eye.orthographic = i % 3 == 0;
    eye.forward = Vec3(uniform(random), uniform(random), 1).normalized();
    const TetOrder order = sortTets(*mesh, eye);
    auto all = order.tets;
    std::ranges::sort(all);
    for (std::size_t t = 0; t < all.size(); ++t) ASSERT_EQ(all[t], static_cast<std::int32_t>(t));
    EXPECT_EQ(order.cycles, 0);
    EXPECT_EQ(order.parts, 1);
    EXPECT_EQ(wrongNeighbours(*mesh, eye, order), 0) << "eye " << i;
  }
}

TEST(TetSort, PartsAreSortedByDistance) {
  const Vec3 corners[] = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  std::vector<Vec3> vertices;
  std::vector<Tet> tets;
  for (int i = 0; i < 5; ++i) {
    for (const Vec3& corner : corners) vertices.push_back(corner + Vec3(0, 0, 3 * ((2 * i) % 5)));
    tets.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
  }
  const auto mesh = TetMesh::build(vertices, tets, "made").value();
  const TetOrder order = sortTets(*mesh, {Vec3(0.2, 0.2, -4)});
  EXPECT_EQ(order.parts, 5);
  EXPECT_EQ(order.cycles, 0);
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_GT(mesh->vertices()[mesh->tets()[order.tets[i - 1]][0]].z(),
              mesh->vertices()[mesh->tets()[order.tets[i]][0]].z());
  }
}

/// A ring of prisms whose common sides all lean the same way, each cut in six around a diagonal:
/// seen along its axis, each prism hides the next.
std::shared_ptr<const TetMesh> leaningRing(int sides) {
  std::vector<Vec3> vertices;
  for (const int level : {0, 1}) {
    for (int side = 0; side < sides; ++side) {
      const double turn = 2 * std::numbers::pi * (side + 0.4 * level) / sides;
      for (const double radius : {1.0, 0.5})
        vertices.push_back({radius * std::cos(turn), radius * std::sin(turn), 1.0 * level});
    }
  }
  std::vector<Tet> tets;
  for (int side = 0; side < sides; ++side) {
    int axes[] = {0, 1, 2};
    do {
      int at[3] = {0, 0, 0};
      const auto vertex = [&] { return 2 * (at[2] * sides + (side + at[0]) % sides) + at[1]; };
      Tet tet{vertex()};
      for (int i = 0; i < 3; ++i) {
        at[axes[i]] = 1;
        tet[i + 1] = vertex();
      }
      tets.push_back(tet);
    } while (std::next_permutation(axes, axes + 3));
  }
  return TetMesh::build(vertices, tets, "ring").value();
}

TEST(TetSort, ACycleIsBrokenAndCounted) {
  const auto ring = leaningRing(7);
  const TetEye along{Vec3(0, 0, 40), Vec3(0, 0, -1), true};
  const TetOrder order = sortTets(*ring, along);
  EXPECT_EQ(order.tets.size(), ring->tets().size());
  EXPECT_EQ(order.parts, 1);
  EXPECT_GE(order.cycles, 1);
  const int wrong = wrongNeighbours(*ring, along, order);
  EXPECT_GE(wrong, 1);
  EXPECT_LE(wrong, 3 * order.cycles);
  // From the side nothing goes around.
  const TetEye beside{Vec3(30, 3, 0.4)};
  const TetOrder plain = sortTets(*ring, beside);
  EXPECT_EQ(plain.cycles, 0);
  EXPECT_EQ(wrongNeighbours(*ring, beside, plain), 0);
}

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
    TetEye eye{3 * point(), point().normalized(), i % 2 == 0};
    if (i % 5 == 0)
      eye.point = 0.25 * (vertices[0] + vertices[1] + vertices[2] + vertices[3]);
    const ProjectedTet tet = projectTet(eyeShares(**mesh, 0, eye));
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
      const Vec3 sight = eye.orthographic ? eye.forward : Vec3(a - eye.point);
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
