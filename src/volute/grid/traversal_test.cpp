// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/traversal.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Step {
  std::array<int, 3> cell;
  double begin, end;
};

std::vector<Step> steps(const CellGrid& grid, const CellRange& range, const Segment& segment) {
  std::vector<Step> all;
  traverseCells(grid, range, segment,
                [&](const std::array<int, 3>& cell, double begin, double end) {
                  all.push_back({cell, begin, end});
                });
  return all;
}

CellRange whole(const CellGrid& grid) {
  return {{0, 0, 0}, grid.count};
}

const CellGrid kGrid{Vec3(-1, 2, 0.5), Vec3(0.25, 0.5, 0.125), {7, 3, 9}};

TEST(TraverseCells, WalksOneRowWithExactPlanes) {
  const CellGrid grid{Vec3::Zero(), Vec3::Constant(0.1), {10, 1, 1}};
  const auto walk = steps(grid, whole(grid), {Vec3(-1, 0.05, 0.05), Vec3::UnitX(), 0, kInfinity});
  ASSERT_EQ(walk.size(), 10u);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(walk[i].cell[0], i);
    EXPECT_EQ(walk[i].begin, i * 0.1 + 1);
    EXPECT_EQ(walk[i].end, (i + 1) * 0.1 + 1);
  }
}

TEST(TraverseCells, GoesBackwardsFromMinusInfinity) {
  const CellGrid grid{Vec3::Zero(), Vec3::Ones(), {3, 3, 3}};
  const auto walk =
      steps(grid, whole(grid), {Vec3(1.5, 1.5, 1.5), -Vec3::UnitZ(), -kInfinity, kInfinity});
  ASSERT_EQ(walk.size(), 3u);
  EXPECT_EQ(walk[0].cell[2], 2);
  EXPECT_EQ(walk[0].begin, -1.5);
  EXPECT_EQ(walk[2].end, 1.5);
}

TEST(TraverseCells, ARayInAPlaneTakesTheUpperCellsAndTheLastOnesAtTheOuterFace) {
  const CellGrid grid{Vec3::Zero(), Vec3::Ones(), {3, 3, 3}};
  const auto row = [&](double y, const CellRange& range) {
    const auto walk = steps(grid, range, {Vec3(-1, y, 0.5), Vec3::UnitX(), 0, 9});
    return walk.empty() ? -1 : walk[0].cell[1];
  };
  EXPECT_EQ(row(0, whole(grid)), 0);
  EXPECT_EQ(row(1, whole(grid)), 1);
  EXPECT_EQ(row(3, whole(grid)), 2);
  EXPECT_EQ(row(3.0000001, whole(grid)), -1);
  EXPECT_EQ(row(2, {{0, 0, 0}, {3, 2, 3}}), -1);  // the upper cells are not in the range
}

TEST(TraverseCells, NearlyParallelRaysDoNotChangeCellsByRounding) {
  const CellGrid grid{Vec3::Zero(), Vec3::Ones(), {4, 4, 4}};
  for (double tilt : {1e-17, -1e-17, 1e-300, -1e-300}) {
    const Segment segment{Vec3(-1, 2, 0.5), Vec3(1, tilt, 0), 0, 9};
    const auto walk = steps(grid, whole(grid), segment);
    ASSERT_EQ(walk.size(), 4u) << tilt;
    for (const Step& step : walk) EXPECT_EQ(step.cell[1], tilt > 0 ? 2 : 1);
  }
}

TEST(TraverseCells, EmptySegmentsAndMissesVisitNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, 3, 1), Vec3(1, nan, 0), 0, 9}).empty());
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, nan, 1), Vec3::UnitX(), 0, 9}).empty());
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, 3, nan), Vec3::Ones(), 0, 9}).empty());
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, 3, 1), Vec3::UnitX(), 0.2, 0.2}).empty());
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, 3, 1), Vec3::UnitX(), 1, 0}).empty());
  EXPECT_TRUE(steps(kGrid, whole(kGrid), {Vec3(0, 0, 1), Vec3::UnitX(), 0, 9}).empty());
  EXPECT_TRUE(steps(kGrid, {{2, 2, 2}, {2, 3, 3}}, {Vec3(0, 3, 1), Vec3::UnitX(), 0, 9}).empty());
}

RC_GTEST_PROP(TraverseCells, CoversTheClippedSegmentOnceCellByNeighbouringCell, ()) {
  // Coordinates on a coarse lattice hit planes, edges and corners often.
  const auto coordinate = [](int from, int to) { return *rc::gen::inRange(from, to + 1) / 8.0; };
  const Vec3 origin(coordinate(-16, 16), coordinate(8, 40), coordinate(-8, 24));
  const Vec3 direction(coordinate(-8, 8), coordinate(-8, 8), coordinate(-8, 8));
  RC_PRE(direction.norm() > 0);
  const Segment segment{origin, direction.normalized(), *rc::gen::element(-kInfinity, 0.0, 0.5),
                        kInfinity};
  const CellRange range{{1, 0, 2}, {6, 3, 9}};
  const auto part = steps(kGrid, range, segment);
  for (std::size_t i = 0; i < part.size(); ++i) {
    RC_ASSERT(part[i].begin < part[i].end);
    const Vec3 middle = segment.at(0.5 * (part[i].begin + part[i].end));
    for (int axis = 0; axis < 3; ++axis) {
      RC_ASSERT(part[i].cell[axis] >= range.begin[axis] && part[i].cell[axis] < range.end[axis]);
      RC_ASSERT(middle[axis] > kGrid.plane(axis, part[i].cell[axis]) - 1e-12);
      RC_ASSERT(middle[axis] < kGrid.plane(axis, part[i].cell[axis] + 1) + 1e-12);
    }
    if (i > 0)
      RC_ASSERT(part[i].begin == part[i - 1].end);
  }
  // The walk through the whole grid has the same steps inside the range.
  std::vector<Step> inside;
  for (const Step& step : steps(kGrid, whole(kGrid), segment)) {
    bool in = true;
    for (int axis = 0; axis < 3; ++axis) {
      in = in && step.cell[axis] >= range.begin[axis] && step.cell[axis] < range.end[axis];
    }
    if (in && step.end - step.begin > 1e-12)
      inside.push_back(step);
  }
  std::vector<Step> long_;
  for (const Step& step : part) {
    if (step.end - step.begin > 1e-12)
      long_.push_back(step);
  }
  RC_ASSERT(inside.size() == long_.size());
  for (std::size_t i = 0; i < inside.size(); ++i) {
    RC_ASSERT(inside[i].cell == long_[i].cell);
    RC_ASSERT(std::abs(inside[i].begin - long_[i].begin) < 1e-12);
  }
}

}  // namespace
}  // namespace volute
