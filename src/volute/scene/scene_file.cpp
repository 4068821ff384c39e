// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_file.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/suggest.hpp"
#include "volute/io/json_values.hpp"
#include "volute/scene/own_kind.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

Status parseMedia(const Json& json, std::string_view list, const std::string& file,
                  std::vector<MediumEntry>& media) {
  if (!json.contains(list))
    return {};
  const Json& entries = json[list];
  if (!entries.is_array())
    return fail(ErrorCode::kInvalidData, "{}: /{}: expected a list", file, list);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string path = fmt::format("/{}/{}", list, i);
    auto kind = mediumKindOf(entries[i], list, file, path);
    if (!kind && !ownKindFaults().empty())
      kind.error().message += fmt::format("; {}", fmt::join(ownKindFaults(), "; "));
    VOLUTE_TRY(kind);
    media.push_back({*kind, path, entries[i]});
  }
  return {};
}

/// Says what an entry of an older scene leaves to defaults that have changed.
void addOlder(Json& entry, const FieldTable& table) {
  for (const FieldRow& field : table.fields) {
    if (!field.older.empty() && entry.is_object() && !entry.contains(field.name))
      entry[std::string(field.name)] = field.older;
  }
}

/// Those of the file itself.
Status checkMembers(const Json& json, const std::string& file) {
  constexpr std::string_view kNames[] = {"format",   "camera", "background", "lights",
                                         "geometry", "media",  "signs",      "billboards",
                                         "clip",     "view",   "scattering"};
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(kNames, key) != std::end(kNames))
      continue;
    const auto near = nearest(key, kNames);
    return fail(ErrorCode::kInvalidData, "{}: /{}: this name is unknown{}", file, key,
                near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
  }
  return {};
}

}  // namespace

Json upgradedScene(Json json) {
  if (!json.is_object() || sceneVersionOf(json.value("format", Json())) != 1)
    return json;
  const auto each = [&](std::string_view list, const auto& add) {
    const auto found = json.find(list);
    if (found == json.end() || !found->is_array())
      return;
    for (Json& entry : *found) add(entry);
  };
  each("geometry", [](Json& entry) { addOlder(entry, geometryFields()); });
  for (const MediumKind* kind : mediumKinds()) {
    each(kind->list(), [&](Json& entry) {
      if (entry.is_object() && entry.value("kind", Json()) == kind->name())
        addOlder(entry, kind->fields());
    });
  }
  return json;
}

Result<SceneDescription> parseScene(const Json& given, const std::string& file) {
  const auto version = given.is_object() && given.contains("format")
                           ? sceneVersionOf(given["format"])
                           : std::nullopt;
  if (!version) {
    return fail(ErrorCode::kInvalidData, "{}: /format: expected \"{}\", or \"volute-scene-1\"",
                file, kSceneFormat);
  }
  const Json json = upgradedScene(given);
  VOLUTE_TRY(checkMembers(json, file));
  SceneDescription scene;
  scene.version = *version;
  const auto read = [&](const char* name, auto& out, auto parse) -> Status {
    if (json.contains(name)) {
      VOLUTE_ASSIGN(out, parse(json[name], FieldOrigin{file, fmt::format("/{}", name)}));
    }
    return {};
  };
  VOLUTE_TRY(read("camera", scene.camera, parseCamera));
  if (json.contains("background")) {
    VOLUTE_ASSIGN(const Vec3 background, jsonToVector(json["background"], file, "/background"));
    constexpr double kBrightest = 1e30;  // beyond it, a fill value
    if (!(background.minCoeff() >= 0 && background.maxCoeff() <= kBrightest)) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: /background: {}, {}, {} is out of range; expected three numbers of 0 or more", file,
          background.x(), background.y(), background.z());
    }
    scene.background = background.array();
  }
  VOLUTE_TRY(read("lights", scene.lights, parseLights));
  if (json.contains("scattering")) {
    const Json& scattering = json["scattering"];
    if (scattering != "single" && scattering != "multiple") {
      return fail(ErrorCode::kInvalidData,
                  "{}: /scattering: {} is neither \"single\" nor \"multiple\"", file,
                  scattering.dump());
    }
    scene.lights.multiple = scattering == "multiple";
  }
  VOLUTE_TRY(read("geometry", scene.geometry, [](const auto& list, const auto& origin) {
    return readList<SceneGeometry>(geometryFields(), list, origin);
  }));
  VOLUTE_TRY(read("view", scene.look, [](const auto& look, const auto& origin) {
    return readAs<SceneLook>(lookFields(), look, origin);
  }));
  VOLUTE_TRY(read("clip", scene.clip, parseClip));
  VOLUTE_TRY(read("signs", scene.signs, parseSigns));
  VOLUTE_TRY(parseMedia(json, "media", file, scene.media));
  VOLUTE_TRY(parseMedia(json, "billboards", file, scene.media));
  return scene;
}

}  // namespace volute
