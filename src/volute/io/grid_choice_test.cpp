// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/grid_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace volute {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<GridEntry> kFire{
    {"density", "float", true}, {"emission", "vec3s", true}, {"index", "int32", false}};

TEST(ChooseGrid, TakesTheUsualOneOfSeveral) {
  EXPECT_EQ(chooseGrid(kFire, "", "f.vdb"), 0U);
  EXPECT_EQ(chooseGrid(kFire, "", "f.vdb", {.usual = "emission"}), 1U);
  EXPECT_EQ(chooseGrid(kFire, "density", "f.vdb", {.usual = "emission"}), 0U);
}

TEST(ChooseGrid, TakesTheOnlyOneWhateverItsName) {
  const std::vector<GridEntry> one{kFire[2], {"flame", "float", true}};
  EXPECT_EQ(chooseGrid(one, "", "f.vdb", {.usual = "emission"}), 1U);
}

TEST(ChooseGrid, AsksWhereTheUsualOneIsNotThere) {
  const std::vector<GridEntry> smoke{kFire[0], {"temperature", "float", true}};
  const auto chosen = chooseGrid(smoke, "", "f.vdb", {.usual = "emission"});
  ASSERT_FALSE(chosen);
  EXPECT_THAT(chosen.error().message,
              AllOf(HasSubstr("which grid?"), HasSubstr("density (float), temperature (float)")));
  EXPECT_EQ(chosen.error().hints, Hints{Hint::choose("field")});
}

TEST(OtherGrids, NamesComeBackButThoseThatWereCut) {
  const std::vector<GridEntry> fire{
      kFire[0], {"flame", "float", true}, {"heat", "float", true}, {"wind", "float", true}};
  EXPECT_THAT(namesOfGrids(otherGrids(fire, 1, 255)), ElementsAre("density", "heat", "wind"));
  EXPECT_THAT(namesOfGrids(otherGrids(fire, 1, 18)), ElementsAre("density", "heat"));
  EXPECT_THAT(namesOfGrids(""), ElementsAre());
}

}  // namespace
}  // namespace volute
