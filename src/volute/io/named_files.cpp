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

#include "volute/base/file_as_written.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/namelist.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/below_folder.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/json_file.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestCollection = 64 << 20;  ///< [bytes]
constexpr std::uintmax_t kLargestInput = 1 << 28;        ///< as FDS's input is read [bytes]

std::string withSlashes(std::string text) {
  std::ranges::replace(text, '\\', '/');
  return text;
}

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
      addCase(file, folder);
  }

  std::vector<std::string> found() && { return std::move(found_); }

 private:
  void addCase(const fs::path& index, const fs::path& folder) {
    bool isInput = false;  // what the line before announces
    for (const std::string& text : namesInCase(index)) {
      addText(text, folder);
      if (isInput) {  // one whose folder is not there lies beside the index
        addInput(written_.find(folder, text), folder);
        addInput(written_.find(folder, fs::path(text).filename().string()), folder);
      }
      isInput = text.starts_with("INPF");
    }
  }

  /// FDS's input, whatever it is called.
  void addInput(const fs::path& file, const fs::path& folder) {
    std::error_code error;
    if (!isBelowFolder(file, folder)) {
      if (fs::exists(file, error))
        found_.push_back(file.filename().string());
      return;
    }
    if (!fs::is_regular_file(file, error) || !inputs_.insert(file).second)
      return;
    for (const std::string& text : namesInInput(file)) addText(text, folderOf(file));
  }

  void addText(const std::string& text, const fs::path& folder) {
    if (text.empty() || text.find('\0') != text.npos || isTooLong(text))
      return;
    std::vector<fs::path> spellings{text};
    if (text.find('\\') != text.npos)
      spellings.emplace_back(withSlashes(text));
    std::error_code error;
    // Most texts by far: to follow a path takes twenty calls of the system.
    if (isPlainName(text) &&
        fs::symlink_status(folder / text, error).type() == fs::file_type::not_found)
      spellings.clear();
    if (const fs::path found = written_.find(folder, text); found != folder / text)
      spellings.push_back(found.lexically_proximate(folder));
    for (const fs::path& name : spellings) {
      if (addName(name, folder)) {
        found_.push_back(text);
        return;
      }
    }
  }

  /// Whether it leads out; else what it names is gone through.
  bool addName(const fs::path& name, const fs::path& folder) {
    std::error_code error;
    const fs::path path = folder / name;
    if (!isBelowFolder(path, folder)) {
      // "/" is more likely a text than the root of all folders.
      const fs::path normal = name.lexically_normal();
      return !normal.filename().empty() || (normal.has_relative_path() && fs::exists(path, error));
    }
    if (leadsOut(path, folder))
      return true;
    if (holdsNames(path) && fs::is_regular_file(path, error))
      addFile(path);
    return false;
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

  FilesAsWritten written_;
  std::set<fs::path> seen_, inputs_;
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
  std::set<std::string> seen;
  std::istringstream lines(readText(index, kLargestCollection).value_or(""));
  constexpr std::string_view kSpaces(" \t\r\f\v\0", 6);
  bool isInput = false;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(kSpaces);
    if (begin == std::string::npos)
      continue;
    line = withSlashes(line.substr(begin, line.find_last_not_of(kSpaces) + 1 - begin));
    const bool isNew = seen.insert(line).second;
    const bool announces = line.starts_with("INPF");
    if (isNew || isInput || announces)
      names.push_back(line);
    isInput = announces;
  }
  return names;
}

std::vector<std::string> namesInInput(const std::filesystem::path& input) {
  std::vector<std::string> names;
  const std::string text = readText(input, kLargestInput).value_or("");
  for (const Namelist& group : namelists(asUtf8(text), {"CATF"})) {
    const auto found = group.values.find("OTHER_FILES");
    for (std::size_t i = 0; found != group.values.end() && i < found->second.size(); ++i)
      names.push_back(withSlashes(found->second[i]));
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
