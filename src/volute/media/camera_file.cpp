// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/camera_file.hpp"

#include <string_view>

#include "volute/io/json_members.hpp"
#include "volute/io/json_values.hpp"

namespace volute {
namespace {

Result<Pixels> sizeOf(const nlohmann::json& json, const std::string& file,
                      const std::string& path) {
  constexpr int kMost = 32768;
  if (json.is_array() && json.size() == 2 && json[0].is_number_integer() &&
      json[1].is_number_integer()) {
    const auto width = json[0].get<std::int64_t>(), height = json[1].get<std::int64_t>();
    if (std::min(width, height) >= 1 && std::max(width, height) <= kMost) {
      return Pixels{static_cast<int>(width), static_cast<int>(height)};
    }
  }
  return fail(ErrorCode::kInvalidData, "{}: {}: expected [width, height] of 1 to {} pixels", file,
              path, kMost);
}

}  // namespace

Status checkView(const CameraDescription& camera, const std::string& where) {
  if (camera.view.eye == camera.view.target) {
    return fail(ErrorCode::kInvalidArgument, "{}: eye and target are the same point", where);
  }
  if (camera.fov && !(*camera.fov > 0 && *camera.fov < 180)) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: fov is {}; expected more than 0 and less than 180 degrees", where,
                *camera.fov);
  }
  if (camera.ortho && !(*camera.ortho > 0)) {
    return fail(ErrorCode::kInvalidArgument, "{}: ortho is {}; expected a height of more than 0 m",
                where, *camera.ortho);
  }
  return {};
}

Result<CameraDescription> parseCamera(const nlohmann::json& json, const std::string& file,
                                      const std::string& path) {
  if (!json.is_object())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a camera object", file, path);
  static constexpr std::string_view kNames[] = {"eye", "target", "up", "fov", "ortho", "size"};
  VOLUTE_TRY(Members(json, file, path).check(kNames));
  const auto within = [&](const char* key) { return path + "/" + key; };
  CameraDescription camera;
  for (const char* key : {"eye", "target"}) {
    if (!json.contains(key))
      return fail(ErrorCode::kInvalidData, "{}: {} is missing; expected three numbers [m]", file,
                  within(key));
  }
  VOLUTE_ASSIGN(camera.view.eye, jsonToVector(json["eye"], file, within("eye")));
  VOLUTE_ASSIGN(camera.view.target, jsonToVector(json["target"], file, within("target")));
  if (json.contains("up")) {
    VOLUTE_ASSIGN(camera.view.up, jsonToVector(json["up"], file, within("up")));
  }
  if (json.contains("fov")) {
    VOLUTE_ASSIGN(camera.fov, jsonToNumber(json["fov"], file, within("fov")));
  }
  if (json.contains("ortho")) {
    VOLUTE_ASSIGN(camera.ortho, jsonToNumber(json["ortho"], file, within("ortho")));
  }
  if (json.contains("size")) {
    VOLUTE_ASSIGN(camera.size, sizeOf(json["size"], file, within("size")));
  }
  if (camera.fov.has_value() == camera.ortho.has_value()) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected one of fov [degrees] and ortho [m]",
                file, path);
  }
  VOLUTE_TRY(checkView(camera, fmt::format("{}: {}", file, path)));
  return camera;
}

Result<CameraDescription> readCamera(const std::string& file) {
  VOLUTE_ASSIGN(const auto json, readJson(file));
  const bool scene = json.is_object() && json.contains("camera");
  return scene ? parseCamera(json["camera"], file, "/camera") : parseCamera(json, file, "");
}

Camera makeCamera(const CameraDescription& description, const Pixels& size) {
  return description.fov
             ? Camera::pinhole(description.view, *description.fov, size.width, size.height)
             : Camera::orthographic(description.view, *description.ortho, size.width, size.height);
}

}  // namespace volute
