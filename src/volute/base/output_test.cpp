// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "volute/base/leftovers.hpp"
#include "volute/base/output_file.hpp"
#include "volute/base/output_folder.hpp"
#include "volute/base/program.hpp"
#include "volute/base/write_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Output : public ::testing::Test {
 protected:
  std::string textOf(const fs::path& path) const {
    std::ifstream stream(path);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  mode_t modeOf(const fs::path& path) const {
    struct stat status{};
    ::stat(path.c_str(), &status);
    return status.st_mode & 07777;
  }

  /// Of a process that has ended.
  static pid_t deadProcess() {
    const pid_t child = ::fork();
    if (child == 0)
      ::_exit(0);
    ::waitpid(child, nullptr, 0);
    return child;
  }

  const ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
};

TEST_F(Output, AReplacedFileHandsOnItsMode) {
  const fs::path file = folder_ / "a.txt";
  std::ofstream(file) << "old";
  for (const mode_t mode : {0600, 0664, 0755}) {
    ::chmod(file.c_str(), mode);
    ASSERT_TRUE(writeFile(file, "new"));
    EXPECT_EQ(modeOf(file), mode);
  }
  EXPECT_EQ(textOf(file), "new");
}

TEST_F(Output, ASymbolicLinkStaysAndItsFileIsReplaced) {
  fs::create_directory(folder_ / "there");
  std::ofstream(folder_ / "there/a.txt") << "old";
  fs::create_symlink("there/a.txt", folder_ / "link.txt");
  fs::create_symlink("link.txt", folder_ / "second.txt");
  fs::create_symlink("there/fresh.txt", folder_ / "dangling.txt");
  ASSERT_TRUE(writeFile(folder_ / "second.txt", "new"));
  ASSERT_TRUE(writeFile(folder_ / "dangling.txt", "fresh"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "second.txt"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(textOf(folder_ / "there/a.txt"), "new");
  EXPECT_EQ(textOf(folder_ / "there/fresh.txt"), "fresh");
  fs::create_symlink("round.txt", folder_ / "round.txt");
  EXPECT_THAT(writeFile(folder_ / "round.txt", "x").error().message, HasSubstr("leads nowhere"));
}

TEST_F(Output, WhatIsNoFileIsNotReplaced) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0666), 0);
  EXPECT_THAT(writeFile(folder_ / "pipe", "x").error().message, HasSubstr("no regular file"));
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
  EXPECT_FALSE(writeFile(folder_, "x"));
}

TEST_F(Output, AWriteProtectedFileIsNotReplaced) {
  if (::geteuid() == 0)
    GTEST_SKIP() << "root may write to it";
  const fs::path file = folder_ / "a.txt";
  std::ofstream(file) << "old";
  ::chmod(file.c_str(), 0444);
  EXPECT_THAT(writeFile(file, "new").error().message, HasSubstr("write-protected (mode 0444)"));
  EXPECT_EQ(textOf(file), "old");
}

TEST_F(Output, PartsOfKilledRunsAreKnown) {
  const pid_t dead = deadProcess();
  const std::string own = fmt::format(".a.{}.0.part.png", ::getpid());
  const std::string part = fmt::format(".a.b.{}.12.part.png", dead);
  const std::string whole = fmt::format(".out.{}.0.part", dead);
  for (const std::string& name : {own, part, std::string(".part"), std::string("a.1.0.part.png"),
                                  std::string(".a.x.0.part"), std::string(".git")})
    std::ofstream(folder_ / name) << "x";
  fs::create_directory(folder_ / whole);
  EXPECT_EQ(processOfPart(own), ::getpid());
  EXPECT_EQ(processOfPart(part), dead);
  EXPECT_EQ(processOfPart(".out.77.0.old.part"), 77);
  EXPECT_FALSE(processOfPart(".a.12.part.png"));
  EXPECT_THAT(leftoversIn(folder_), ::testing::ElementsAre(folder_ / part, folder_ / whole));
}

