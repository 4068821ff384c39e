// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/lamp_runs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

// Against meshes that one process holds: tests/cli/cluster_test.py.

namespace volute {
namespace {

constexpr double kNear = 1e-6, kEndless = std::numeric_limits<double>::infinity();

double shareOf(std::vector<LampRun> runs, double end = kEndless) {
  return lampShareOf(runs, end, kNear);
}

TEST(LampRuns, DepthsAddUpInAnyOrder) {
  EXPECT_DOUBLE_EQ(shareOf({{2, 5, 0.25}, {0, 2, 0.5}}), std::exp(-0.75));
  EXPECT_EQ(shareOf({}), 1);
}

TEST(LampRuns, AWayThatLeavesTheMeshAndComesBackIsDark) {
  EXPECT_EQ(shareOf({{0, 2, 0.5}, {2.5, 5, 0.25}}), 0);
  EXPECT_EQ(shareOf({{0.5, 2, 0.5}}), 0);
}

TEST(LampRuns, ALampInsideIsReachedThroughTheMesh) {
  EXPECT_EQ(shareOf({{0, 2, 0.5}}, 3), 0);
  EXPECT_DOUBLE_EQ(shareOf({{0, 3, 0.5}}, 3), std::exp(-0.5));
}

// In the plane between two pieces.
TEST(LampRuns, OfRunsInTheSamePlaceOneCounts) {
  EXPECT_DOUBLE_EQ(shareOf({{0, 4, 0.5}, {0, 4, 0.5}}), std::exp(-0.5));
  EXPECT_DOUBLE_EQ(shareOf({{0, 4, 0.5}, {3, 5, 0.5}}), std::exp(-0.75));
  EXPECT_DOUBLE_EQ(shareOf({{0, 4, 0.5}, {1, 3, 0.5}}), std::exp(-0.5));
}

}  // namespace
}  // namespace volute
