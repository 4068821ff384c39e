// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

std::string messageOf(const std::string& text, const JsonLimits& limits = {}) {
  const TempFolder folder;
  writeBytes(folder / "a.json", text);
  const auto json = readJson(folder / "a.json", limits);
  return json ? std::string() : json.error().message;
}

TEST(JsonFile, AMemberThatIsThereTwiceIsRefusedWithItsPlace) {
  EXPECT_EQ(messageOf(R"({"a": 1, "b": {"a": 2}, "c": [{"a": 1}, {"a": 1}]})"), "");
  EXPECT_THAT(messageOf("{\"limit\": 0.3,\n \"limit\": 300}"),
              HasSubstr("a.json: line 2: 'limit' is there twice; expected it once"));
  EXPECT_THAT(messageOf(R"({"media": [{"x": 1}, {"time": {"rate": 1, "b": [1, 2], "rate": 2}}]})"),
              HasSubstr("'rate' is there twice in media[1]/time"));
  EXPECT_THAT(messageOf(R"({"ab": 1, "\u0061b": 2})"), HasSubstr("'ab' is there twice"));
  EXPECT_EQ(messageOf(R"({"a": "b", "b": "a", "c": "\"a\": 1, {"})"), "");
  EXPECT_THAT(messageOf(R"({"a": 1, "a)"), HasSubstr("line 1 is no valid JSON"));
}

TEST(JsonFile, NothingStandsBehindANul) {
  EXPECT_THAT(messageOf(std::string("{\"a\": 1}\0{\"a\": 2}", 17)), HasSubstr("byte 9 is 0"));
}

TEST(JsonFile, ObjectsMayBeLimited) {
  EXPECT_EQ(messageOf(R"({"a": 1, "b": {"a": 2, "b": 3}})", {.members = 2}), "");
  EXPECT_THAT(messageOf(R"({"a": 1, "o": {"a": 2, "b": 3, "c": 4}})", {.members = 2}),
              HasSubstr("an object of more than 2 members in o"));
}

TEST(JsonFile, ItsValuesAreCountedBeforeTheyAreMade) {
  std::string text = "[[]";
  for (int i = 1; i < 100'000; ++i) text += ",[]";
  text += "]";
  EXPECT_EQ(messageOf(text, {.memory = 10 << 20}), "");
  EXPECT_THAT(messageOf(text, {.memory = 9 << 20}),
              HasSubstr("its 0 MB of JSON need about 9 MiB, more than the 9 MiB allowed"));
}

TEST(JsonFile, TheOutermostObjectAlone) {
  const TempFolder folder;
  writeBytes(folder / "a.json",
             R"({"a": 1, "b": {"a": 2}, "c": [{"d": 1}, 3], "e": "f", "g": []})");
  EXPECT_EQ(readOutermostJson(folder / "a.json").value().dump(),
            R"({"a":1,"b":null,"c":null,"e":"f","g":null})");
  writeBytes(folder / "a.json", R"([1, {"a": 2}])");
  EXPECT_TRUE(readOutermostJson(folder / "a.json").value().is_array());
  writeBytes(folder / "a.json", R"({"a": 1, "b": })");
  EXPECT_FALSE(readOutermostJson(folder / "a.json"));
}

TEST(JsonFile, EachText) {
  const TempFolder folder;
  writeBytes(folder / "a.json", R"({"a": "1", "b": {"a": ["2", ["3", 4]]}, "c": [{"d": "5"}, 3]})");
  std::string all;
  const auto add = [&](const std::string& text) { all += text; };
  EXPECT_TRUE(forEachJsonText(folder / "a.json", add));
  EXPECT_EQ(all, "1235");
  writeBytes(folder / "a.json", R"("6")");
  EXPECT_TRUE(forEachJsonText(folder / "a.json", add));
  EXPECT_EQ(all, "12356");
}

}  // namespace
}  // namespace volute
