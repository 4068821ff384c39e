// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_names.hpp"

#include <filesystem>

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string absolute(const std::string& path) {
  std::error_code ignored;
  const auto found = std::filesystem::absolute(path, ignored);
  return ignored ? path : found.lexically_normal().string();
}

/// The member of a medium that names its file.
const char* fileKey(const OrderedJson& medium) {
  const std::string kind = medium.value("kind", "");
  return kind == "volume" ? "file" : kind == "fog" ? "map" : "case";
}

void moveNames(OrderedJson& names, const std::string& from, const std::string& to) {
  if (names.is_string()) {
    names = nameFrom(from, to, names.get<std::string>());
  } else if (names.is_array()) {
    for (OrderedJson& name : names) moveNames(name, from, to);
  }
}

}  // namespace

std::string nameFrom(const std::string& scene, const std::string& target, const std::string& name) {
  const std::filesystem::path file =
      absolute((std::filesystem::path(scene).parent_path() / name).string());
  const auto folder = std::filesystem::path(absolute(target)).parent_path();
  const auto near = file.lexically_relative(folder);
  const bool below = !near.empty() && *near.begin() != "..";
  return below ? near.string() : file.string();
}

void moveAllNames(OrderedJson& json, const std::string& from, const std::string& to) {
  const auto each = [&](const char* list, auto key) {
    if (!json.contains(list))
      return;
    for (OrderedJson& entry : json[list]) {
      const char* name = key(entry);
      if (entry.contains(name))
        moveNames(entry[name], from, to);
      if (entry.contains("top"))
        moveNames(entry["top"]["map"], from, to);
    }
  };
  each("media", fileKey);
  each("geometry", [](const OrderedJson&) { return "file"; });
  each("signs", [](const OrderedJson&) { return "picture"; });
  each("billboards", [](const OrderedJson&) { return "volume"; });
}

}  // namespace volute
