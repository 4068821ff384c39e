// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_building.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

using fdswriter::Indices;
using testing::SizeIs;

constexpr double kHouseCell = 0.25;  ///< [m]
constexpr FdsSides kForwards = 4, kUpwards = 32;

std::vector<double> housePlanes(int cells) {
  std::vector<double> places;
  for (int i = 0; i <= cells; ++i) places.push_back(kHouseCell * i);
  return places;
}

/// 8 x 6 x 3 m.
SmvIndex house(std::vector<Indices> obstructions, std::vector<Indices> openings = {},
               const std::string& vents = "") {
  const ScratchFolder folder;
  fdswriter::Index index;
  index.meshes.push_back({{housePlanes(32), housePlanes(24), housePlanes(12)},
                          std::move(obstructions),
                          std::move(openings)});
  std::string text = index.text();
  if (!vents.empty()) {
    const auto at = text.find("\nVENT\n");
    const auto end = text.find("\nCVENT\n");
    text = text.substr(0, at) + "\nVENT\n" + vents + text.substr(end);
  }
  fdswriter::saveText(folder / "case.smv", text);
  auto read = SmvIndex::read(folder / "case.smv");
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read ? *read : SmvIndex();
}

/// All sides of the mesh and its top are open to the outside.
const std::vector<Indices> kOpenSides{{0, 0, 0, 24, 0, 12},
                                      {32, 32, 0, 24, 0, 12},
                                      {0, 32, 0, 0, 0, 12},
                                      {0, 32, 24, 24, 0, 12},
                                      {0, 32, 0, 24, 12, 12}};
const Indices kFrontWall{2, 30, 2, 3, 0, 10}, kBackWall{2, 30, 21, 22, 0, 10},
    kLeftWall{2, 3, 2, 22, 0, 10}, kRightWall{29, 30, 2, 22, 0, 10},
    kRoofSlab{2, 30, 2, 22, 10, 11}, kInnerWall{15, 16, 3, 21, 0, 10}, kSofa{5, 9, 3, 6, 0, 3},
    kLowTable{20, 24, 10, 14, 2, 3};

/// Whether an obstruction stays.
bool stays(const FdsBuilding& building, FdsSides open, const Indices& what) {
  const Vec3 middle =
      0.5 * kHouseCell * Vec3(what.i1 + what.i2, what.j1 + what.j2, what.k1 + what.k2);
  for (const FdsBox& box : building.kept(open)) {
    if ((box.bounds.centre() - middle).norm() < 1e-9)
      return true;
  }
  return false;
}

TEST(FdsBuilding, opensLikeADollsHouse) {
  const FdsBuilding building(
      house({kFrontWall, kBackWall, kLeftWall, kRightWall, kRoofSlab, kInnerWall, kSofa, kLowTable},
            kOpenSides),
      0);
  const FdsSides open = building.sidesTowards({4, -10, 8});
  EXPECT_EQ(open, kForwards | kUpwards);
  EXPECT_FALSE(stays(building, open, kFrontWall));
  EXPECT_FALSE(stays(building, open, kRoofSlab));
  for (const Indices& kept : {kBackWall, kLeftWall, kRightWall, kInnerWall, kSofa, kLowTable})
    EXPECT_TRUE(stays(building, open, kept)) << kept.i1 << ", " << kept.j1;
  EXPECT_EQ(building.kept(0).size(), 8U) << "from within all is there";
  EXPECT_EQ(building.storeys(), 1);
  EXPECT_LT((building.bounds().min - Vec3(0.5, 0.5, 0)).norm(), 1e-9) << "of what is built";
}

TEST(FdsBuilding, aWallInPiecesIsLeftOutAroundItsDoor) {
  const Indices left{2, 10, 2, 3, 0, 10}, right{14, 30, 2, 3, 0, 10}, lintel{10, 14, 2, 3, 8, 10};
  const FdsBuilding building(
      house({left, right, lintel, kBackWall, kLeftWall, kRightWall, kRoofSlab, kInnerWall},
            kOpenSides),
      0);
  for (const Indices& gone : {left, right, lintel})
    EXPECT_FALSE(stays(building, kForwards, gone)) << gone.i1;
  EXPECT_TRUE(stays(building, kForwards, kInnerWall)) << "which is seen through the door";
  EXPECT_TRUE(stays(building, kForwards, kBackWall));
}

TEST(FdsBuilding, whatStandsInARoomWithoutRoofStays) {
  const FdsBuilding building(
      house({kFrontWall, kBackWall, kLeftWall, kRightWall, kSofa, kLowTable}, kOpenSides), 0);
  EXPECT_EQ(building.kept(63).size(), 6U);
}

