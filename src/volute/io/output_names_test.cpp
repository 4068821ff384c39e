// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/output_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/io/named_files.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace testing;

TEST(OutputNames, NoTwoHaveOneNameHoweverItIsSpelt) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "sub");
  std::filesystem::create_directory_symlink("sub", folder / "link");
  const std::string base = folder.path().string();
  OutputNames names;
  ASSERT_TRUE(names.add(base + "/sub/x.npy", "the volume"));
  for (const char* same : {"/sub/x.npy", "/sub/../sub/./x.npy", "/link/x.npy"}) {
    const Status status = names.add(base + same, "statistics");
    ASSERT_FALSE(status) << same;
    EXPECT_THAT(status.error().message, HasSubstr("the volume and statistics"));
  }
  EXPECT_TRUE(names.add(base + "/x.npy", "another"));
  ASSERT_TRUE(names.add(base + "/f_%04d.png", "pictures"));
  EXPECT_FALSE(names.add(base + "/f_0012.png", "statistics"));
  EXPECT_TRUE(names.add(base + "/f_12.json", "statistics"));
  EXPECT_TRUE(names.add(base + "/sub/f_0012.png", "statistics"));
}

TEST(OutputNames, LinksLeadToOneFile) {
  const TempFolder folder;
  const std::string base = folder.path().string();
  std::filesystem::create_symlink("x.npy", folder / "to_x.npy");
  std::filesystem::create_symlink("to_x.npy", folder / "to_link.npy");
  std::filesystem::create_symlink("s.json", folder / "f_0003.png");
  for (const char* link : {"/to_x.npy", "/to_link.npy"}) {  // whether x.npy is there or not
    OutputNames names;
    ASSERT_TRUE(names.add(base + "/x.npy", "the volume"));
    EXPECT_FALSE(names.add(base + link, "statistics")) << link;
  }
  OutputNames names;
  ASSERT_TRUE(names.add(base + "/f_%04d.png", "pictures"));
  EXPECT_FALSE(names.add(base + "/s.json", "statistics"));
}

TEST(OutputNames, WhatIsReadIsNotReplaced) {
  const TempFolder folder;
  const std::string base = folder.path().string();
  std::filesystem::create_directory(folder / "in");
  writeBytes(folder / "in" / "a_0001.npy", "x");
  std::filesystem::create_symlink("in/a_0001.npy", folder / "link.json");
  std::filesystem::create_hard_link(folder / "in" / "a_0001.npy", folder / "hard.json");
  for (const char* input : {"/in/a_0001.npy", "/in/a_%04d.npy", "/in"}) {
    EXPECT_TRUE(replaces(base + "/in/a_0001.npy", base + input)) << input;
    EXPECT_TRUE(replaces(base + "/link.json", base + input)) << input;
    EXPECT_FALSE(replaces(base + "/in/a.json", base + input)) << input;
    EXPECT_FALSE(replaces(base + "/a_0001.npy", base + input)) << input;
  }
  EXPECT_TRUE(replaces(base + "/hard.json", base + "/in/a_0001.npy"));
  EXPECT_TRUE(replaces(base + "/in/a_%04d.npy", base + "/in/a_%04d.npy"));
}

TEST(OutputNames, APatternReplacesFilesOfTheFolderThatIsRead) {
  const TempFolder folder;
  const std::string base = folder.path().string();
  writeBytes(folder / "a_0001.vdb", "x");
  EXPECT_TRUE(replaces(base + "/a_%04d.vdb", base));
  EXPECT_FALSE(replaces(base + "/b_%04d.vdb", base));
}

TEST(OutputNames, ChecksWhatAnInputNames) {
  const TempFolder folder;
  const std::string base = folder.path().string();
  writeBytes(folder / "a.pvd", R"(<VTKFile><Collection><DataSet file="b.vti"/></Collection>)");
  writeBytes(folder / "b.vti", "x");
  writeBytes(folder / "s.json", R"({"media": [{"file": "c.npy"}]})");
  const std::vector<std::string> inputs{base + "/a.pvd", "", base + "/s.json"};
  EXPECT_TRUE(checkReplacesNothing(base + "/d.vti", inputs));
  EXPECT_TRUE(checkReplacesNothing("-", inputs));
  for (const char* output : {"/a.pvd", "/b.vti", "/c.npy"}) {
    const Status status = checkReplacesNothing(base + output, inputs, "stats");
    ASSERT_FALSE(status) << output;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(status.error().member, "stats");
    EXPECT_THAT(status.error().message, HasSubstr("and would be replaced; give another name"));
  }
}

