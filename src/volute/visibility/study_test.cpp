// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Runs as `volute visibility` leaves them.
class StudyComparison : public ::testing::Test {
 protected:
  /// A plan of 2 x 1 points at a height, whose signs are lost at these times; null: never.
  static Json plan(double height, const Json& times, std::size_t remarks = 0) {
    return {{"times", {0, 10, 60}},
            {"eyes",
             {{"kind", "plan"},
              {"origin", {0.5, 0.5}},
              {"height", height},
              {"step", 1},
              {"nx", 2},
              {"ny", 1}}},
            {"plan", {"11"}},
            {"aset", {{{"rows", {times}}}}},
            {"remarks", std::vector<std::string>(remarks, "a remark")}};
  }

  static StudyRun run(const std::string& name) { return {name, name + ".smv", "", {}}; }

  void write(const std::filesystem::path& folder, const Json& json) const {
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(writeFile(folder / "visibility.json", dumpJson(json)));
  }

  /// A run with one plan for each height.
  void add(StudyResults& results, const std::string& name,
           const std::vector<std::pair<double, Json>>& storeys) const {
    const auto folder = folder_ / name;
    Json list = Json::array();
    for (const auto& [height, times] : storeys) {
      const std::string storey = fmt::format("z_{:g}", height);
      Json json = plan(height, times, 2);
      json["tenability"]["margin"]["least"]["value"] = 10 - height;
      write(folder / storey, json);
      list.push_back({{"height", height}, {"folder", storey}});
    }
    write(folder, {{"times", {0, 10, 60}},
                   {"verdict",
                    {{{"criterion", "sign lost first"},
                      {"time", 10},
                      {"time_interpolated", 9.5},
                      {"height", 4.8}}}},
                   {"heights", list}});
    ASSERT_TRUE(results.add(run(name), folder));
  }

  std::vector<std::string> compared(const StudyResults& results) {
    const auto folder = folder_ / "compared";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    remarks_ = results.compare(folder).value();
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".vti")
        names.push_back(entry.path().stem().string());
    }
    std::ranges::sort(names);
    return names;
  }

  /// The `array`-th of a file in compared/.
  std::array<float, 2> values(const std::string& name, std::size_t array = 0) const {
    const std::string text = readText(folder_ / "compared" / (name + ".vti")).value();
    std::array<float, 2> two{};
    const std::size_t begin = text.find("\n_") + 2 + array * (8 + sizeof two) + 8;
    std::memcpy(two.data(), text.data() + begin, sizeof two);
    return two;
  }

  testing::TempFolder folder_;
  std::vector<std::string> remarks_;
};

TEST_F(StudyComparison, RunsWithOnePlanAreComparedWithTheBaseline) {
  StudyResults results("b");
  for (const char* name : {"a", "b"}) {
    write(folder_ / name, plan(1.8, {20, 30}, 1));
    ASSERT_TRUE(results.add(run(name), folder_ / name));
  }
  EXPECT_THAT(compared(results), ElementsAre("a_difference", "spread"));
  EXPECT_THAT(remarks_, IsEmpty());
}

TEST_F(StudyComparison, EachStoreyIsComparedWithTheSameHeightOfOtherRuns) {
  StudyResults results("a");
  add(results, "a", {{1.8, {20, 30}}, {4.8, {10, nullptr}}});
  add(results, "b", {{1.8, {20, 30}}, {4.8, {40, nullptr}}});
  add(results, "c", {{4.8, {10, 20}}, {9, {1, 2}}});
  EXPECT_THAT(compared(results), ElementsAre("b_z_1.8_difference", "b_z_4.8_difference",
                                             "c_z_4.8_difference", "spread_z_1.8", "spread_z_4.8"));
  EXPECT_THAT(remarks_,
              ElementsAre("run 'c' has another plan at z = 9 m than 'a': it is not compared"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "compared" / "b_z_4.8_difference.png"));
  EXPECT_THAT(values("b_z_1.8_difference"), ElementsAre(0, 0));
  EXPECT_THAT(values("b_z_4.8_difference"), ElementsAre(30, 0));
  EXPECT_THAT(values("c_z_4.8_difference"), ElementsAre(0, 20 - 60));
  EXPECT_THAT(values("spread_z_4.8", 0), ElementsAre(10, 20));
  EXPECT_THAT(values("spread_z_4.8", 1), ElementsAre(20, FloatEq(140.0F / 3)));
  EXPECT_THAT(values("spread_z_1.8", 2), ElementsAre(20, 30));
  // The table has the storey of the earliest loss, the smallest margin, and the remarks of all.
  EXPECT_THAT(results.table(), HasSubstr("height [m]"));
  EXPECT_THAT(results.table(), HasSubstr("\na,a.smv,,1,,3,0,60,10,yes,10,9.5,4.8,0,5.2,yes,4\n"));
}