TEST_F(Output, AFolderIsReplacedAsAWhole) {
  const fs::path target = folder_ / "out";
  for (const char* text : {"first", "second"}) {
    auto folder = PendingFolder::create(target, "mark");
    ASSERT_TRUE(folder);
    std::ofstream(folder->path() / "mark") << text;
    ASSERT_TRUE(folder->commit());
    EXPECT_EQ(textOf(target / "mark"), text);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(Output, FilesThatNoRunWroteStayInAFolderThatIsReplaced) {
  const fs::path target = folder_ / "out";
  for (const std::string text : {"one", "two", "three"}) {
    auto folder = PendingFolder::create(target, "mark");
    ASSERT_TRUE(folder);
    std::ofstream(folder->path() / "mark") << text;
    fs::create_directory(folder->path() / "maps");
    std::ofstream(folder->path() / "maps" / text) << text;
    ASSERT_TRUE(folder->commit());
    if (text == "one") {
      std::ofstream(target / "notes.txt") << "mine";
      std::ofstream(target / "maps" / "two") << "mine";  // what the next run writes
      fs::create_directory_symlink("/", target / "link");
    }
  }
  EXPECT_EQ(textOf(target / "mark"), "three");
  EXPECT_EQ(textOf(target / "notes.txt"), "mine");
  EXPECT_EQ(textOf(target / "maps" / "two.kept"), "mine");
  EXPECT_FALSE(fs::exists(target / "maps" / "two"));
  EXPECT_TRUE(fs::is_symlink(target / "link"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(Output, ASymbolicLinkStaysAndItsFolderIsReplaced) {
  fs::create_directory(folder_ / "scratch");
  fs::create_directory_symlink("scratch/out/", folder_ / "link");
  fs::create_directory_symlink("link", folder_ / "second");
  const fs::path out = folder_ / "scratch/out";
  for (const std::string name : {"link", "second", "link/"}) {  // the first one dangles
    auto folder = PendingFolder::create(folder_ / name, "mark");
    ASSERT_TRUE(folder) << folder.error().message;
    EXPECT_EQ(fs::canonical(folder->path().parent_path()), fs::canonical(folder_ / "scratch"));
    std::ofstream(folder->path() / "mark") << name;
    ASSERT_TRUE(folder->commit());
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "second"));
    EXPECT_EQ(textOf(out / "mark"), name);
    std::ofstream(out / "notes.txt") << "mine";
  }
  EXPECT_EQ(textOf(out / "notes.txt"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "scratch"), {}), 1);
  fs::create_directory(out / "empty");
  fs::create_directory_symlink("scratch/out/empty", folder_ / "to_empty");
  {
    auto folder = PendingFolder::create(folder_ / "to_empty", "mark");
    ASSERT_TRUE(folder);
    ASSERT_TRUE(folder->commit());
  }
  EXPECT_TRUE(fs::is_symlink(folder_ / "to_empty"));
  fs::create_directory_symlink("round", folder_ / "round");
  EXPECT_THAT(PendingFolder::create(folder_ / "round", "mark").error().message,
              HasSubstr("leads nowhere"));
}

TEST_F(Output, AFolderThatAKilledRunMovedAwayComesBack) {
  const fs::path target = folder_ / "out";
  const pid_t dead = deadProcess();
  fs::create_directory(folder_ / fmt::format(".out.{}.0.old.part", dead));
  std::ofstream(folder_ / fmt::format(".out.{}.0.old.part/mark", dead)) << "old";
  {
    const auto folder = PendingFolder::create(target, "mark");
    ASSERT_TRUE(folder);
    EXPECT_EQ(textOf(target / "mark"), "old");
  }  // nothing was committed
  EXPECT_EQ(textOf(target / "mark"), "old");
}

/// Runs that all replace one folder: none fails, one of theirs is left whole, and nothing beside
/// it.
TEST_F(Output, RunsThatReplaceOneFolderAtOnceAllSucceed) {
  const fs::path target = folder_ / "out";
  constexpr int kRuns = 4;
  for (const bool isNew : {true, false}) {
    pid_t children[kRuns];
    for (pid_t& child : children) {
      child = ::fork();
      if (child != 0)
        continue;
      for (int i = 0; i < 300; ++i) {
        auto folder = PendingFolder::create(target, "mark");
        if (!folder)
          ::_exit(1);
        std::ofstream(folder->path() / "mark") << ::getpid();
        std::ofstream(folder->path() / "other") << ::getpid();
        if (!folder->commit())
          ::_exit(2);
        // As if nothing had been there, for the next one.
        std::error_code ignored;
        const fs::path away = folder_ / fmt::format("away{}", ::getpid());
        if (isNew) {
          fs::rename(target, away, ignored);
          fs::remove_all(away, ignored);
        }
      }
      ::_exit(0);
    }
    for (const pid_t child : children) {
      int status = -1;
      ::waitpid(child, &status, 0);
      EXPECT_EQ(status, 0) << "exit code " << WEXITSTATUS(status) << ", new folders: " << isNew;
    }
  }
  EXPECT_EQ(textOf(target / "mark"), textOf(target / "other"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

}  // namespace
}  // namespace volute
