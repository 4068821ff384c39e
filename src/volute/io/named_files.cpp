// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/named_files.hpp"

#include <algorithm>
#include <cctype>
#include <climits>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "volute/base/file_name.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/json_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

/// Finds texts of a scene or a capture that lead out of its folder, and of the .json files that
/// these name. Most texts are names of something else, and all of these lie below the folder if
/// taken as files.
class OutsideFinder {
 public:
  void addFile(const fs::path& file) {
    std::error_code error;
    constexpr std::size_t kMaxFiles = 1000;
    if (seen_.size() == kMaxFiles || !seen_.insert(fs::weakly_canonical(file, error)).second)
      return;
    const fs::path folder = folderOf(file);
    // What is wrong with it is said when it is read.
    (void)forEachJsonText(file, [&](const std::string& text) { addText(text, folder); });
  }

  std::vector<std::string> found() && { return std::move(found_); }

 private:
  void addText(const std::string& text, const fs::path& folder) {
    if (text.empty() || text.find('\0') != text.npos || isTooLong(text))
      return;
    std::error_code error;
    const fs::path path = folder / text;
    // Most texts by far: to follow a path takes twenty calls of the system.
    if (isPlainName(text) && fs::symlink_status(path, error).type() == fs::file_type::not_found)
      return;
    if (!isBelowFolder(path, folder)) {
      // "/" is more likely a text than the root of all folders.
      const fs::path normal = fs::path(text).lexically_normal();
      if (!normal.filename().empty() || (normal.has_relative_path() && fs::exists(path, error)))
        found_.push_back(text);
      return;
    }
    if (leadsOut(path, folder))
      found_.push_back(text);
    else if (extensionOf(path) == ".json" && fs::is_regular_file(path, error))
      addFile(path);
  }

  /// Of one thing in the folder itself, and no pattern of frames.
  static bool isPlainName(const std::string& text) {
    return text != "." && text != ".." && std::ranges::all_of(text, [](unsigned char c) {
             return std::isalnum(c) || c == ' ' || c == '-' || c == '_' || c == '.';
           });
  }

  /// No file has such a name.
  static bool isTooLong(const std::string& text) {
    return text.size() >= PATH_MAX || std::ranges::any_of(fs::path(text), [](const auto& part) {
             return part.native().size() > NAME_MAX;
           });
  }

  /// Whether one of the frames of a pattern, or one of the files of a folder, is a link to
  /// elsewhere.
  bool leadsOut(const fs::path& path, const fs::path& folder) {
    std::error_code error;
    if (fs::is_directory(path, error))
      return !linksOutside(path, folder).empty();
    const auto pattern = FramePattern::parse(path);
    return pattern &&
           std::ranges::any_of(linksOutside(folderOf(path), folder), [&](const std::string& name) {
             return pattern->match(name).has_value();
           });
  }

  /// Links in `path` that lead out of `folder`. A capture names many patterns in one folder.
  const std::vector<std::string>& linksOutside(const fs::path& path, const fs::path& folder) {
    const auto [place, isNew] = links_.try_emplace({path, folder});
    std::error_code error;
    if (!isNew)
      return place->second;
    for (const auto& entry : fs::directory_iterator(path, error)) {
      if (entry.is_symlink(error) && !isBelowFolder(entry.path(), folder))
        place->second.push_back(entry.path().filename().string());
    }
    return place->second;
  }

  std::set<fs::path> seen_;
  std::map<std::pair<fs::path, fs::path>, std::vector<std::string>> links_;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> filesNamedIn(const std::string& file) {
  std::vector<std::string> names;
  if (extensionOf(file) != ".json")
    return names;
  const fs::path folder = fs::path(file).parent_path();
  (void)forEachJsonText(file, [&](const std::string& text) {
    if (!text.empty())
      names.push_back((folder / text).string());
  });
  return names;
}

std::vector<std::string> namesOutside(const std::string& file) {
  if (extensionOf(file) != ".json")
    return {};
  OutsideFinder finder;
  finder.addFile(file);
  return std::move(finder).found();
}

}  // namespace volute
