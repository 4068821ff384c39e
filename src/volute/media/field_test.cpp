// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/media/clock_fields.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/field_sliders.hpp"

namespace volute {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

/// A kind of object of its own, as a new medium would bring it.
struct Puffs {
  double width = 2;
  int count = 3;
  bool glows = false;
  enum class Shape { kRound, kLong } shape = Shape::kRound;
  Vec3 middle = Vec3::Zero();
  Rgb tint = Rgb::Ones();
  double low = 0, high = 1;
  std::optional<double> limit{};
  std::string file{};
  Clock clock{};
};

const FieldTable& puffFields() {
  using enum FieldType;
  static constexpr std::string_view kShapes[] = {"round", "long"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "file", .type = kFile, .access = member<&Puffs::file>(), .help = "where they are",
       .required = true},
      {.name = "width", .access = member<&Puffs::width>(), .help = "of each", .unit = "m",
       .least = 0, .above = true, .otherName = "size", .option = {"M"},
       .slider = {.label = "width", .most = 10, .logarithmic = true, .room = 2}},
      {.name = "count", .type = kInteger, .access = member<&Puffs::count>(), .help = "how many",
       .least = 1, .most = 9, .slider = {.label = "count"}},
      {.name = "glows", .type = kFlag, .access = member<&Puffs::glows>(), .help = "by itself",
       .slider = {.label = "glows"}},
      {.name = "shape", .type = kChoice, .access = member<&Puffs::shape>(), .help = "of each",
       .choices = kShapes, .slider = {.label = "shape"}},
      {.name = "middle", .type = kPoint, .access = member<&Puffs::middle>(), .help = "of all",
       .unit = "m", .fewest = 2},
      {.name = "tint", .type = kColor, .access = member<&Puffs::tint>(), .help = "of light",
       .least = 0, .most = 1},
      {.name = "between", .type = kNumbers, .access = memberPair<&Puffs::low, &Puffs::high>(),
       .help = "two heights", .count = 2, .slider = {.label = "low|high", .least = -1, .most = 1}},
      {.name = "limit", .access = member<&Puffs::limit>(), .help = "where there is one"},
      clockField<&Puffs::clock>()};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Puffs>({.name = "puffs", .sentence = "puffs", .fields = kFields, .kind = "puffs"});
  return kTable;
}

Result<Puffs> puffs(const char* text) {
  return readAs<Puffs>(puffFields(), Json::parse(text), {"dir/scene.json", "/media/0"});
}

std::string wrongly(const char* text) {
  const auto read = puffs(text);
  return read ? "no error" : read.error().message;
}

TEST(Fields, ReadEachTypeIntoItsMember) {
  const auto read = puffs(
      R"({"kind": "puffs", "file": "a.npy", "size": 4, "count": 5, "glows": true, "shape": "long",
          "middle": [1, 2], "tint": [0, 0.5, 1], "between": [-1, 3], "limit": 7,
          "time": {"rate": 2, "loop": true}})");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->file, "dir/a.npy");
  EXPECT_EQ(read->width, 4);
  EXPECT_EQ(read->count, 5);
  EXPECT_TRUE(read->glows);
  EXPECT_EQ(read->shape, Puffs::Shape::kLong);
  EXPECT_EQ(read->middle, Vec3(1, 2, 0));
  EXPECT_EQ(read->tint[1], 0.5);
  EXPECT_EQ(read->low, -1);
  EXPECT_EQ(read->high, 3);
  EXPECT_EQ(read->limit, 7);
  EXPECT_EQ(read->clock.rate, 2);
  EXPECT_TRUE(read->clock.loop);
}

