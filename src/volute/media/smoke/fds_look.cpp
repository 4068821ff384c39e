// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/fds_look.hpp"

#include "volute/io/json_members.hpp"

namespace volute {
namespace {

Status parseFire(const Members& members, const std::string& file, FdsLook& look) {
  if (!members.has("fire"))
    return {};
  const nlohmann::json& fire = members.at("fire");
  if (fire.is_boolean()) {
    look.fire = fire.get<bool>();
    return {};
  }
  constexpr std::string_view kNames[] = {"temperature", "emission", "cutoff"};
  const Members parts(fire, file, members.where("fire"));
  VOLUTE_TRY(parts.check(kNames));
  VOLUTE_TRY(parts.number("temperature", look.flame.temperature, 500, 20000));
  VOLUTE_TRY(parts.number("emission", look.flame.emission, 0));
  if (parts.has("cutoff")) {
    look.cutoff = 0;
    VOLUTE_TRY(parts.number("cutoff", *look.cutoff, 0));
  }
  return {};
}

Status parseSlice(const Members& members, const std::string& file, FdsLook& look) {
  if (members.has("slice"))
    VOLUTE_TRY(members.text("slice", look.slice, "a quantity, as FDS names it"));
  if (!members.has("slice_range"))
    return {};
  const nlohmann::json& range = members.at("slice_range");
  if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number() ||
      !(range[0].get<double>() < range[1].get<double>())) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected two numbers, the smaller one first",
                file, members.where("slice_range"));
  }
  look.sliceRange = {range[0].get<double>(), range[1].get<double>()};
  return {};
}

}  // namespace

Result<FdsLook> parseFdsLook(const nlohmann::json& smoke, const std::string& file,
                             const std::string& path) {
  const Members members(smoke, file, path);
  FdsLook look;
  VOLUTE_TRY(parseFire(members, file, look));
  VOLUTE_TRY(parseSlice(members, file, look));
  if (members.has("devices")) {
    if (!members.at("devices").is_boolean())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected true or false", file,
                  members.where("devices"));
    look.devices = members.at("devices").get<bool>();
  }
  return look;
}

}  // namespace volute
