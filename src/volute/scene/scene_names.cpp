// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_names.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/media/medium_kind.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::string absolute(const std::string& path) {
  std::error_code ignored;
  const auto found = std::filesystem::absolute(path, ignored);
  return ignored ? path : found.lexically_normal().string();
}

void changeNames(OrderedJson& names, const std::function<void(std::string& name)>& change) {
  if (names.is_string())
    change(names.get_ref<std::string&>());
  else if (names.is_array())
    for (OrderedJson& name : names) changeNames(name, change);
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

void eachName(OrderedJson& json, const std::string& from,
              const std::function<void(std::string& name)>& change) {
  const auto move = [&](OrderedJson& entry, const std::string& key) {
    const OrderedJson::json_pointer pointer("/" + key);
    if (entry.contains(pointer))
      changeNames(entry[pointer], change);
  };
  for (const char* list : {"media", "billboards"}) {
    if (!json.contains(list))
      continue;
    for (OrderedJson& entry : json[list]) {
      const nlohmann::json plain = entry;
      const auto kind = mediumKindOf(plain, list, from, list);
      for (const std::string& key : kind ? filesIn((*kind)->fields()) : std::vector<std::string>())
        move(entry, key);
    }
  }
  const auto each = [&](const char* list, const char* key) {
    if (!json.contains(list))
      return;
    for (OrderedJson& entry : json[list]) move(entry, key);
  };
  each("geometry", "file");
  each("signs", "picture");
}

void moveAllNames(OrderedJson& json, const std::string& from, const std::string& to) {
  eachName(json, from, [&](std::string& name) { name = nameFrom(from, to, name); });
}

}  // namespace volute