TEST(Fields, WriteWhatIsNotAsItIsByItself) {
  const char* text =
      R"({"kind":"puffs","file":"a.npy","count":4,"between":[0.0,5.0],"time":{"rate":3.0}})";
  const auto read = puffs(text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(writeFields(puffFields(), &*read, "dir/scene.json").dump(), text);
  EXPECT_EQ(writeFields(puffFields(), &*read, "other/scene.json")["file"], "dir/a.npy");
}

TEST(Fields, ErrorsSayWhereWhatWasFoundAndWhatWasExpected) {
  const std::string at = "dir/scene.json: /media/0";
  EXPECT_EQ(wrongly(R"({"kind": "puffs"})"),
            at + "/file: is missing; expected the name of a file: where they are");
  EXPECT_EQ(wrongly(R"({"file": "x", "width": 0})"),
            at + "/width: 0 is out of range; expected more than 0");
  EXPECT_EQ(wrongly(R"({"file": "x", "width": "x"})"),
            at + "/width: expected a number of more than 0 [m]");
  EXPECT_EQ(wrongly(R"({"file": "x", "count": 1.5})"),
            at + "/count: expected a whole number of 1 to 9");
  EXPECT_EQ(wrongly(R"({"file": "x", "count": 10})"),
            at + "/count: 10 is out of range; expected 1 to 9");
  EXPECT_EQ(wrongly(R"({"file": "x", "glows": 1})"), at + "/glows: expected true or false");
  EXPECT_EQ(wrongly(R"({"file": "x", "shape": "lang"})"),
            at + "/shape: 'lang' is unknown (did you mean 'long'?); expected one of round, long");
  EXPECT_EQ(wrongly(R"({"file": "x", "middle": [1]})"),
            at + "/middle: expected two or three numbers [m]");
  EXPECT_EQ(wrongly(R"({"file": "x", "middle": [1, "y"]})"), at + "/middle[1]: expected a number");
  EXPECT_EQ(wrongly(R"({"file": "x", "tint": [0, 2, 0]})"),
            at + "/tint: [0,2,0] is out of range; expected three numbers of 0 to 1");
  EXPECT_EQ(wrongly(R"({"file": "x", "time": {"rate": 0}})"),
            at + "/time/rate: 0 is out of range; expected more than 0");
  EXPECT_EQ(wrongly(R"({"file": "x", "time": {"rate": 1e38}})"),
            at + "/time/rate: 1e+38 is out of range; expected more than 0, not beyond 1e+30");
  EXPECT_EQ(wrongly(R"({"file": "x", "colour": 1})"), at + "/colour: this name is unknown");
  EXPECT_EQ(wrongly(R"({"file": "x", "widht": 1})"),
            at + "/widht: this name is unknown; did you mean 'width'?");
  EXPECT_EQ(wrongly(R"({"file": "x", "width": 1, "size": 1})"),
            at + "/width: size says the same; leave one out");
  EXPECT_EQ(wrongly("3"), at + ": expected a puffs object");
  const auto option = readAs<Puffs>(puffFields(), Json{{"file", "x"}, {"width", -1}}, {});
  EXPECT_EQ(option.error().member, "width");
  EXPECT_EQ(option.error().message, "-1 is out of range; expected more than 0");
  EXPECT_EQ(option.error().code, ErrorCode::kInvalidArgument);
}

TEST(Fields, BecomeSliders) {
  const auto read = puffs(R"({"file": "x", "width": 30, "count": 4, "shape": "long"})");
  std::vector<Parameter> out;
  ParameterGroup group(out, "puffs", "/media/2");
  addSliders(group, puffFields(), &*read, {.frames = 5, .seconds = 2});
  std::vector<std::string> paths;
  for (const Parameter& made : out)
    paths.push_back(made.path.substr(std::string("/media/2/").size()));
  EXPECT_THAT(paths, testing::ElementsAre("width", "count", "glows", "shape", "between/0",
                                          "between/1", "time/offset", "time/rate", "time/loop"));
  EXPECT_EQ(out[0].most, 60);
  EXPECT_EQ(out[0].unit, "m");
  EXPECT_EQ(out[1].least, 1);
  EXPECT_EQ(out[1].most, 9);
  EXPECT_EQ(out[3].value.front(), 1);
  EXPECT_EQ(out[3].choices[1], "long");
  EXPECT_EQ(out[5].name, "high");
  EXPECT_EQ(out[6].most, 2);

  nlohmann::ordered_json json = {{"media", {1, 2, {{"file", "x"}}}}};
  putSlider(json, puffFields(), "/media/2", out[5], {0.5});
  putSlider(json, puffFields(), "/media/2", out[3], {0});
  EXPECT_EQ(json["media"][2].dump(), R"({"file":"x","between":[0.0,0.5],"shape":"round"})");
}

}  // namespace
}  // namespace volute
