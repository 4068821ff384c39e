// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/frame_name.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "volute/base/output_name.hpp"
#include "volute/base/program.hpp"

namespace volute {
namespace {

TEST(FrameName, FindsTheNumberInAName) {
  struct Case {
    const char* name;
    std::size_t begin, end;
    int width;
  };

  for (const Case& one :
       {Case{"f_%04d.vdb", 2, 6, 4}, Case{"%d", 0, 2, 1}, Case{"f.####.vdb", 2, 6, 4},
        Case{"take_#.png", 5, 6, 1}, Case{"take#1_##.png", 7, 9, 2}, Case{"a%20_%03d.x", 5, 9, 3},
        Case{"s.$F4.vdb", 2, 5, 4}, Case{"s.${F4}.vdb", 2, 7, 4}, Case{"s.$F.vdb", 2, 4, 1},
        Case{"s.$FF.vdb", 2, 5, 1}, Case{"s_<frame>.vdb", 2, 9, 1}}) {
    const auto found = findFrameField(one.name);
    ASSERT_TRUE(found && *found) << one.name;
    EXPECT_EQ((*found)->begin, one.begin) << one.name;
    EXPECT_EQ((*found)->end, one.end) << one.name;
    EXPECT_EQ((*found)->width, one.width) << one.name;
  }
}

TEST(FrameName, OtherPercentAndHashSignsAreCharacters) {
  for (const char* name : {"take#1.png", "out 50%.png", "50%%.png", "a%20b.volute", "f_%s.vdb",
                           "C#.7z.x#y", "$Folder.vdb", "<frames>.vdb", "x_%%04d.png", "a.b#"}) {
    const auto found = findFrameField(name);
    EXPECT_TRUE(found && !*found) << name;
  }
}

TEST(FrameName, RefusesSeveralNumbersAndWideOnes) {
  for (const char* name : {"%d_%d.vdb", "##_##.vdb", "f_%4d.vdb", "%012d", "##########", "$F12.x"})
    EXPECT_FALSE(findFrameField(name)) << name;
}

TEST(OutputName, KeepsPercentAndHashOfAFileThatIsThere) {
  const auto before = std::filesystem::current_path();
  const ScratchFolder folder;
  std::filesystem::current_path(folder.path());
  for (const char* name : {"take##.volute", "x%04d.volute", "smoke_50%.volute"})
    std::ofstream(name) << 'x';
  // But for what an output would read as numbers.
  EXPECT_EQ(derivedOutput("take##.volute", ".png"), "take.png");
  EXPECT_EQ(derivedOutput("x%04d.volute", ".png"), "x.png");
  EXPECT_EQ(derivedOutput("smoke_50%.volute", ".png"), "smoke_50%.png");
  EXPECT_EQ(derivedOutput("a%20b.volute", ".png"), "a%20b.png");
  EXPECT_EQ(derivedOutput("take#2.volute", ".png"), "take#2.png");
  EXPECT_EQ(derivedOutput("t#2 %04d.volute", ".png"), "t#2.png");
  EXPECT_EQ(derivedOutput("cache_%04d.vdb", ".volute"), "cache.volute");
  EXPECT_EQ(derivedOutput("cache.$F4.vdb", ".volute"), "cache.volute");
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace volute
