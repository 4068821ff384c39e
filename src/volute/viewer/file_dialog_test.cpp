// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/file_dialog.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "volute/base/program.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

class FileDialog : public ::testing::Test {
 protected:
  ~FileDialog() override { ::setenv("PATH", path_.c_str(), 1); }

  /// A program of this name is the only one there is.
  void program(const std::string& name, const std::string& lines) {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << lines;
    fs::permissions(folder_ / name, fs::perms::owner_all);
    ::setenv("PATH", folder_.c_str(), 1);
  }

  static std::optional<std::string> answer(DesktopDialog& dialog) {
    for (int i = 0; i < 12000; ++i) {
      if (auto said = dialog.poll())
        return said;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return std::nullopt;
  }

  const ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
  const std::string path_ = ::getenv("PATH");
};

TEST_F(FileDialog, IsTheDesktops) {
  program("zenity", "echo \"/some/fire $#.volute\"\n");
  auto dialog = DesktopDialog::open("/some");
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(answer(*dialog), "/some/fire 3.volute");
  EXPECT_EQ(dialog->poll(), "") << "only once";
}

TEST_F(FileDialog, IsKdialogWhereThereIsNoZenity) {
  program("kdialog", "echo \"$4/a.vdb\"\n");
  auto dialog = DesktopDialog::open("/some");
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(answer(*dialog), "/some/a.vdb");
}

TEST_F(FileDialog, MayBeCancelled) {
  program("zenity", "exit 1\n");
  auto dialog = DesktopDialog::open("/some");
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(answer(*dialog), "");
}

TEST_F(FileDialog, EndsWithTheViewer) {
  program("zenity", "exec /bin/sleep 60\n");
  const auto begun = std::chrono::steady_clock::now();
  auto dialog = DesktopDialog::open("/some");
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(dialog->poll(), std::nullopt);
  dialog.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20));
}

TEST_F(FileDialog, IsNoneWhereThereIsNoProgram) {
  ::setenv("PATH", folder_.c_str(), 1);
  EXPECT_EQ(DesktopDialog::open("/some"), nullptr);
}

TEST_F(FileDialog, ListsFoldersAndWhatItOpensFirst) {
  fs::create_directory(folder_ / "zoo");
  for (const char* name : {"a.txt", "b.VDB", ".hidden.vdb", "a.volute"})
    std::ofstream(folder_ / name) << 1;
  std::vector<std::string> names;
  for (const FolderEntry& entry : folderEntries(folder_)) names.push_back(entry.name);
  EXPECT_THAT(names, ::testing::ElementsAre("zoo", "a.volute", "b.VDB", "a.txt"));
  EXPECT_EQ(folderEntries(folder_, 2).size(), 2);
  EXPECT_TRUE(folderEntries(folder_ / "nowhere").empty());
}

TEST_F(FileDialog, RemembersWhatWasOpened) {
  const fs::path file = folder_ / "state" / "recent";
  {
    RecentFiles recent(file);
    EXPECT_TRUE(recent.names().empty());
    for (int i = 0; i < 12; ++i) recent.add(fmt::format("/a/{}.vdb", i));
    recent.add("/a/5.vdb");
    EXPECT_EQ(recent.names().size(), 10);
  }
  const RecentFiles again(file);
  ASSERT_EQ(again.names().size(), 10);
  EXPECT_EQ(again.names()[0], "/a/5.vdb");
  EXPECT_EQ(again.names()[1], "/a/11.vdb");
  RecentFiles nowhere;
  nowhere.add("relative.vdb");
  EXPECT_TRUE(fs::path(nowhere.names()[0]).is_absolute());
}

}  // namespace
}  // namespace volute
