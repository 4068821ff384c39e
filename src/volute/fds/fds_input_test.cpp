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
  fdswriter::Folder folder;
  fdswriter::saveText(folder / "case.fds", kText);
  const auto input = FdsInput::read(folder / "case.fds").value();
  EXPECT_EQ(input.chid, "case");
  EXPECT_EQ(input.visibilityFactor, 8);
  EXPECT_EQ(input.maximumVisibility, 100);
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
  const auto groups = fdsNamelists(kText, {"DEVC"});
  ASSERT_EQ(groups.size(), 4U);
  EXPECT_EQ(groups[0].line, 8);
  EXPECT_THAT(groups[0].values.at("XYZ"), ElementsAre("0.5", "0.5", "0.5"));
  EXPECT_EQ(groups[2].values.at("XB").size(), 6U);
  EXPECT_TRUE(fdsNamelists("&DEVC ID='", {"MISC"}).empty());
}

TEST(FdsInput, ImpossibleNumbersAreNamed) {
  fdswriter::Folder folder;
  fdswriter::saveText(folder / "a.fds", "&HEAD CHID='a' /\n&MISC VISIBILITY_FACTOR=-1 /\n");
  EXPECT_THAT(FdsInput::read(folder / "a.fds").error().message,
              HasSubstr("a.fds: line 2: VISIBILITY_FACTOR is '-1'; expected a number above 0"));
}

TEST(FdsInput, EndsAnywhere) {
  const std::string text(kText);
  for (std::size_t i = 0; i < text.size(); ++i) {
    (void)fdsNamelists(std::string_view(text).substr(0, i), {"HEAD", "MISC", "DEVC"});
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      (void)fdsNamelists(damaged, {"HEAD", "MISC", "DEVC"});
    }
  }
}

}  // namespace
}  // namespace volute
