// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/moved_file.hpp"

#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_names.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

std::filesystem::path placeOf(const std::string& scene, const std::string& name) {
  return std::filesystem::absolute(std::filesystem::path(scene).parent_path() / name)
      .lexically_normal();
}

/// Patterns stand for many files.
bool isMissing(const std::filesystem::path& place) {
  const std::string name = place.filename().string();
  std::error_code unknown;
  return name.find_first_of("%#$<") == std::string::npos &&
         !std::filesystem::exists(place, unknown);
}

/// Null: it cannot be read.
Json jsonOf(const std::string& scene) {
  const auto text = readText(scene);
  return text ? Json::parse(*text, nullptr, false) : Json();
}

}  // namespace

std::optional<MovedFile> movedFileOf(const std::string& scene) {
  Json json = isScenePath(scene) ? jsonOf(scene) : Json();
  if (!json.is_object())
    return std::nullopt;
  std::optional<MovedFile> moved;
  eachName(json, scene, [&](std::string& name) {
    const auto place = placeOf(scene, name);
    if (!moved && isMissing(place))
      moved = MovedFile{scene, place};
  });
  return moved;
}

Result<std::string> withFileAt(const MovedFile& moved, const std::filesystem::path& found) {
  Json json = jsonOf(moved.scene);
  if (!json.is_object())
    return fail(ErrorCode::kInvalidData, "{}: it is no scene any more", moved.scene);
  const auto now = std::filesystem::absolute(found).lexically_normal();
  eachName(json, moved.scene, [&](std::string& name) {
    const auto place = placeOf(moved.scene, name);
    const auto beside = now.parent_path() / place.filename();
    std::error_code unknown;
    if (place == moved.place)
      name = now.string();
    else if (isMissing(place) && std::filesystem::exists(beside, unknown))
      name = beside.string();
    else
      name = place.string();
  });
  return json.dump(2) + "\n";
}

}  // namespace volute
