// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/named_files.hpp"

#include <algorithm>
#include <cctype>
#include <climits>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "volute/base/file_name.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/json_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestCollection = 64 << 20;  ///< [bytes]

std::string unescaped(std::string text) {
  constexpr std::pair<std::string_view, char> kNames[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
  for (const auto& [name, letter] : kNames) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; ++at)
      text.replace(at, name.size(), 1, letter);
  }
  return text;
}

bool holdsNames(const fs::path& file) {
  const std::string extension = extensionOf(file);
  return extension == ".json" || extension == ".pvd" || extension == ".smv";
}

/// Finds texts of a scene or a capture that lead out of its folder, and of the files of names that
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
    if (extensionOf(file) == ".json")
      (void)forEachJsonText(file, [&](const std::string& text) { addText(text, folder); });
    else if (extensionOf(file) == ".pvd")
      std::ranges::for_each(namesInCollection(file),
                            [&](const auto& text) { addText(text, folder); });
    else
      std::ranges::for_each(namesInCase(file), [&](const auto& text) { addText(text, folder); });
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
    else if (holdsNames(path) && fs::is_regular_file(path, error))
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

std::vector<std::string> namesInCollection(const std::filesystem::path& collection) {
  const auto read = readText(collection, kLargestCollection);
  if (!read)
    return {};
  const std::string& text = *read;
  std::vector<std::string> names;
  constexpr std::string_view kKey = " file=";
  for (std::size_t at = 0; (at = text.find(kKey, at)) != std::string::npos;) {
    at += kKey.size();
    const char quote = at < text.size() ? text[at] : '\0';
    const std::size_t end = quote == '"' || quote == '\'' ? text.find(quote, at + 1) : at;
    if (end == std::string::npos)
      break;
    if (end > at + 1)
      names.push_back(unescaped(text.substr(at + 1, end - at - 1)));
  }
  return names;
}

std::vector<std::string> namesInCase(const std::filesystem::path& index) {
  std::vector<std::string> names;
  std::istringstream lines(readText(index, kLargestCollection).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(" \t"), end = line.find_last_not_of(" \t\r");
    if (begin == std::string::npos)
      continue;
    line = line.substr(begin, end + 1 - begin);
    const std::size_t dot = line.find_last_of('.');
    if (dot + 1 >= line.size() || !std::isalpha(static_cast<unsigned char>(line[dot + 1])) ||
        line.find_first_of(" \t") != std::string::npos)
      continue;
    std::ranges::replace(line, '\\', '/');
    names.push_back(line);
  }
  return names;
}

std::vector<std::string> namesOutside(const std::string& file) {
  if (!holdsNames(file))
    return {};
  OutsideFinder finder;
  finder.addFile(file);
  return std::move(finder).found();
}

}  // namespace volute
