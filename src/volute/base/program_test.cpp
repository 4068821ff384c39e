// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/program.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace volute {
namespace {

TEST(Program, isFoundByItsFirstNameThatIsThere) {
  EXPECT_EQ(findProgram({"volute-no-such-program"}), "");
  const std::string shell = findProgram({"volute-no-such-program", "sh"});
  EXPECT_TRUE(shell.ends_with("/sh")) << shell;
}

TEST(Program, runsAndIsKilledAtItsEnd) {
  const ScratchFolder folder;
  ASSERT_FALSE(folder.path().empty());
  const std::string file = (folder.path() / "said").string();
  const std::string shell = findProgram({"sh"});
  EXPECT_TRUE(runProgram({shell, "-c", "echo word; echo done > " + file}, {.seconds = 60}));
  std::string said;
  std::ifstream(file) >> said;
  EXPECT_EQ(said, "done");
  EXPECT_FALSE(runProgram({shell, "-c", "while :; do :; done"}, {.seconds = 0.1}));
  EXPECT_TRUE(runProgram({"/nowhere/at/all"}, {.seconds = 60}))
      << "it has ended, having written nothing";
}

TEST(ScratchFolder, goesWithWhatIsInIt) {
  std::filesystem::path path;
  {
    const ScratchFolder folder;
    path = folder.path();
    std::ofstream(path / "a") << "word";
    EXPECT_TRUE(std::filesystem::exists(path / "a"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace volute
