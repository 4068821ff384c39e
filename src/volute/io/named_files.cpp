// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/named_files.hpp"

#include <filesystem>

#include "volute/base/file_name.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/json_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

/// Texts of a scene or a capture that lead out of its folder. Most texts are names of something
/// else, and all of these lie below the folder if taken as files.
void findOutside(const nlohmann::json& json, const fs::path& folder,
                 std::vector<std::string>& found) {
  if (json.is_structured()) {
    for (const auto& member : json) findOutside(member, folder, found);
  } else if (json.is_string()) {
    const auto& text = json.get_ref<const std::string&>();
    if (!text.empty() && text.find('\0') == text.npos && !isBelowFolder(folder / text, folder) &&
        !fs::path(text).lexically_normal().filename().empty())
      found.push_back(text);
  }
}

void addTexts(const nlohmann::json& json, const fs::path& folder, std::vector<std::string>& names) {
  if (json.is_string()) {
    if (const auto& text = json.get_ref<const std::string&>(); !text.empty())
      names.push_back((folder / text).string());
    return;
  }
  for (const auto& member : json) {
    if (member.is_string() || member.is_structured())
      addTexts(member, folder, names);
  }
}

}  // namespace

std::vector<std::string> filesNamedIn(const std::string& file) {
  std::vector<std::string> names;
  if (fs::path(file).extension() != ".json")
    return names;
  if (const auto json = readJson(file))
    addTexts(*json, fs::path(file).parent_path(), names);
  return names;
}

std::vector<std::string> namesOutside(const std::string& file) {
  std::vector<std::string> found;
  if (fs::path(file).extension() != ".json")
    return found;
  if (const auto json = readJson(file))
    findOutside(*json, folderOf(file), found);
  return found;
}

}  // namespace volute
