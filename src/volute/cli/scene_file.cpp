// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/scene_file.hpp"

#include <filesystem>

#include "volute/cli/json_file.hpp"

namespace volute::cli {
namespace {

using Json = nlohmann::json;

/// 16 numbers, row-major, of a transform that moves and scales along the axes.
Result<Placement> placementOf(const Json& json, const std::string& file, const std::string& path) {
  if (!json.is_array() || json.size() != 16) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected 16 numbers, row-major", file, path);
  }
  Mat4 matrix;
  for (int i = 0; i < 16; ++i) {
    VOLUTE_ASSIGN(matrix(i / 4, i % 4),
                  jsonToNumber(json[i], file, fmt::format("{}[{}]", path, i)));
  }
  Placement placement;
  placement.scale = matrix.diagonal().head<3>();
  placement.offset = matrix.topRightCorner<3, 1>();
  Mat4 rest = matrix;
  rest.diagonal().setZero();
  rest.topRightCorner<3, 1>().setZero();
  if (!rest.isZero(0) || matrix(3, 3) != 1 || !(placement.scale.array() > 0).all()) {
    return fail(ErrorCode::kUnsupported,
                "{}: {}: only moving and scaling along the axes is rendered, no rotation", file,
                path);
  }
  return placement;
}

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
    VOLUTE_ASSIGN(appearance.placement, placementOf(json["transform"], file, path + "/transform"));
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

Status refuseOtherParts(const Json& json, const std::string& file) {
  for (const char* part : {"geometry", "billboards"}) {
    if (json.contains(part) && !json[part].empty()) {
      return fail(ErrorCode::kUnsupported,
                  "{}: /{}: this part of a scene is not rendered by this version", file, part);
    }
  }
  return {};
}

}  // namespace

Result<SceneDescription> readScene(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  if (!json.is_object() || !json.contains("format") || json["format"] != "volute-scene-1") {
    return fail(ErrorCode::kInvalidData, "{}: /format: expected \"volute-scene-1\"", file);
  }
  VOLUTE_TRY(refuseOtherParts(json, file));
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

}  // namespace volute::cli
