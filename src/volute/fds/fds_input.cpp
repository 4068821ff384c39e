// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_input.hpp"

#include <algorithm>

#include "volute/base/file_as_written.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/fds/text_lines.hpp"

namespace volute {

namespace {

constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 28;
constexpr const char* kMassExtinction = "MASS_EXTINCTION_COEFFICIENT";

Status takeNumber(const Namelist& group, const char* key, const std::filesystem::path& path,
                  std::optional<double>& into) {
  if (group.text(key).empty())
    return {};
  into = group.number(key);
  if (into && *into > 0)
    return {};
  return fail(ErrorCode::kInvalidData, "{}: line {}: {} is '{}'; expected a number above 0",
              path.string(), group.line, key, group.text(key).substr(0, 40));
}

Status takeExtinction(const Namelist& group, const std::filesystem::path& path, FdsInput& input) {
  const auto before = input.massExtinction;
  VOLUTE_TRY(takeNumber(group, kMassExtinction, path, input.massExtinction));
  if (before && before != input.massExtinction)
    input.otherExtinction = before;
  return {};
}

/// ".TRUE.", "T".
bool isTrue(const std::string& value) {
  return capitals(value).starts_with("T") || capitals(value).starts_with(".T");
}

FdsInput::Device deviceOf(const Namelist& group) {
  FdsInput::Device device{group.text("QUANTITY"), group.text("SPEC_ID"), {}, false};
  for (const char* key : {"SPATIAL_STATISTIC", "STATISTICS", "TEMPORAL_STATISTIC"}) {
    const std::string statistic = capitals(group.text(key));
    if (!statistic.empty() && statistic != "TIME AVERAGE" && statistic != "INSTANT VALUE")
      device.statistic = statistic;
  }
  for (const char* key : {"RELATIVE", "DRY"}) {  // to the first value; without the water in the air
    if (isTrue(group.text(key)))
      device.statistic = key;
  }
  device.scaled = (group.number("CONVERSION_FACTOR").value_or(1) != 1 ||
                   group.number("CONVERSION_ADDEND").value_or(0) != 0) &&
                  group.text("UNITS").empty();
  return device;
}

/// What the text of a file says. `others`: names of more files, if these are to be read.
Status take(const std::string& text, const std::filesystem::path& path, FdsInput& input,
            std::map<std::string, std::string>& formulas, std::vector<std::string>* others) {
  for (const Namelist& group :
       namelists(text, {"HEAD", "CATF", "TIME", "MISC", "REAC", "SPEC", "SURF", "DEVC", "MESH"})) {
    const std::string id = group.text("ID");
    if (group.group == "HEAD") {
      if (input.chid.empty())
        input.chid = group.text("CHID");
    } else if (group.group == "CATF") {
      const auto names = group.values.find("OTHER_FILES");
      if (others != nullptr && names != group.values.end())
        others->insert(others->end(), names->second.begin(), names->second.end());
    } else if (group.group == "TIME") {
      input.begin = group.values.contains("T_BEGIN") ? group.number("T_BEGIN") : input.begin;
    } else if (group.group == "MISC") {
      VOLUTE_TRY(takeNumber(group, "VISIBILITY_FACTOR", path, input.visibilityFactor));
      VOLUTE_TRY(takeNumber(group, "MAXIMUM_VISIBILITY", path, input.maximumVisibility));
      input.ambient = group.values.contains("TMPA") ? group.number("TMPA") : input.ambient;
    } else if (group.group == "REAC") {
      const std::string fuel = group.text("FUEL").empty() ? id : group.text("FUEL");
      input.reactions.push_back(
          {fuel, group.number("SOOT_YIELD").value_or(0), group.number("CO_YIELD").value_or(0)});
      VOLUTE_TRY(takeExtinction(group, path, input));
    } else if (group.group == "SPEC") {
      if (!group.text("FORMULA").empty())
        formulas[id] = group.text("FORMULA");
      if (capitals(id) == "SOOT")
        VOLUTE_TRY(takeExtinction(group, path, input));
    } else if (group.group == "SURF") {
      const bool burns =
          group.number("HRRPUA").value_or(0) > 0 || group.number("MLRPUA").value_or(0) > 0;
      // What has to be ignited may never be: its flames tell.
      if (burns && !group.values.contains("IGNITION_TEMPERATURE"))
        input.burning.insert(id);
    } else if (group.group == "MESH") {
      if (const auto offset = group.number("EVAC_Z_OFFSET"))
        input.evacuationOffsets[id] = *offset;
    } else if (!id.empty()) {
      input.devices.emplace(id, deviceOf(group));
    }
  }
  return {};
}

}  // namespace

Result<FdsInput> FdsInput::read(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto bytes, readText(path, kLargestFile));
  FdsInput input;
  input.path = path;
  std::map<std::string, std::string> formulas;
  std::vector<std::string> more;
  VOLUTE_TRY(take(asUtf8(bytes), path, input, formulas, &more));
  for (const std::string& name : more) {  // FDS reads what these name as if it stood here
    const std::filesystem::path file = FilesAsWritten().find(path.parent_path(), name);
    const auto other = readText(file, kLargestFile);
    if (!other) {
      return fail(ErrorCode::kInvalidData,
                  "{}: names another input file (CATF), which cannot be read: {}", path.string(),
                  other.error().message);
    }
    VOLUTE_TRY(take(asUtf8(*other), file, input, formulas, nullptr));
  }
  for (auto& [id, device] : input.devices) {
    const auto formula = formulas.find(device.species);
    if (formula != formulas.end())
      device.species = formula->second;
  }
  return input;
}

}  // namespace volute