TEST(FdsBuilding, aWallSeenFromItsEndStays) {
  // From the left the front wall's pieces lie in line, with a window between them.
  const Indices left{2, 12, 2, 3, 0, 10}, right{16, 30, 2, 3, 0, 10}, sill{12, 16, 2, 3, 0, 3};
  const FdsBuilding building(
      house({left, right, sill, kBackWall, kLeftWall, kRightWall, kRoofSlab, kInnerWall},
            kOpenSides),
      0);
  constexpr FdsSides kLeft = 1;
  EXPECT_FALSE(stays(building, kLeft, kLeftWall));
  for (const Indices& kept : {left, right, sill, kBackWall, kInnerWall})
    EXPECT_TRUE(stays(building, kLeft, kept)) << kept.i1 << ", " << kept.j1;
}

TEST(FdsBuilding, wallsUnderARoofAreNoPartOfItOverAnotherStorey) {
  // Under the mesh's own top a wall stands on a slab.
  const Indices slab{0, 32, 0, 24, 5, 6}, wall{15, 16, 0, 24, 6, 12};
  const FdsBuilding building(
      house({slab, wall}, {}, " 1 1\n 0 0 0 0 0 0 1 0\n 0 32 0 24 12 12 99 0\n"), 0);
  EXPECT_EQ(building.kept(kUpwards).size(), 2U);
}

TEST(FdsBuilding, storeysAreCounted) {
  const FdsBuilding building(house({{0, 32, 0, 24, 6, 6}, {0, 4, 0, 24, 5, 6}}, {},
                                   " 1 1\n 0 0 0 0 0 0 1 0\n 0 32 0 24 12 12 99 0\n"),
                             0);
  EXPECT_EQ(building.storeys(), 2);
}

/// The meshes' own walls, as FDS adds them behind the vents of the input.
constexpr const char* kWalls =
    " 6 5\n 1 2 1 2 0 0 1 0\n 0 0 0 6 0 3 2 0\n 8 8 0 6 0 3 3 0\n 0 8 0 0 0 3 4 0\n"
    " 0 8 6 6 0 3 5 0\n 0 8 0 6 3 3 6 0\n"
    " 4 8 4 8 0 0 99 0\n 0 0 0 24 0 12 99 0\n 32 32 0 24 0 12 99 0\n 0 32 0 0 0 12 99 0\n"
    " 0 32 24 24 0 12 99 0\n 0 32 0 24 12 12 99 0\n";

TEST(FdsBuilding, theMeshesOwnWallsAreThereFromWithinWhateverTheirSurface) {
  // SURF DEFAULT: the walls have another surface than the first, here the vent has the first.
  std::string other = kWalls;
  for (int wall = 2; wall <= 6; ++wall)
    other.replace(other.find(fmt::format(" {} 0\n", wall)), 4, fmt::format(" {} 1", wall));
  for (const std::string& vents : {std::string(kWalls), other}) {
    const SmvIndex index = house({kSofa}, {}, vents);
    ASSERT_THAT(index.meshes[0].vents, SizeIs(6));
    EXPECT_FALSE(index.meshes[0].vents[0].exterior);
    EXPECT_TRUE(index.meshes[0].vents[1].exterior);
    const FdsBuilding building(index, 0);
    EXPECT_THAT(building.quads(), SizeIs(6 + 6)) << "the sofa, the vent and five walls";
    EXPECT_THAT(building.quads(kForwards | kUpwards), SizeIs(6 + 6 - 2));
    EXPECT_EQ(building.kept(63).size(), 1U) << "furniture before a closed wall";
    EXPECT_THAT(building.interior(), testing::Not(testing::IsEmpty()))
        << "under the mesh's own top";
  }
}

TEST(FdsBuilding, ventsStandBeforeWhatTheyLieOn) {
  const SmvIndex index = house({kSofa}, {}, " 1 0\n 0 0 0 0 0 0 1 0\n 5 9 3 6 3 3 99 0\n");
  int before = 0;
  for (const FdsQuad& quad : FdsBuilding(index, 0).quads()) {
    const double z = quad.corners[0].z();
    if (quad.corners[2].z() == z && z > 0.75)
      ++before;
  }
  EXPECT_EQ(before, 1);
}

TEST(FdsBuilding, planesCutIt) {
  const FdsBuilding building(house({kFrontWall, kSofa, {0, 32, 0, 24, 10, 10}}), 0);
  const FdsCut level{2, 1.5, true};
  const auto quads = building.quads(0, {&level, 1});
  EXPECT_THAT(quads, SizeIs(12)) << "the slab is above";
  int cut = 0;
  for (const FdsQuad& quad : quads) {
    for (const Vec3& corner : quad.corners) EXPECT_LE(corner.z(), 1.5);
    cut += quad.cut;
  }
  EXPECT_EQ(cut, 1) << "the wall's new top";
}

}  // namespace
}  // namespace volute
