// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/confinement.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <optional>
#include <string>

#include "volute/base/program.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_helper.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

Result<const LatticePlugin*> loadHostilePlugin() {
  VOLUTE_ASSIGN(const void* plugin,
                loadPlugin("volute_io_hostile", "voluteHostilePlugin", "nothing"));
  return static_cast<const LatticePlugin*>(plugin);
}

/// With readers forked from this process, and from a helper.
class Confinement : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer's process is not confined";
#endif
    if (GetParam())
      helper_.emplace();
    testing::writeBytes(file_, "whatever");
    testing::writeBytes(other_, "a secret");
  }

  /// What the hostile reader says when it tries `what` while it reads file_.
  std::string attempt(const std::string& what, std::uint64_t maxMemory = 64 << 20) {
    SourceOptions options;
    options.grid = what;
    options.maxMemory = maxMemory;
    const auto source = openLatticeSource({{0, file_, std::nullopt}}, loadHostilePlugin, options);
    return source ? "it worked" : source.error().message;
  }

  testing::TempFolder folder_;
  std::filesystem::path file_ = folder_.path() / "a.vdb", other_ = folder_.path() / "b.vdb";

 private:
  std::optional<ReaderHelper> helper_;
};

TEST_P(Confinement, ItReadsItsFile) {
  EXPECT_THAT(attempt("read FILE"), HasSubstr("read FILE worked"));
}

TEST_P(Confinement, ItReadsNoOtherFile) {
  if (!detail::readingIsConfined())
    GTEST_SKIP() << "this kernel has no Landlock";
  const std::string secret = other_.string();
  for (const std::string& what :
       {"read " + secret, "list " + folder_.path().string(), std::string("read /etc/passwd"),
        std::string("read /proc/self/maps"), std::string("read /proc/1/environ")})
    EXPECT_THAT(attempt(what), HasSubstr("was refused")) << what;
}

TEST_P(Confinement, ItWritesNothing) {
  const std::string fresh = (folder_.path() / "fresh").string();
  for (const std::string& what :
       {std::string("write FILE"), "create " + fresh, "write " + other_.string(),
        "remove " + other_.string(), "rename " + other_.string()})
    EXPECT_THAT(attempt(what), HasSubstr("was refused")) << what;
  EXPECT_FALSE(std::filesystem::exists(fresh));
  EXPECT_TRUE(std::filesystem::exists(other_));
}

TEST_P(Confinement, ItReachesNobody) {
  for (const char* what : {"connect", "run /bin/true", "fork", "kill", "trace", "rights"})
    EXPECT_THAT(attempt(what), HasSubstr("was refused")) << what;
}

TEST_P(Confinement, ItTakesNoMoreThanItIsGiven) {
  for (const char* what : {"shorten", "code", "hoard", "limit", "outlive"})
    EXPECT_THAT(attempt(what), HasSubstr("was refused")) << what;
}

TEST_P(Confinement, ItsMemoryIsWhatIsAllowedAndItsLibraries) {
  for (const std::uint64_t allowed : {1, 48, 200}) {
    const auto take = [&](std::uint64_t more) {
      return attempt(fmt::format("take {}", allowed + more), allowed << 20);
    };
    EXPECT_THAT(take(40), HasSubstr("worked")) << allowed;
    EXPECT_THAT(take(60), HasSubstr("was refused")) << allowed;
  }
}

TEST_P(Confinement, WhatItAnswersIsChecked) {
  EXPECT_THAT(attempt("lie"), HasSubstr("its reader describes a grid that cannot be"));
  EXPECT_THAT(attempt("flood"), HasSubstr(file_.string()));
}

INSTANTIATE_TEST_SUITE_P(Processes, Confinement, ::testing::Bool(), [](const auto& info) {
  return info.param ? "OfTheHelper" : "OfTheProgram";
});

/// Answers with its process, or keeps a core busy.
Result<ReaderProcess::Serve> serveForever(std::string_view) {
  return [](std::string_view request, std::span<float>) -> Result<std::string> {
    static volatile std::size_t busy = 0;
    while (request == "work") busy = busy + 1;
    return toMessage(::getpid());
  };
}

/// A program that is killed while a reader works for it.
void beKilled(bool withHelper, int told) {
  std::optional<ReaderHelper> helper;
  if (withHelper)
    helper.emplace();
  ReaderProcess reader(ReaderJob{serveForever});
  const auto process = reader.call("file", "who", 0, {64 << 20, 60});
  (void)!::write(told, process ? process->data() : "none", sizeof(pid_t));
  (void)reader.call("file", "work", 0, {64 << 20, 60});
  ::_exit(0);
}

TEST_P(Confinement, ItEndsWithTheProgram) {
  int line[2];
  ASSERT_EQ(::pipe(line), 0);
  ASSERT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0), 0);  // so that its end is seen here
  const pid_t program = ::fork();
  if (program == 0)
    beKilled(GetParam(), line[1]);
  pid_t reader = 0;
  ASSERT_EQ(::read(line[0], &reader, sizeof reader), static_cast<ssize_t>(sizeof reader));
  ::usleep(100'000);
  ::kill(program, SIGKILL);
  ::waitpid(program, nullptr, 0);
  int status = 0;
  pid_t ended = 0;
  for (int i = 0; i < 3000 && ended == 0; ++i) {
    ::usleep(10'000);
    ended = ::waitpid(reader, &status, WNOHANG);
  }
  ::kill(reader, SIGKILL);
  ::close(line[0]);
  ::close(line[1]);
  EXPECT_EQ(ended, reader) << "it outlives the program";
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
}

TEST(ConfinedProgram, ReadsWhatItNeedsAndWritesNothing) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's process is not confined";
#endif
  const testing::TempFolder folder;
  const auto given = folder / "given", secret = folder / "secret", said = folder / "said";
  testing::writeBytes(given, "given");
  testing::writeBytes(secret, "secret");
  testing::writeBytes(said, "");
  const std::vector<std::filesystem::path> programs{"/usr", "/bin", "/lib", "/lib64",
                                                    "/etc/ld.so.cache"};
  const std::string script = "cat; cat " + secret.string() + "; echo x >" + folder.path().string() +
                             "/new && echo wrote; echo end";
  EXPECT_TRUE(runProgram({"/bin/sh", "-c", script},
                         {.seconds = 20,
                          .memory = std::uint64_t{1} << 30,
                          .input = given,
                          .output = said,
                          .confine = [&] { return detail::confineProgram(programs); }}));
  EXPECT_EQ(testing::readBytes(said),
            detail::readingIsConfined() ? "givenend\n" : "givensecretwrote\nend\n");
}

}  // namespace
}  // namespace volute