TEST_F(StudyComparison, ARunWithOneStoreyIsComparedWithThatHeightOfTheBaseline) {
  StudyResults results("a");
  add(results, "a", {{1.8, {20, 30}}, {4.8, {10, nullptr}}});
  write(folder_ / "b", plan(4.8, {20, 30}));
  ASSERT_TRUE(results.add(run("b"), folder_ / "b"));
  EXPECT_THAT(compared(results), ElementsAre("b_z_4.8_difference", "spread_z_4.8"));
  EXPECT_THAT(remarks_, IsEmpty());
}

TEST(StudyFile, ARunThatIsThereTwiceIsRefused) {
  const testing::TempFolder folder;
  const auto message = [&](const Json& cases) {
    const auto file = folder / "study.json";
    EXPECT_TRUE(writeFile(file, dumpJson({{"cases", cases}, {"options", {{"height", 2}}}})));
    const auto study = Study::read(file.string());
    return study ? "read" : study.error().message;
  };
  EXPECT_EQ(message({"a.smv", "b.smv"}), "read");
  EXPECT_EQ(message({"a.smv", {{"case", "a.smv"}, {"options", {{"height", 1}}}}}), "read");
  EXPECT_THAT(message({"a.smv", "./a.smv"}), HasSubstr("with the same options, as a and a_2"));
  EXPECT_THAT(message({"a.smv", {{"case", "a.smv"}, {"name", "b"}}}),
              HasSubstr("with the same options, as a and b"));
}

TEST(StudyFile, FilesAreThoseBesideItAndWordsStayWords) {
  const testing::TempFolder folder;
  const auto file = folder / "study.json";
  const auto wordOf = [&](const std::string& option, const std::string& value) {
    EXPECT_TRUE(writeFile(file, dumpJson({{"cases", {"a.smv"}}, {"options", {{option, value}}}})));
    return Study::read(file.string()).value().runs[0].words[0];
  };
  const auto wordOfFile = [&](const std::string& option, const std::string& name) {
    return "--" + option + "=" + (folder / name).string();
  };
  for (const char* option : {"signs", "areas", "underlay", "route", "criteria", "rset"})
    EXPECT_EQ(wordOf(option, "own.json"), wordOfFile(option, "own.json"));
  EXPECT_EQ(wordOf("rset", "100"), "--rset=100");
  for (const char* name : {"usual", "none", "iso-13571", "nz-c4.3", "iso-1357"})
    EXPECT_EQ(wordOf("criteria", name), std::string("--criteria=") + name);
  ASSERT_TRUE(writeFile(folder / "mine", "{}"));
  EXPECT_EQ(wordOf("criteria", "mine"), wordOfFile("criteria", "mine"));
}

TEST_F(StudyComparison, AStoreyThatIsMissingIsAnError) {
  StudyResults results("a");
  write(folder_ / "a",
        {{"times", {0}}, {"heights", {{{"height", 1.8}, {"folder", "../../z_1.8"}}}}});
  const auto status = results.add(run("a"), folder_ / "a");
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr((folder_ / "a" / "z_1.8").string()));
  EXPECT_THAT(results.table(), Not(HasSubstr("a.smv")));
}

}  // namespace
}  // namespace volute
