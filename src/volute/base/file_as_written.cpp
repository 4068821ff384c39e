// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/file_as_written.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace volute {
namespace {

std::string withoutCapitals(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

bool isThere(const std::filesystem::path& path) {
  std::error_code code;
  return std::filesystem::exists(path, code);
}

}  // namespace

std::filesystem::path FilesAsWritten::find(const std::filesystem::path& folder,
                                           const std::string& name) {
  if (name.empty() || isThere(folder / name))
    return folder / name;
  std::string slashes = name;
  std::ranges::replace(slashes, '\\', '/');
  std::filesystem::path found = folder;
  for (const std::filesystem::path& part : std::filesystem::path(slashes)) {
    if (isThere(found / part)) {
      found /= part;
      continue;
    }
    const auto [place, isNew] = folders_.try_emplace(found);
    auto& names = place->second;
    if (isNew) {
      std::error_code code;
      for (const auto& entry :
           std::filesystem::directory_iterator(found.empty() ? "." : found, code)) {
        const std::string one = entry.path().filename().string();
        names[withoutCapitals(one)].push_back(one);
      }
    }
    const auto like = names.find(withoutCapitals(part.string()));
    if (like == names.end() || like->second.size() != 1)
      return folder / name;
    found /= like->second.front();
  }
  if (others_++ == 0)
    firstOther_ = fmt::format("{} for '{}'", found.filename().string(), name);
  return found;
}

std::string FilesAsWritten::remark() const {
  if (others_ == 0)
    return "";
  return fmt::format(
      "{} names differ from those of the files in the case of letters or by backslashes, such as "
      "{}: the files are taken",
      others_, firstOther_);
}

}  // namespace volute
