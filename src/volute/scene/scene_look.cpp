// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_look.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "volute/io/json_members.hpp"

namespace volute {
namespace {

constexpr std::array<std::string_view, 3> kColors{"grey", "viridis", "inferno"};
constexpr std::array<std::string_view, 4> kQualities{"automatic", "full", "half", "quarter"};
constexpr std::array<std::string_view, 3> kRenderers{"automatic", "gl", "cpu"};
constexpr std::array<std::string_view, 2> kCameras{"orbit", "walk"};

/// Which of these names a member is.
Status choice(const Members& members, const char* key, std::span<const std::string_view> names,
              int& value) {
  if (!members.has(key))
    return {};
  std::string name;
  const std::string expected = fmt::format("{}", fmt::join(names, ", "));
  VOLUTE_TRY(members.text(key, name, expected.c_str()));
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    return members.objection(key, {ErrorCode::kInvalidData,
                                   fmt::format("'{}' is unknown; expected {}", name, expected)});
  }
  value = static_cast<int>(found - names.begin());
  return {};
}

}  // namespace

Result<SceneLook> parseLook(const nlohmann::json& json, const std::string& file,
                            const std::string& path) {
  constexpr std::string_view kNames[] = {"stops",  "exposure", "colors", "quality", "renderer",
                                         "camera", "speed",    "time",   "surfaces"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneLook look;
  VOLUTE_TRY(members.number("stops", look.stops, -20, 20));
  if (members.has("exposure")) {
    look.exposure = 1;
    VOLUTE_TRY(members.number("exposure", *look.exposure, 1e-30, 1e30));
  }
  VOLUTE_TRY(choice(members, "colors", kColors, look.colors));
  VOLUTE_TRY(choice(members, "quality", kQualities, look.quality));
  VOLUTE_TRY(choice(members, "renderer", kRenderers, look.renderer));
  int walks = 0;
  VOLUTE_TRY(choice(members, "camera", kCameras, walks));
  look.walks = walks == 1;
  if (members.has("surfaces")) {
    if (!members.at("surfaces").is_boolean())
      return tl::unexpected<Error>(
          members.objection("surfaces", {ErrorCode::kInvalidData, "expected true or false"})
              .error());
    look.surfaces = members.at("surfaces").get<bool>();
  }
  VOLUTE_TRY(members.number("speed", look.speed, 0.01, 100));
  if (members.has("time")) {
    look.time = 0;
    VOLUTE_TRY(members.number("time", *look.time));
  }
  return look;
}

nlohmann::ordered_json toJson(const SceneLook& look) {
  nlohmann::ordered_json json = {{"stops", look.stops},
                                 {"colors", kColors[look.colors]},
                                 {"quality", kQualities[look.quality]},
                                 {"renderer", kRenderers[look.renderer]},
                                 {"surfaces", look.surfaces},
                                 {"camera", kCameras[look.walks ? 1 : 0]},
                                 {"speed", look.speed}};
  if (look.exposure)
    json["exposure"] = *look.exposure;
  if (look.time)
    json["time"] = *look.time;
  return json;
}

}  // namespace volute
