// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/frame_pattern.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "volute/io/testing.hpp"

namespace volute {
namespace {

using namespace testing;

TEST(FramePattern, FormatsAsPrintfDoes) {
  ASSERT_VALUE(const auto padded, FramePattern::parse("out/flame_%04d.vdb"));
  EXPECT_EQ(padded.format(7), "out/flame_0007.vdb");
  EXPECT_EQ(padded.format(12345), "out/flame_12345.vdb");
  ASSERT_VALUE(const auto plain, FramePattern::parse("%d.vti"));
  EXPECT_EQ(plain.format(42), "42.vti");
  ASSERT_VALUE(const auto hashes, FramePattern::parse("a_###_100%%.png"));
  EXPECT_EQ(hashes.format(5), "a_005_100%.png");
  ASSERT_VALUE(const auto folder, FramePattern::parse("job#12/my%20files/%04d/x_%04d.png"));
  EXPECT_EQ(folder.format(5), "job#12/my%20files/%04d/x_0005.png");
  EXPECT_EQ(padded.format(-2), "out/flame_-0002.vdb");
  EXPECT_EQ(padded.format(125, {2}), "out/flame_0001.25.vdb");
  EXPECT_EQ(padded.format(150, {2}), "out/flame_0001.5.vdb");
  EXPECT_EQ(padded.format(-150, {2, true}), "out/flame_-0001.50.vdb");
  EXPECT_EQ(padded.format(200, {2}), "out/flame_0002.vdb");
}

RC_GTEST_PROP(FramePattern, MatchesWhatItFormats, ()) {
  const int number = *rc::gen::inRange(-999999999, 1000000000);
  const FrameScale scale{*rc::gen::inRange(0, 7), true};
  const auto pattern = FramePattern::parse(
      *rc::gen::element("f_%04d.vdb", "%d", "x##y.vdb", "%09d.a", "s.$F3.vdb", "s_<frame>.vdb"));
  const auto match = pattern->match(pattern->format(number, scale).filename().string());
  RC_ASSERT(match.has_value());
  RC_ASSERT(match->number == number && match->scale.decimals == scale.decimals);
}

TEST(FramePattern, GapsAreNamed) {
  const auto said = [](std::vector<int> numbers) { return missingNumbers(numbers); };
  EXPECT_EQ(said({}), "");
  EXPECT_EQ(said({7}), "");
  EXPECT_EQ(said({1, 900}), "");
  EXPECT_EQ(said({1, 2, 3}), "");
  EXPECT_EQ(said({0, 10, 20, 30}), "");
  EXPECT_EQ(said({0, 7, 20}), "");  // in no steps
  EXPECT_EQ(said({1, 2, 4}), "1 of the frames 1 to 4 is missing: 3");
  EXPECT_EQ(said({1, 2, 5, 7, 10}), "5 of the frames 1 to 10 are missing: 3 to 4, 6, 8 to 9");
  EXPECT_EQ(said({0, 10, 40}), "2 of the frames 0 to 40 are missing: 20 to 30");
  std::vector<int> many;
  for (int i = 0; i < 10000; ++i) {
    if (i % 1000 != 5)
      many.push_back(i);
  }
  EXPECT_EQ(said(many),
            "10 of the frames 0 to 9999 are missing: 5, 1005, 2005, 3005, 4005, 5005, 6005, 7005 "
            "and 2 more gaps");
}

TEST(FramePattern, DoesNotMatchOtherNames) {
  ASSERT_VALUE(const auto pattern, FramePattern::parse("f_%03d.vdb"));
  for (const char* name :
       {"f_01.vdb", "f_0001.vdb", "f_abc.vdb", "f_.vdb", "f_-1.vdb", "f_-000.vdb", "f_001.",
        "f_001..5.vdb", "f_001.1234567.vdb", "f_--001.vdb", "f_001.vd", "g_001.vdb",
        "f_001.vdb.bak", "f_1234567890.vdb", ""}) {
    EXPECT_FALSE(pattern.match(name)) << name;
  }
}

TEST(FramePattern, RefusesWhatIsNotOneFrameNumber) {
  for (const char* text :
       {"f_%s.vdb", "f_%4d.vdb", "f_%x", "f_%00d", "f_%", "f_%0", "%d_%d.vdb", "##_##.vdb",
        "dir_%04d/f.vdb", "plain.vdb", "take#1.png", "out 50%.png", "50%%.png", "f_$F4_%04d.vdb",
        "$F12.vdb", "$Folder.vdb", "##########.vdb", "%012d"}) {
    const auto pattern = FramePattern::parse(text);
    ASSERT_FALSE(pattern) << text;
    EXPECT_EQ(pattern.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(FramePattern, ListsByNumberAndSkipsGaps) {
  const TempFolder folder;
  for (const char* name : {"f_10.vdb", "f_9.vdb", "f_2.vdb", "f_02.vdb", "g_3.vdb", "f_3.txt"})
    writeBytes(folder / name, "");
  ASSERT_VALUE(const auto pattern, FramePattern::parse(folder / "f_%d.vdb"));
  ASSERT_VALUE(const auto files, pattern.list());
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[0].number, 2);
  EXPECT_EQ(files[1].number, 9);
  EXPECT_EQ(files[2].path, folder / "f_10.vdb");
  // What has a frame's name and is no file would be a gap that nobody sees.
  std::filesystem::create_directory(folder / "f_4.vdb");
  EXPECT_EQ(pattern.list().error().code, ErrorCode::kInvalidData);
  std::filesystem::remove(folder / "f_4.vdb");
  std::filesystem::create_symlink("nowhere", folder / "f_4.vdb");
  EXPECT_EQ(pattern.list().error().code, ErrorCode::kInvalidData);
}

TEST(FramePattern, ManySeriesOfOneFolder) {
  const TempFolder folder;
  for (const char* name :
       {"a_1.png", "a_2.png", "ab_1.png", "1_a.png", "2_a.png", "7_ba.png", "a.png"})
    writeBytes(folder / name, "");
  FolderFiles folders;
  const auto numbers = [&](const char* name) {
    std::vector<int> found;
    const auto pattern = FramePattern::parse(folder / name);
    const auto files = pattern.value().list(folders);
    for (std::size_t i = 0; files && i < files->size(); ++i) {
      EXPECT_EQ((*files)[i].path, pattern->format((*files)[i].number));
      found.push_back((*files)[i].number);
    }
    return found;
  };
  EXPECT_EQ(numbers("a_%d.png"), (std::vector<int>{1, 2}));
  EXPECT_EQ(numbers("ab_%d.png"), (std::vector<int>{1}));
  EXPECT_EQ(numbers("%d_a.png"), (std::vector<int>{1, 2}));
  EXPECT_EQ(numbers("%d_ba.png"), (std::vector<int>{7}));
  EXPECT_EQ(numbers("%d.png"), (std::vector<int>{}));
  writeBytes(folder / "a_3.png", "");
  EXPECT_EQ(numbers("a_%d.png"), (std::vector<int>{1, 2})) << "it is listed once";
}

TEST(FramePattern, SaysWhenNothingIsThere) {
  const TempFolder folder;
  ASSERT_VALUE(const auto pattern, FramePattern::parse(folder / "f_%d.vdb"));
  EXPECT_EQ(pattern.list().error().code, ErrorCode::kNotFound);
  ASSERT_VALUE(const auto nowhere, FramePattern::parse(folder / "none/f_%d.vdb"));
  EXPECT_EQ(nowhere.list().error().code, ErrorCode::kNotFound);
}

TEST(NumberedFiles, TakesTheLastDigitsOfTheStem) {
  EXPECT_EQ(frameNumberOf("v2_flame_0031.vdb"), 31);
  EXPECT_EQ(frameNumberOf("flame12b.vdb"), 12);
  EXPECT_EQ(frameNumberOf("flame.vdb2"), std::nullopt);
  EXPECT_EQ(frameNumberOf("f_12345678901.vdb"), std::nullopt);
  EXPECT_EQ(frameNumberOf("s_-0002.vdb"), -2);
  EXPECT_EQ(frameNumberOf("-2.vdb"), -2);
  EXPECT_EQ(frameNumberOf("shot-0002.vdb"), 2);
  EXPECT_EQ(frameNumberOf("shot-010-0002.vdb"), 2);
}

TEST(NumberedFiles, NegativeFramesAndFramesBetweenWholeOnes) {
  const auto numbers = [](const std::vector<NumberedFile>& files) {
    std::vector<double> frames;
    for (const NumberedFile& file : files) frames.push_back(file.frame());
    return frames;
  };
  const TempFolder folder;
  for (const char* name : {"s_0.vdb", "s_-1.vdb", "s_1.vdb", "s_-2.vdb"})
    writeBytes(folder / name, "");
  ASSERT_VALUE(const auto pattern, FramePattern::parse(folder / "s_%d.vdb"));
  ASSERT_VALUE(const auto listed, pattern.list());
  EXPECT_EQ(numbers(listed), (std::vector<double>{-2, -1, 0, 1}));
  ASSERT_VALUE(const auto inFolder, listNumberedFiles(folder.path(), ".vdb"));
  EXPECT_EQ(numbers(inFolder), (std::vector<double>{-2, -1, 0, 1}));

  const TempFolder parts;
  for (const char* name : {"s.0001.vdb", "s.0001.25.vdb", "s.0001.5.vdb", "s.0002.vdb"})
    writeBytes(parts / name, "");
  ASSERT_VALUE(const auto sub, FramePattern::parse(parts / "s.%04d.vdb"));
  EXPECT_EQ(sub.list().error().code, ErrorCode::kUnsupported);
  ASSERT_VALUE(const auto all, sub.list(SubFrames::kAllowed));
  EXPECT_EQ(numbers(all), (std::vector<double>{1, 1.25, 1.5, 2}));
  for (const NumberedFile& file : all) EXPECT_EQ(sub.format(file.number, file.scale), file.path);
  ASSERT_VALUE(const auto same, listNumberedFiles(parts.path(), ".vdb"));
  EXPECT_EQ(numbers(same), (std::vector<double>{1, 1.25, 1.5, 2}));

  const TempFolder versions;  // no fractions of 1
  for (const char* name : {"s.v1.0001.vdb", "s.v1.0002.vdb"}) writeBytes(versions / name, "");
  ASSERT_VALUE(const auto whole, listNumberedFiles(versions.path(), ".vdb"));
  EXPECT_EQ(numbers(whole), (std::vector<double>{1, 2}));
}

TEST(NumberedFiles, WhatIsLeftOutIsSaid) {
  const TempFolder folder;
  for (const char* name : {"s_01.vdb", "s_2.vdb", "s_3.vdb", "s_x.vdb", "s_4.txt", "s.vdb"})
    writeBytes(folder / name, "");
  EXPECT_EQ(leftOutFiles(folder / "s_%d.vdb", ".vdb"), "1 file is left out: s_01.vdb");
  EXPECT_EQ(leftOutFiles(folder.path(), ".vdb"), "2 files are left out: s.vdb, s_x.vdb");
  EXPECT_EQ(leftOutFiles(folder / "s_2.vdb", ".vdb"), "");
  // As %+d and %4d write them.
  const TempFolder printed;
  for (const char* name : {"c-1.vdb", "c+0.vdb", "c+1.vdb", "c   2.vdb", "c1000.vdb", "c +.vdb"})
    writeBytes(printed / name, "");
  EXPECT_EQ(leftOutFiles(printed / "c%d.vdb", ".vdb"),
            "3 files are left out: c   2.vdb, c+0.vdb, c+1.vdb");
}

TEST(FramePattern, AnExistingFileIsNoPattern) {
  const TempFolder folder;
  writeBytes(folder / "take##.vdb", "");
  EXPECT_TRUE(namesSeries(folder / "take##.vdb"));
  EXPECT_FALSE(namesSeriesOfFiles(folder / "take##.vdb"));
  EXPECT_TRUE(namesSeriesOfFiles(folder / "take_##.vdb"));
}

TEST(NumberedFiles, TwoSeriesInOneFolderAreAnError) {
  const TempFolder folder;
  for (const char* name : {"flame_1.vdb", "flame_2.vdb", "smoke_7.vdb"})
    writeBytes(folder / name, "");
  const auto files = listNumberedFiles(folder.path(), ".vdb");
  ASSERT_FALSE(files);
  for (const char* part : {"2 sequences", "flame_%d.vdb (2 files)", "smoke_%d.vdb (1 file)"})
    EXPECT_NE(files.error().message.find(part), std::string::npos) << files.error().message;
}

TEST(NumberedFiles, DatesBeforeTheNumberAreNoFrames) {
  const TempFolder folder;
  for (const char* name : {"sim.20240101.0001.vdb", "sim.20240102.0001.vdb"})
    writeBytes(folder / name, "");
  const auto files = listNumberedFiles(folder.path(), ".vdb");
  ASSERT_FALSE(files);
  EXPECT_NE(files.error().message.find("sim.20240101.####.vdb (1 file)"), std::string::npos)
      << files.error().message;
}

TEST(NumberedFiles, PatternsThatAreNamedMatch) {
  const TempFolder folder;
  for (const char* name :
       {"a_0009.vdb", "a_0010.vdb", "b.-2.vdb", "b.0.vdb", "b.10.vdb", "c.-01.vdb", "c.000.vdb",
        "s.0100.00.vdb", "s.0100.50.vdb", "s.0101.00.vdb", "u_99.vdb", "u_0100.vdb"})
    writeBytes(folder / name, "");
  const auto files = listNumberedFiles(folder.path(), ".vdb");
  ASSERT_FALSE(files);
  const std::string& text = files.error().message;
  for (const auto& [name, count] :
       {std::pair("a_####.vdb", 2U), std::pair("b.%d.vdb", 3U), std::pair("c.###.vdb", 2U),
        std::pair("s.####.vdb", 3U), std::pair("u_<frame>.vdb", 2U)}) {
    EXPECT_NE(text.find(fmt::format("{} ({} files)", name, count)), std::string::npos) << text;
    const auto matching = FramePattern::parse(folder / name).value().list(SubFrames::kAllowed);
    ASSERT_TRUE(matching) << name;
    EXPECT_EQ(matching->size(), count) << name;
  }
}

}  // namespace
}  // namespace volute
