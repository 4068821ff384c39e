// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/field_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/cli/file_kind.hpp"
#include "volute/cli/parse.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/fds/fds_look.hpp"
#include "volute/media/fog/fog_file.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/smoke/scene_smoke.hpp"
#include "volute/media/volume/volume_fields.hpp"

namespace volute::cli {
namespace {

using testing::HasSubstr;

std::vector<const FieldTable*> tablesWithOptions() {
  return {&volumeFields(), &fogFields(), &smokeFields(),
          &fdsFields(),    &sunFields(), &cameraFields()};
}

/// Members of members have options too.
std::vector<std::pair<const FieldRow*, const FieldTable*>> rowsOf(const FieldTable& table) {
  std::vector<std::pair<const FieldRow*, const FieldTable*>> rows;
  for (const FieldRow& field : table.fields) {
    rows.emplace_back(&field, &table);
    if (field.table && !field.option.parse)
      for (const auto& inner : rowsOf(*field.table)) rows.push_back(inner);
  }
  return rows;
}

TEST(FieldOptions, HaveTheRangeAndTheDefaultOfTheirRows) {
  int checked = 0;
  for (const FieldTable* table : tablesWithOptions()) {
    const auto options = fieldOptions({table});
    for (const auto& [field, of] : rowsOf(*table)) {
      if (!field->hasOption())
        continue;
      const std::string name = field->optionName(of == table ? "" : of->name);
      SCOPED_TRACE(name);
      const auto option = std::ranges::find(options, name, &Option::name);
      ASSERT_NE(option, options.end());
      EXPECT_THAT(option->help, HasSubstr(std::string(field->help)));
      if (!field->unit.empty()) {
        EXPECT_THAT(option->help, HasSubstr("[" + std::string(field->unit) + "]"));
      }
      ++checked;
      if (option->kind != ValueKind::kNumber && option->kind != ValueKind::kInteger)
        continue;
      for (const double limit : {field->least, field->most}) {
        for (const double number : {limit - 1, limit, limit + 1}) {
          if (std::isfinite(limit)) {
            EXPECT_EQ(parseValue(*option, fmt::format("{:.17g}", number)).has_value(),
                      field->holds(number))
                << number;
          }
        }
      }
      const FieldValue usual = usualValue(*of, *field);
      if (usual.is_number()) {
        EXPECT_DOUBLE_EQ(*parseNumber(option->initial), usual.get<double>());
      }
    }
  }
  EXPECT_GT(checked, 40);
}

TEST(FieldOptions, OfSeveralKindsAreOneOption) {
  const auto options = fieldOptions({&volumeFields(), &smokeFields(), &fdsFields()});
  EXPECT_EQ(std::ranges::count(options, "field", &Option::name), 1);
  const auto field = std::ranges::find(options, "field", &Option::name);
  EXPECT_THAT(field->kinds, testing::ElementsAre("volume", "smoke", "fds"));
  EXPECT_THAT(field->aliases, testing::ElementsAre("grid", "source"));
  const auto fire = std::ranges::find(options, "fire", &Option::name);
  EXPECT_THAT(fire->kinds, testing::ElementsAre("fds"));
  EXPECT_TRUE(fire->help.starts_with("FDS cases: ")) << fire->help;
  EXPECT_TRUE(field->help.starts_with("grid or field of a file")) << field->help;
  const auto measured = fieldOptions({&smokeFields(), &fdsFields()}, FieldUse::kMeasured);
  for (const char* picture :
       {"mode", "albedo", "fire", "fire-cutoff", "devices", "fds-slice", "fds-slice-range"})
    EXPECT_EQ(std::ranges::find(measured, picture, &Option::name), measured.end()) << picture;
  EXPECT_THAT(std::ranges::find(measured, "scale", &Option::name)->kinds,
              testing::ElementsAre("smoke"));
}

Command commandOf(std::vector<Option> options) {
  Command command;
  command.name = "look";
  command.positionals = {{.name = "FILE"}};
  command.options = std::move(options);
  return command;
}

TEST(FieldOptions, SayWhatAFileSays) {
  const Command command =
      commandOf(fieldOptions({&volumeFields(), &fdsFields(), &smokeFields(), &fogFields()}));
  const auto members = [&](const FieldTable& table, std::vector<std::string> words) {
    words.insert(words.begin(), "x");
    const auto arguments = parseArguments(command, words);
    EXPECT_TRUE(arguments) << arguments.error().message;
    const auto said = membersOf(table, *arguments);
    return said ? said->dump() : said.error().message;
  };
  EXPECT_EQ(
      members(fdsFields(), {"--fire", "5", "--fire-cutoff", "90", "--devices", "--fds-slice", "T",
                            "--fds-slice-range", "20,50"}),
      R"({"devices":true,"fire":{"cutoff":90.0,"emission":5.0},"slice":"T","slice_range":[20.0,50.0]})");
  EXPECT_EQ(members(smokeFields(), {"--clamp", "--C", "8", "--grid", "smoke"}),
            R"({"C":8.0,"field":"smoke","negatives":"clamp"})");
  EXPECT_EQ(members(smokeFields(), {"--C", "jin-emitting"}), R"({"C":"jin-emitting"})");
  EXPECT_EQ(members(fogFields(), {"--profile", "layers:0,1,2"}),
            R"({"color":[0.8,0.85,0.9],"profile":{"kind":"layers","layers":[[0.0,1.0,2.0]]}})");
  EXPECT_THAT(members(fogFields(), {"--profile", "slab:0"}),
              HasSubstr("--profile: 'slab:0' is not a profile"));
  EXPECT_THAT(members(fdsFields(), {"--fds-slice", "T", "--fds-slice-range", "2,x"}),
              HasSubstr("--fds-slice-range: 'x'"));
}

TEST(FieldOptions, ThatWouldChangeNothingAreRefused) {
  const Command command = commandOf(fieldOptions({&volumeFields(), &smokeFields(), &fdsFields()}));
  const auto refusal = [&](std::string file, std::vector<std::string> words) {
    words.insert(words.begin(), file);
    const auto arguments = parseArguments(command, words);
    if (!arguments)
      return arguments.error().message;
    const auto good = refuseIdle(*arguments, {shownKind(file)});
    return good ? "nothing" : good.error().message;
  };
  EXPECT_EQ(refusal("a.vtu", {"--fire", "3"}), "--fire is for FDS cases; a.vtu is smoke on a mesh");
  EXPECT_EQ(refusal("a.npy", {"--mode", "threshold"}),
            "--mode is for smoke on meshes, FDS cases and scenes; a.npy is a volume of voxels");
  EXPECT_EQ(
      refusal("a.smv", {"--unit", "g/m3"}),
      "--unit is for smoke on meshes; a.smv is an FDS case, which declares what its files contain");
  EXPECT_EQ(refusal("a.cgns", {"--quantity", "extinction"}), "nothing");  // opening it says why not
  EXPECT_THAT(refusal("a.json", {"--emission", "2"}),
              HasSubstr("a.json is a scene: write it there"));
  EXPECT_EQ(refusal("a.smv", {"--fds-slice-range", "1,2"}),
            "--fds-slice-range has no effect without --fds-slice; add --fds-slice or omit it");
  for (const auto& [file, word] : {std::pair("a.vtu", "--clamp"), {"a.smv", "--devices"}})
    EXPECT_EQ(refusal(file, {word}), "nothing");
  EXPECT_EQ(refusal("a.json", {"--mode", "threshold", "--basis", "box"}), "nothing");
}

}  // namespace
}  // namespace volute::cli
