// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/parse.hpp"

#include <gtest/gtest.h>

#include "volute/base/suggest.hpp"

namespace volute::cli {
namespace {

const Command& sample() {
  static const Command command{
      .name = "sample",
      .summary = "A command for tests",
      .examples = {},
      .description = "",
      .positionals = {{.name = "INPUT", .help = "what to read"}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = ValueKind::kFile,
                   .value = "OUT",
                   .help = "target",
                   .required = true},
                  {.name = "rms", .kind = ValueKind::kNumber, .value = "R", .positive = true},
                  {.name = "psnr", .kind = ValueKind::kNumber, .value = "DB"},
                  {.name = "eye", .kind = ValueKind::kVector, .value = "X,Y,Z"},
                  {.name = "level", .kind = ValueKind::kInteger, .value = "L", .initial = "2"},
                  {.name = "name", .kind = ValueKind::kText, .value = "N", .several = true},
                  {.name = "partial"}},
      .oneOf = {{{"rms", "psnr"}, true}}};
  return command;
}

std::string messageOf(const std::vector<std::string>& words) {
  const auto arguments = parseArguments(sample(), words);
  return arguments ? "" : arguments.error().message;
}

TEST(Parse, SomeOptionsMayBeRepeated) {
  const auto arguments =
      parseArguments(sample(), {"in.npy", "-o", "x", "--rms", "1", "--name", "b", "--name=a,c"});
  ASSERT_TRUE(arguments) << arguments.error().message;
  EXPECT_EQ(arguments->find<std::vector<std::string>>("name"),
            (std::vector<std::string>{"b", "a,c"}));
  const auto without = parseArguments(sample(), {"in.npy", "-o", "x", "--rms", "1"});
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_TRUE(without->find<std::vector<std::string>>("name")->empty());
  EXPECT_FALSE(without->given("name"));
}

TEST(Parse, ReadsOptionsInAnyOrderAndForm) {
  const auto arguments = parseArguments(sample(), {"--rms=3e-3", "in.npy", "--eye", "-1,-2,3", "-o",
                                                   "-", "--partial", "--threads", "2"});
  ASSERT_TRUE(arguments) << arguments.error().message;
  EXPECT_EQ(arguments->positional(0), "in.npy");
  EXPECT_EQ(arguments->get<std::string>("output"), "-");
  EXPECT_EQ(arguments->get<double>("rms"), 3e-3);
  EXPECT_EQ(arguments->get<Vec3>("eye"), Vec3(-1, -2, 3));
  EXPECT_EQ(arguments->get<int>("threads"), 2);
  EXPECT_TRUE(arguments->flag("partial"));
  EXPECT_EQ(arguments->get<int>("level"), 2);
  EXPECT_FALSE(arguments->given("level"));
  EXPECT_FALSE(arguments->find<double>("psnr"));
}

TEST(Parse, NamesInBracketsAndAfterTwoDashesAreNames) {
  EXPECT_EQ(parseArguments(sample(), {"-ox", "--rms", "1", "[a,b]"})->positional(0), "[a,b]");
  EXPECT_EQ(parseArguments(sample(), {"-ox", "--rms", "1", "--", "--odd"})->positional(0), "--odd");
}

TEST(Parse, WrongUsageIsOneSentence) {
  EXPECT_EQ(messageOf({"in", "-oout", "--rsm", "1"}), "unknown option --rsm; did you mean --rms?");
  EXPECT_EQ(messageOf({"in", "-oout", "--zzzzzz"}), "unknown option --zzzzzz");
  EXPECT_EQ(messageOf({"in", "-oout"}), "one of --rms, --psnr is missing");
  EXPECT_EQ(messageOf({"in", "-oout", "--rms", "1", "--psnr", "2"}),
            "2 of --rms, --psnr are given; expected one");
  EXPECT_EQ(messageOf({"in", "--rms", "1"}), "--output OUT is missing: target");
  EXPECT_EQ(messageOf({"-oout", "--rms", "1"}), "INPUT is missing: what to read");
  EXPECT_EQ(messageOf({"in", "more", "-oout", "--rms", "1"}), "'more' is one argument too many");
  EXPECT_EQ(messageOf({"in", "-oout", "--rms"}), "--rms needs a value");
  EXPECT_EQ(messageOf({"in", "-oout", "--rms", "0"}),
            "--rms: '0' is out of range; expected more than 0");
  EXPECT_EQ(messageOf({"in", "-oout", "--rms", "1", "--rms", "2"}),
            "--rms is given 2 times; expected once");
}

TEST(Parse, HelpNeedsNothingElse) {
  EXPECT_TRUE(parseArguments(sample(), {"--help"}));
}

TEST(Parse, CommonOptionsMayPrecedeTheCommand) {
  EXPECT_EQ(*findCommandWord({"--threads", "4", "info", "x"}), 2u);
  EXPECT_EQ(*findCommandWord({"info", "--json"}), 0u);
  EXPECT_EQ(*findCommandWord({"--quiet"}), 1u);
  EXPECT_EQ(findCommandWord({"--quite"}).error().message,
            "unknown option --quite; did you mean --quiet?");
}

TEST(Suggest, CountsEditsAndSwaps) {
  EXPECT_EQ(editDistance("", "abc"), 3u);
  EXPECT_EQ(editDistance("compres", "compress"), 1u);
  EXPECT_EQ(editDistance("rsm", "rms"), 1u);
  EXPECT_EQ(editDistance("abc", "abc"), 0u);
}

TEST(Suggest, IsSilentWhenNothingIsNear) {
  const std::vector<std::string_view> names{"compress", "compare", "info"};
  EXPECT_EQ(nearest("comprss", names), "compress");
  EXPECT_EQ(nearest("compr", names), "compress");
  EXPECT_EQ(nearest("wobble", names), "");
}

}  // namespace
}  // namespace volute::cli
