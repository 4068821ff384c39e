// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_room.hpp"

#include <gtest/gtest.h>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

using fdswriter::Index;
using fdswriter::Indices;

constexpr double kCell = 0.2;  ///< [m] of the mesh, and a column is thinner

std::vector<double> planes(double from, int cells) {
  std::vector<double> places;
  for (int i = 0; i <= cells; ++i) places.push_back(from + kCell * i);
  return places;
}

/// 12 x 6 x 3 m of 0.2 m cells, with the obstructions.
std::optional<Box3> roomAmong(std::vector<Indices> obstructions) {
  const ScratchFolder folder;
  Index index;
  index.meshes.push_back(
      {{planes(10, 60), planes(-3, 30), planes(0, 15)}, std::move(obstructions), {}});
  index.save(folder / "case.smv");
  const auto read = SmvIndex::read(folder / "case.smv");
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read ? largestRoom(*read, 0) : std::nullopt;
}

void expectBox(const std::optional<Box3>& room, const Vec3& min, const Vec3& max) {
  ASSERT_TRUE(room);
  constexpr double kColumn = 12.0 / 200 + 1e-9;
  EXPECT_LT((room->min - min).cwiseAbs().maxCoeff(), kColumn) << room->min;
  EXPECT_LT((room->max - max).cwiseAbs().maxCoeff(), kColumn) << room->max;
}

const Indices kRoof{0, 60, 0, 30, 13, 14};  ///< from 2.6 m on

TEST(FdsRoom, WithoutARoofThereIsNone) {
  EXPECT_FALSE(roomAmong({}));
  EXPECT_FALSE(roomAmong({{0, 60, 10, 11, 0, 15}})) << "a wall covers nothing";
  EXPECT_FALSE(roomAmong({{4, 8, 4, 8, 4, 5}})) << "a table";
}

TEST(FdsRoom, ReachesFromWallToWallAndFromFloorToCeiling) {
  expectBox(roomAmong({kRoof}), {10, -3, 0}, {22, 3, 2.6});
  expectBox(roomAmong({kRoof, {20, 21, 0, 30, 0, 13}}), {14.2, -3, 0}, {22, 3, 2.6});
  expectBox(roomAmong({kRoof, {20, 20, 0, 30, 0, 13}}), {14, -3, 0}, {22, 3, 2.6});
}

TEST(FdsRoom, IsUnderTheMeshesOwnTop) {
  const ScratchFolder folder;
  Index index;
  index.meshes.push_back({{planes(10, 60), planes(-3, 30), planes(0, 15)}, {}, {}});
  std::string text = index.text();
  const auto at = text.find("\nVENT\n"), end = text.find("\nCVENT\n");
  text = text.substr(0, at) + "\nVENT\n 1 1\n 0 0 0 0 0 0 1 0\n 0 60 0 30 15 15 99 0\n" +
         text.substr(end);
  fdswriter::saveText(folder / "case.smv", text);
  const auto read = SmvIndex::read(folder / "case.smv");
  ASSERT_TRUE(read) << read.error().message;
  expectBox(largestRoom(*read, 0), {10, -3, 0}, {22, 3, 3});
}

TEST(FdsRoom, StandsOnWhatIsBuilt) {
  expectBox(roomAmong({kRoof, {0, 60, 0, 30, 0, 2}}), {10, -3, 0.4}, {22, 3, 2.6});
}

TEST(FdsRoom, WhatHangsBelowTheCeilingLowersItAndWhatIsTooLowIsLeftOut) {
  expectBox(roomAmong({kRoof, {30, 32, 0, 30, 12, 13}}), {10, -3, 0}, {22, 3, 2.4});
  expectBox(roomAmong({kRoof, {40, 42, 0, 30, 7, 13}}), {10, -3, 0}, {18, 3, 2.6});
}

TEST(FdsRoom, ARoofThatIsGoneCoversNothing) {
  const ScratchFolder folder;
  Index index;
  index.meshes.push_back(
      {{planes(0, 20), planes(0, 20), planes(0, 15)}, {{0, 20, 0, 20, 13, 14}}, {}});
  index.event("HIDE_OBST", 1, 1, 5);
  index.save(folder / "case.smv");
  const auto read = SmvIndex::read(folder / "case.smv");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(largestRoom(*read, 0));
  EXPECT_FALSE(largestRoom(*read, 5));
}

}  // namespace
}  // namespace volute
