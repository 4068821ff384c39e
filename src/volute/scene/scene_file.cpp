// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_file.hpp"

#include <filesystem>

#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

Result<std::string> kindOf(const Json& json, const std::string& file, const std::string& path) {
  if (!json.is_object() || !json.contains("kind") || !json["kind"].is_string()) {
    return fail(ErrorCode::kInvalidData, "{}: {}/kind: expected volume, fog or smoke", file, path);
  }
  const auto kind = json["kind"].get<std::string>();
  if (kind != "volume" && kind != "fog" && kind != "smoke") {
    return fail(ErrorCode::kInvalidData,
                "{}: {}/kind: '{}' is unknown; expected volume, fog or smoke", file, path, kind);
  }
  return kind;
}

Result<SceneVolume> volumeOf(const Json& json, const std::string& file, const std::string& path) {
  if (!json.contains("file") || !json["file"].is_string()) {
    return fail(ErrorCode::kInvalidData, "{}: {}/file: expected the name of a volume", file, path);
  }
  constexpr std::string_view kNames[] = {"kind",       "file",      "emission",
                                         "extinction", "transform", "time"};
  VOLUTE_TRY(Members(json, file, path).check(kNames));
  SceneVolume volume;
  volume.file =
      (std::filesystem::path(file).parent_path() / json["file"].get<std::string>()).string();
  Appearance& appearance = volume.appearance;
  if (json.contains("emission")) {
    VOLUTE_ASSIGN(appearance.emission, jsonToNumber(json["emission"], file, path + "/emission"));
  }
  if (json.contains("extinction")) {
    VOLUTE_ASSIGN(appearance.extinction,
                  jsonToNumber(json["extinction"], file, path + "/extinction"));
  }
  if (json.contains("transform")) {
    VOLUTE_ASSIGN(appearance.placement,
                  parsePlacement(json["transform"], file, path + "/transform"));
  }
  if (json.contains("time")) {
    VOLUTE_ASSIGN(appearance.clock, parseClock(json["time"], file, path + "/time"));
  }
  return volume;
}

/// One picture has one mode.
Status checkOneLaw(const std::vector<SmokeDescription>& others, const SmokeDescription& smoke) {
  if (others.empty() || others.front().law == smoke.law)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{}/mode: {} with C = {:g}, but {} is {} with C = {:g}; one picture has one mode",
              smoke.where, nameOf(smoke.law.mode), smoke.law.c, others.front().where,
              nameOf(others.front().law.mode), others.front().law.c);
}

}  // namespace

Result<SceneDescription> readScene(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  return parseScene(json, file);
}

Result<SceneDescription> parseScene(const Json& json, const std::string& file) {
  if (!json.is_object() || !json.contains("format") || json["format"] != "volute-scene-1") {
    return fail(ErrorCode::kInvalidData, "{}: /format: expected \"volute-scene-1\"", file);
  }
  constexpr std::string_view kNames[] = {"format", "camera", "background", "lights", "geometry",
                                         "media",  "signs",  "billboards", "view"};
  VOLUTE_TRY(Members(json, file, "").check(kNames));
  if (!json.contains("camera"))
    return fail(ErrorCode::kInvalidData, "{}: /camera is missing", file);
  SceneDescription scene;
  VOLUTE_ASSIGN(scene.camera, parseCamera(json["camera"], file, "/camera"));
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
  if (json.contains("billboards")) {
    VOLUTE_ASSIGN(scene.billboards, parseBillboards(json["billboards"], file, "/billboards"));
  }
  if (json.contains("view")) {
    VOLUTE_ASSIGN(scene.look, parseLook(json["view"], file, "/view"));
  }
  if (json.contains("signs")) {
    VOLUTE_ASSIGN(scene.signs, parseSigns(json["signs"], file, "/signs"));
  }
  const Json media = json.value("media", Json::array());
  if (!media.is_array())
    return fail(ErrorCode::kInvalidData, "{}: /media: expected a list", file);
  for (std::size_t i = 0; i < media.size(); ++i) {
    const std::string path = fmt::format("/media/{}", i);
    VOLUTE_ASSIGN(const auto kind, kindOf(media[i], file, path));
    if (kind == "fog") {
      VOLUTE_ASSIGN(auto fog, parseFog(media[i], file, path));
      scene.fogs.push_back(std::move(fog));
    } else if (kind == "smoke") {
      VOLUTE_ASSIGN(auto smoke, parseSmoke(media[i], file, path));
      VOLUTE_TRY(checkOneLaw(scene.smokes, smoke));
      scene.smokes.push_back(std::move(smoke));
    } else {
      VOLUTE_ASSIGN(auto volume, volumeOf(media[i], file, path));
      scene.volumes.push_back(std::move(volume));
    }
  }
  return scene;
}

}  // namespace volute