TEST(OutputNames, AreNotLongerThanFileSystemsTake) {
  OutputNames names;
  EXPECT_TRUE(names.add(std::string(251, 'x') + ".npy", "the volume"));
  const Status status = names.add(std::string(250, 'x') + "%04d.vdb", "frames");
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("frames has a name of 258 bytes"));
  EXPECT_FALSE(names.add(std::string(252, 'x') + ".npy", "another"));
}

TEST(OutputNames, NamesOfFilesStayInTheFolder) {
  for (const char* good : {"density", "a b", "v.x", "Rauch µ"})
    EXPECT_TRUE(checkNamePart(good, "it"));
  for (const char* bad : {"../victim/data", "/etc/x", "", "..", "a\nb"})
    EXPECT_FALSE(checkNamePart(bad, "it")) << bad;
}

TEST(NamedFiles, NoDisguiseLeadsOutOfTheFolder) {
  const TempFolder folder;
  for (const char* name : {"in", "in/links", "in/own", "secret"})
    std::filesystem::create_directory(folder / name);
  writeBytes(folder / "secret" / "s_0001.npy", "x");
  writeBytes(folder / "in" / "own" / "s_0001.npy", "x");
  std::filesystem::create_symlink("../secret/s_0001.npy", folder / "in" / "p_0001.npy");
  std::filesystem::create_symlink("../../secret/s_0001.npy", folder / "in" / "links" / "a_1.npy");
  std::filesystem::create_symlink("own", folder / "in" / "same");
  const auto outside = [&](const std::string& file, const std::string& text) {
    writeBytes(folder / "in" / file, "{\"media\": [{\"file\": \"" + text + "\"}]}");
    return namesOutside((folder / "in" / file).string());
  };
  EXPECT_THAT(outside("a.json", std::string(300, 'x')), ElementsAre()) << "is no file";
  for (const char* bad : {"../secret/", "../secret/s_0001.npy", "p_%04d.npy", "p_####.npy",
                          "p_0001.npy", "links", "links/", "../no_such_%04d.npy"})
    EXPECT_THAT(outside("a.json", bad), ElementsAre(bad));
  EXPECT_THAT(outside("b.JSON", "../secret/s_0001.npy"), ElementsAre("../secret/s_0001.npy"));
  for (const char* good : {"own/s_0001.npy", "own", "same/s_%04d.npy", "1/m", "/", "kg/m3"})
    EXPECT_TRUE(outside("a.json", good).empty()) << good;
  outside("inner.json", "../secret/");
  EXPECT_THAT(outside("a.json", "inner.json"), ElementsAre("../secret/"));
}

TEST(NamedFiles, CasesAndInputsOfFdsAreGoneThrough) {
  const TempFolder folder;
  for (const char* name : {"in", "in/sub", "my secrets"})
    std::filesystem::create_directory(folder / name);
  writeBytes(folder / "my secrets" / "c", "x");
  std::filesystem::create_symlink("../my secrets/c", folder / "in" / "link");
  std::filesystem::create_symlink("../my secrets/c", folder / "in" / "1.0");
  const auto outside = [&](const std::string& lines) {
    writeBytes(folder / "in" / "c.smv", lines);
    return namesOutside((folder / "in" / "c.smv").string());
  };
  for (const char* bad :
       {"../my secrets/c", "..\\my secrets\\c", "..\\MY secrets\\C", "link", "LINK", "1.0"})
    EXPECT_EQ(outside("SLCF 1\n " + std::string(bad) + "\n soot\n").size(), 1U) << bad;
  EXPECT_TRUE(outside("TITLE\n a/b: 1.0 m2/kg\nGRID a\n 1 2 3\n 2.0\n").empty());
  const auto named = [&](const std::string& input, const std::string& name) {
    writeBytes(folder / "in" / "input.txt", "&CATF\n other_files(1) = 'a.fds', '" + name + "' /\n");
    return outside("GRID c\nINPF\n " + input + "\n");
  };
  for (const char* input : {"input.txt", "INPUT.TXT", "sub/input.txt", "no_such\\input.txt"}) {
    for (const char* bad : {"../my secrets/c", "..\\my secrets\\c", "link", "Link"})
      EXPECT_EQ(named(input, bad).size(), 1U) << input << ' ' << bad;
    EXPECT_TRUE(named(input, "sub/b.fds").empty());
  }
}

}  // namespace
}  // namespace volute
