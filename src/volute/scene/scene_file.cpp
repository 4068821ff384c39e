// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_file.hpp"

#include "volute/io/json_members.hpp"

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
    VOLUTE_ASSIGN(const MediumKind* kind, mediumKindOf(entries[i], list, file, path));
    media.push_back({kind, path, entries[i]});
  }
  return {};
}

}  // namespace

Result<SceneDescription> parseScene(const Json& json, const std::string& file) {
  if (!json.is_object() || !json.contains("format") || json["format"] != "volute-scene-1") {
    return fail(ErrorCode::kInvalidData, "{}: /format: expected \"volute-scene-1\"", file);
  }
  constexpr std::string_view kNames[] = {"format", "camera", "background", "lights", "geometry",
                                         "media",  "signs",  "billboards", "view"};
  VOLUTE_TRY(Members(json, file, "").check(kNames));
  SceneDescription scene;
  if (json.contains("camera")) {
    VOLUTE_ASSIGN(scene.camera, parseCamera(json["camera"], file, "/camera"));
  }
  if (json.contains("background")) {
    VOLUTE_ASSIGN(const Vec3 background, jsonToVector(json["background"], file, "/background"));
    scene.background = background.array();
  }
  if (json.contains("lights")) {
    VOLUTE_ASSIGN(scene.lights, parseLights(json["lights"], file, "/lights"));
  }
  if (json.contains("geometry")) {
    VOLUTE_ASSIGN(scene.geometry, parseGeometry(json["geometry"], file, "/geometry"));
  }
  if (json.contains("view")) {
    VOLUTE_ASSIGN(scene.look, parseLook(json["view"], file, "/view"));
  }
  if (json.contains("signs")) {
    VOLUTE_ASSIGN(scene.signs, parseSigns(json["signs"], file, "/signs"));
  }
  VOLUTE_TRY(parseMedia(json, "media", file, scene.media));
  VOLUTE_TRY(parseMedia(json, "billboards", file, scene.media));
  return scene;
}

}  // namespace volute
