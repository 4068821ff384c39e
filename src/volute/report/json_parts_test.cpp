// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/json_parts.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

std::string textOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(JsonParts, WithoutPartsTheTextIsThatOfTheTree) {
  const std::filesystem::path folder = ::testing::TempDir();
  const Json json = {
      {"a", {1, 2.5, nullptr, true}},
      {"empty", Json::array()},
      {"none", Json::object()},
      {"deep", {{"text", "\x01 \xff \" \n"}, {"list", {{{"x", 1}}, {{"y", 10.0}}}}}}};
  const JsonParts parts(folder);
  ASSERT_TRUE(parts.write(folder / "tree.json", json));
  EXPECT_EQ(textOf(folder / "tree.json"), dumpJson(json));
}

TEST(JsonParts, PartsStandInTheirPlaces) {
  const std::filesystem::path folder = ::testing::TempDir();
  JsonParts parts(folder);
  std::string numbers = "[";
  for (const double value : {10.0, 0.1, -1e300, std::numeric_limits<double>::quiet_NaN()}) {
    numbers += numbers.size() > 1 ? "," : "";
    appendJson(numbers, value);
  }
  numbers += "]";
  EXPECT_EQ(numbers, "[10.0,0.1,-1e+300,null]");
  Json json = {{"first", parts.add(numbers)}, {"between", 1}};
  std::string large(3 << 20, ' ');
  large.replace(0, 1, "[");
  large.back() = ']';
  json["list"] = Json::array({parts.add(large), parts.add("{\"x\": 2}")});
  ASSERT_TRUE(parts.write(folder / "parts.json", json));
  const Json read = Json::parse(textOf(folder / "parts.json"));
  EXPECT_EQ(read["first"][0], 10.0);
  EXPECT_TRUE(read["first"][3].is_null());
  EXPECT_EQ(read["list"][0], Json::array());
  EXPECT_EQ(read["list"][1]["x"], 2);
}

TEST(JsonParts, APartThatCannotBeKeptFailsTheFile) {
  JsonParts parts("/no/such/folder");
  const Json json = parts.add("[]");
  EXPECT_FALSE(parts.write(std::filesystem::path(::testing::TempDir()) / "x.json", json));
}

}  // namespace
}  // namespace volute
