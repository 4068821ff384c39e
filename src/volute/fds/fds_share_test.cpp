// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_share.hpp"

#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include "volute/fds/fds_case_testing.hpp"

namespace volute {
namespace {

using testing::HasSubstr;

/// Meshes of so many cells along x, side by side.
SmvIndex meshesOf(const std::vector<int>& cells) {
  SmvIndex index;
  index.path = "made.smv";
  for (const int count : cells) {
    FdsMesh& mesh = index.meshes.emplace_back();
    for (int i = 0; i <= count; ++i) mesh.planes[0].push_back(i);
    mesh.planes[1] = mesh.planes[2] = {0, 1};
  }
  return index;
}

/// How many cells each share has; each mesh must be in one.
std::vector<int> cellsOfShares(const std::vector<int>& cells, int shares) {
  const SmvIndex index = meshesOf(cells);
  std::vector<int> sums, owners(cells.size(), 0);
  for (int share = 0; share < shares; ++share) {
    const auto held = meshesOfShare(index, {share, shares}).value();
    int sum = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      sum += held[i] ? cells[i] : 0;
      owners[i] += held[i];
    }
    sums.push_back(sum);
  }
  EXPECT_EQ(owners, std::vector<int>(cells.size(), 1));
  return sums;
}

TEST(FdsShare, MeshesAreSharedOutByTheirCells) {
  EXPECT_EQ(cellsOfShares({5, 5, 5, 5}, 1), (std::vector<int>{20}));
  EXPECT_EQ(cellsOfShares({5, 5, 5, 5}, 2), (std::vector<int>{10, 10}));
  EXPECT_EQ(cellsOfShares({9, 1, 1, 1, 9}, 3), (std::vector<int>{9, 3, 9}));
  EXPECT_EQ(cellsOfShares({1, 1, 100}, 3), (std::vector<int>{1, 1, 100}));
  EXPECT_EQ(cellsOfShares({100, 1, 1}, 3), (std::vector<int>{100, 1, 1}));
  std::mt19937 draw(1);
  for (int i = 0; i < 200; ++i) {
    std::vector<int> cells(1 + draw() % 12);
    for (int& one : cells) one = 1 + static_cast<int>(draw() % 50);
    const int shares = 1 + static_cast<int>(draw() % cells.size());
    const int all = std::accumulate(cells.begin(), cells.end(), 0);
    for (const int sum : cellsOfShares(cells, shares)) {
      EXPECT_GT(sum, 0);
      EXPECT_LE(sum, all / shares + 2 * std::ranges::max(cells));
    }
  }
}

TEST(FdsShare, MoreSharesThanMeshesAreRefused) {
  const auto held = meshesOfShare(meshesOf({3, 4}), {0, 3});
  ASSERT_FALSE(held);
  EXPECT_THAT(held.error().message, HasSubstr("has 2 meshes, and 3 ranks cannot hold one each"));
}

/// Two meshes side by side and a finer one within the first, with an obstruction in the second.
void saveCase(const ScratchFolder& folder, bool cellCentred) {
  const Planes fine{{{0.2, 0.3, 0.4, 0.5, 0.6}, {0.2, 0.3, 0.4, 0.5, 0.6}, {0.3, 0.4, 0.5}}};
  fdswriter::Index index;
  int number = 0;
  for (const Planes& planes : {kFirst, kSecond, fine}) {
    index.meshes.push_back({planes, {}, {}});
    if (number == 1)
      index.meshes.back().obstructions.push_back({1, 2, 2, 4, 0, 3});
    const fdswriter::Slice slice{whole(planes)};
    const double factor = 1 + number;
    const fdswriter::Function at = [&](double x, double y, double z) {
      return factor * linearAt(Vec3(x, y, z));
    };
    const auto values = cellCentred ? fdswriter::inCells(planes, slice.at, at, 777.0F)
                                    : fdswriter::atNodes(planes, slice.at, at);
    const std::string name = fmt::format("made_{}_1.sf", ++number);
    fdswriter::sliceFile(slice, {{0.0F, values}}).save(folder / name);
    index.slice(number, slice, name, cellCentred);
  }
  index.save(folder / "made.smv");
}

// Every ray meets each place in one share, also where meshes overlap.
TEST(FdsShare, FieldsOfSharesAddUpToTheWhole) {
  std::mt19937 draw(2);
  std::uniform_real_distribution<double> x(-0.2, 2.2), y(-0.1, 0.9), z(-0.1, 0.7);
  for (const bool cellCentred : {false, true}) {
    const ScratchFolder folder;
    saveCase(folder, cellCentred);
    FdsCase all = opened(folder / "made.smv");
    const FdsField whole = fieldAt(all, 0);
    std::vector<Segment> rays;
    for (int i = 0; i < 500; ++i) {
      const Vec3 a(x(draw), y(draw), z(draw)), b(x(draw), y(draw), z(draw));
      rays.push_back(between(a, b));
    }
    rays.push_back(between({0.2, -1, 0.4}, {0.2, 1, 0.4}));  // in the plane between two meshes
    rays.push_back(between({1, -1, 0.4}, {1, 1, 0.4}));
    std::vector<double> expected(rays.size());
    whole.opticalDepth(rays, expected);
    for (const int shares : {2, 3}) {
      std::vector<double> sum(rays.size(), 0), depths(rays.size());
      std::size_t values = 0;
      for (int share = 0; share < shares; ++share) {
        FdsCase some = opened(folder / "made.smv", {.share = {share, shares}});
        const FdsField field = fieldAt(some, 0);
        EXPECT_EQ(field.bounds().max, whole.bounds().max);
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_EQ(field.grid().holds(i), !field.values(i).value.empty());
          values += field.values(i).value.size();
        }
        field.opticalDepth(rays, depths);
        std::vector<std::vector<Piece>> pieces(rays.size());
        field.pieces(rays, pieces);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          sum[i] += depths[i];
          double length = 0;
          for (const Piece& piece : pieces[i]) length += piece.end - piece.begin;
          EXPECT_EQ(length > 0, depths[i] > 0);
        }
      }
      for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_NEAR(sum[i], expected[i], 1e-12);
      std::size_t once = 0;
      for (std::size_t i = 0; i < 3; ++i) once += whole.values(i).value.size();
      EXPECT_EQ(values, once);
    }
  }
}

}  // namespace
}  // namespace volute
