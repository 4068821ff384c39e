// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/values.hpp"

#include <gtest/gtest.h>

namespace volute::cli {
namespace {

TEST(Values, NumbersAreFiniteAndWhole) {
  EXPECT_DOUBLE_EQ(*parseNumber("3e-3"), 3e-3);
  EXPECT_DOUBLE_EQ(*parseNumber("+2"), 2);
  for (const char* wrong : {"", "x", "1x", "nan", "inf", "1e999", " 1", "0x10", "1,5"}) {
    const auto number = parseNumber(wrong);
    ASSERT_FALSE(number) << wrong;
    EXPECT_EQ(number.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(number.error().message.find(fmt::format("'{}'", wrong)), std::string::npos);
  }
}

TEST(Values, BytesTakePowersOf1024) {
  EXPECT_EQ(parseBytes("123")->count, 123u);
  EXPECT_EQ(parseBytes("1B")->count, 1u);
  EXPECT_EQ(parseBytes("64k")->count, 64u << 10);
  EXPECT_EQ(parseBytes("512M")->count, 512u << 20);
  EXPECT_EQ(parseBytes("2GB")->count, 2ull << 30);
  EXPECT_EQ(parseBytes("1.5GiB")->count, 3ull << 29);
  for (const char* wrong : {"", "0", "-1", "M", "12Q", "1MM", "1e3", "9999999T", "1.2.3"})
    EXPECT_FALSE(parseBytes(wrong)) << wrong;
}

TEST(Values, FramesAreHalfOpenRangesOfNumbers) {
  EXPECT_EQ(*parseFrames("3:7"), (FrameRange{3, 7, 1}));
  EXPECT_EQ(*parseFrames(":7"), (FrameRange{std::nullopt, 7, 1}));
  EXPECT_EQ(*parseFrames("3:"), (FrameRange{3, std::nullopt, 1}));
  EXPECT_EQ(*parseFrames("::4"), (FrameRange{std::nullopt, std::nullopt, 4}));
  EXPECT_EQ(*parseFrames("0:100:5"), (FrameRange{0, 100, 5}));
  EXPECT_EQ(*parseFrames("37"), FrameRange::only(37));
  EXPECT_EQ(*parseFrames("-2:4"), (FrameRange{-2, 4, 1}));
  EXPECT_EQ(*parseFrames("1.25:2"), (FrameRange{1.25, 2, 1}));
  for (const char* wrong :
       {"", "a:b", "3:3", "7:3", "0:4:0", "0:4:-1", "0:4:1.5", "1:2:3:4", "nan:2", "1e12:"})
    EXPECT_FALSE(parseFrames(wrong)) << wrong;
}

TEST(Values, RegionsAreHalfOpenAndOrdered) {
  EXPECT_EQ(*parseRegion("0:16,8:24,1:2"), (Region{{0, 8, 1}, {16, 24, 2}}));
  for (const char* wrong : {"", "0:1,0:1", "0:0,0:1,0:1", "5:4,0:1,0:1", "-1:2,0:1,0:1",
                            "0:1,0:1,0:1,0:1", "a:b,0:1,0:1"}) {
    EXPECT_FALSE(parseRegion(wrong)) << wrong;
  }
}

TEST(Values, BoundsVectorsAndPictures) {
  EXPECT_EQ(parseBounds("-1,-2,-3,1,2,3")->min, Vec3(-1, -2, -3));
  EXPECT_FALSE(parseBounds("0,0,0,1,1"));
  EXPECT_FALSE(parseBounds("0,0,0,1,1,0"));
  EXPECT_EQ(*parseVector("1,-2.5,1e1"), Vec3(1, -2.5, 10));
  EXPECT_FALSE(parseVector("1,2"));
  EXPECT_EQ(*parsePixels("800x600"), (Pixels{800, 600}));
  for (const char* wrong : {"800", "0x4", "-1x4", "800X600", "99999x1", "1x2x3"})
    EXPECT_FALSE(parsePixels(wrong)) << wrong;
}

TEST(Values, LimitsAndChoicesNameWhatWasExpected) {
  const Option rms{.name = "rms", .kind = ValueKind::kNumber, .positive = true};
  EXPECT_EQ(parseValue(rms, "-1").error().message, "'-1' is out of range; expected more than 0");
  const Option degree{.name = "degree", .kind = ValueKind::kInteger, .least = 0, .most = 3};
  EXPECT_EQ(parseValue(degree, "4").error().message, "'4' is out of range; expected 0 to 3");
  const Option wavelet{
      .name = "wavelet", .kind = ValueKind::kChoice, .choices = {"auto", "haar", "cdf53"}};
  EXPECT_EQ(parseValue(wavelet, "harr").error().message,
            "'harr' is unknown (did you mean 'haar'?); expected one of auto, haar, cdf53");
}

}  // namespace
}  // namespace volute::cli
