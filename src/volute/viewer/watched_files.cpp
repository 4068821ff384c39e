// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/watched_files.hpp"

#include <algorithm>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

#include "volute/base/read_text.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

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

/// What a collection's DataSets call their files. Whatever else is wrong with it is said by those
/// who read it.
std::vector<std::string> namesIn(const std::filesystem::path& collection) {
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

/// What lines of an FDS case's index name alone, which is how it names the files of its results:
/// those of a run that goes on grow.
std::vector<std::string> resultsIn(const std::filesystem::path& index) {
  constexpr std::string_view kKinds[] = {".sf", ".s3d", ".q", ".iso", ".prt5"};
  std::vector<std::string> names;
  std::istringstream lines(readText(index, kLargestCollection).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(" \t"), end = line.find_last_not_of(" \t\r");
    if (begin == std::string::npos)
      continue;
    line = line.substr(begin, end + 1 - begin);
    if (std::ranges::any_of(kKinds, [&](std::string_view kind) { return line.ends_with(kind); }))
      names.push_back(line);
  }
  return names;
}

std::filesystem::path besideOf(const std::filesystem::path& file, const std::string& name) {
  return file.parent_path() / name;
}

}  // namespace

std::vector<std::filesystem::path> filesOf(const std::string& name) {
  std::vector<std::filesystem::path> files;
  if (namesSeriesOfFiles(name)) {
    const auto pattern = FramePattern::parse(name);
    const auto there =
        pattern ? pattern->list(SubFrames::kAllowed) : Result<std::vector<NumberedFile>>();
    if (!pattern || !there || there->empty())
      return {name};
    for (const NumberedFile& file : *there) files.push_back(file.path);
    files.push_back(
        pattern->format(there->back().number + there->back().scale.unit(), there->back().scale));
    return files;
  }
  files.emplace_back(name);
  if (extensionOf(name) == ".pvd") {
    for (const std::string& part : namesIn(name)) files.push_back(besideOf(name, part));
  }
  if (extensionOf(name) == ".smv") {
    for (const std::string& part : resultsIn(name)) files.push_back(besideOf(name, part));
  }
  return files;
}

}  // namespace volute
