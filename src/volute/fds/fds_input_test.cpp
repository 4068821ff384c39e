// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_input.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/fds/fds_case_testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kText =
    "This text is none of FDS's business, even with VISIBILITY_FACTOR=5 /\n"
    "&HEAD CHID='case', TITLE='It''s / a title' /  and so is this\n"
    "&MISC TMPA=20., ! VISIBILITY_FACTOR=4\n"
    "      VISIBILITY_FACTOR = 8.\n"
    "      MAXIMUM_VISIBILITY=1D2 /\n"
    "&REAC FUEL=\"PROPANE\" SOOT_YIELD=0.10,CO_YIELD=5.E-2/\n"
    "&SPEC ID='monoxide', FORMULA='CO' /\n"
    "&DEVC ID='T', QUANTITY='TEMPERATURE', XYZ=3*0.5 /\n"
    "&devc ID='CO', QUANTITY='VOLUME FRACTION', SPEC_ID='monoxide', XYZ=1,1,1,\n"
    "   CONVERSION_FACTOR=1000000. /\n"
    "&DEVC ID='M', QUANTITY='TEMPERATURE', SPATIAL_STATISTIC='MEAN', XB(1:6)=0,1,0,1,0,1 /\n"
    "&DEVC ID='cut', QUANTITY='OXYGEN'\n"
    "&TAIL /\n";

TEST(FdsInput, SaysWhatOutputsDoNot) {
  ScratchFolder folder;
  fdswriter::saveText(folder / "case.fds", kText);
  const auto input = FdsInput::read(folder / "case.fds").value();
  EXPECT_EQ(input.chid, "case");
  EXPECT_EQ(input.visibilityFactor, 8);
  EXPECT_EQ(input.maximumVisibility, 100);
  EXPECT_EQ(input.ambient, 20);
  ASSERT_EQ(input.reactions.size(), 1U);
  EXPECT_EQ(input.reactions[0].fuel, "PROPANE");
  EXPECT_EQ(input.reactions[0].sootYield, 0.1);
  EXPECT_EQ(input.reactions[0].coYield, 0.05);
  EXPECT_EQ(input.devices.size(), 4U);
  EXPECT_EQ(input.devices.at("T").quantity, "TEMPERATURE");
  EXPECT_EQ(input.devices.at("CO").species, "CO");
  EXPECT_TRUE(input.devices.at("CO").scaled);
  EXPECT_FALSE(input.devices.at("T").scaled);
  EXPECT_EQ(input.devices.at("M").statistic, "MEAN");
  EXPECT_EQ(input.devices.at("cut").quantity, "OXYGEN") << "without a slash at its end";
}

TEST(FdsInput, NamelistsHaveAllValues) {
  const auto groups = namelists(kText, {"DEVC"});
  ASSERT_EQ(groups.size(), 4U);
  EXPECT_EQ(groups[0].line, 8);
  EXPECT_THAT(groups[0].values.at("XYZ"), ElementsAre("0.5", "0.5", "0.5"));
  EXPECT_EQ(groups[2].values.at("XB").size(), 6U);
  EXPECT_TRUE(namelists("&DEVC ID='", {"MISC"}).empty());
}

TEST(FdsInput, ImpossibleNumbersAreNamed) {
  ScratchFolder folder;
  fdswriter::saveText(folder / "a.fds", "&HEAD CHID='a' /\n&MISC VISIBILITY_FACTOR=-1 /\n");
  EXPECT_THAT(FdsInput::read(folder / "a.fds").error().message,
              HasSubstr("a.fds: line 2: VISIBILITY_FACTOR is '-1'; expected a number above 0"));
}

TEST(FdsInput, IsReadAsFortranReadsIt) {
  ScratchFolder folder;
  fdswriter::saveText(folder / "a.fds",
                      "&HEAD CHID='a' /\n&TIME T_BEGIN=-5. /\n"
                      "&MISC VISIBILITY_FACTOR ! of signs that emit light\n = 5., TMPA\n=20.,\n"
                      "  VISIBILITY_FACTOR=8. /\n"
                      "&SPEC ID='SOOT', MASS_EXTINCTION_COEFFICIENT=4350. /\n"
                      "&SPEC ID='FOG', MASS_EXTINCTION_COEFFICIENT=1. /\n"
                      "&SURF ID='FIRE', HRRPUA=500. /\n&SURF ID='WALL' /\n"
                      "&SURF ID='CARPET', HRRPUA=200., IGNITION_TEMPERATURE=300. /\n"
                      "&DEVC ID='rise', QUANTITY='TEMPERATURE', RELATIVE=.TRUE. /\n"
                      "&DEVC ID='dry', QUANTITY='VOLUME FRACTION', SPEC_ID='OXYGEN', DRY=T /\n"
                      "&DEVC ID='wet', QUANTITY='VOLUME FRACTION', SPEC_ID='OXYGEN', DRY=F /\n"
                      "&DEVC ID='mean', QUANTITY='TEMPERATURE',\n"
                      "  TEMPORAL_STATISTIC='RUNNING AVERAGE' /\n");
  const auto input = FdsInput::read(folder / "a.fds").value();
  EXPECT_EQ(input.visibilityFactor, 8) << "of two the later one, on several lines";
  EXPECT_EQ(input.begin, -5);
  EXPECT_EQ(input.massExtinction, 4350);
  EXPECT_THAT(input.burning, ElementsAre("FIRE"));
  EXPECT_EQ(input.devices.at("rise").statistic, "RELATIVE");
  EXPECT_EQ(input.devices.at("dry").statistic, "DRY");
  EXPECT_EQ(input.devices.at("wet").statistic, "");
  EXPECT_EQ(input.devices.at("mean").statistic, "RUNNING AVERAGE");
}

TEST(FdsInput, ReadsTheFilesThatItNames) {
  ScratchFolder folder;
  fdswriter::saveText(folder / "a.fds",
                      "&HEAD CHID='a' /\n&CATF OTHER_FILES='optics.fds','Fires.fds' /\n");
  EXPECT_THAT(FdsInput::read(folder / "a.fds").error().message,
              HasSubstr("a.fds: names another input file (CATF), which cannot be read"));
  fdswriter::saveText(folder / "optics.fds", "&HEAD CHID='b' /\n&MISC VISIBILITY_FACTOR=8. /\n");
  fdswriter::saveText(folder / "fires.fds", "&SURF ID='FIRE', MLRPUA=0.02 /\n");
  const auto input = FdsInput::read(folder / "a.fds").value();
  EXPECT_EQ(input.chid, "a");
  EXPECT_EQ(input.visibilityFactor, 8);
  EXPECT_THAT(input.burning, ElementsAre("FIRE"));
}

TEST(FdsInput, EndsAnywhere) {
  const std::string text(kText);
  for (std::size_t i = 0; i < text.size(); ++i) {
    (void)namelists(std::string_view(text).substr(0, i), {"HEAD", "MISC", "DEVC"});
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      (void)namelists(damaged, {"HEAD", "MISC", "DEVC"});
    }
  }
}

}  // namespace
}  // namespace volute
