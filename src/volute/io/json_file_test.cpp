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
using testing::TempFolder;
using testing::writeBytes;

std::string messageOf(const std::string& text, std::size_t most = SIZE_MAX) {
  const TempFolder folder;
  writeBytes(folder / "a.json", text);
  const auto json = readJson(folder / "a.json", most);
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
  EXPECT_EQ(messageOf(R"({"a": 1, "b": {"a": 2, "b": 3}})", 2), "");
  EXPECT_THAT(messageOf(R"({"a": 1, "o": {"a": 2, "b": 3, "c": 4}})", 2),
              HasSubstr("an object of more than 2 members in o"));
}

}  // namespace
}  // namespace volute
