// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "volute/base/lower_case.hpp"

namespace volute {

/// A name's last extension in lower case, with the dot.
inline std::string extensionOf(const std::filesystem::path& path) {
  return lowerCase(path.extension().string());
}

/// True when both are there and the same file, or the same path when they are not.
inline bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error) && !error)
    return true;
  return std::filesystem::absolute(a, error).lexically_normal() ==
         std::filesystem::absolute(b, error).lexically_normal();
}

/// A path in the folder that `file` lies in. Not path::replace_filename(), which crashes where
/// memory ends in it (libstdc++ 12).
inline std::filesystem::path siblingOf(const std::filesystem::path& file, std::string_view name) {
  return file.parent_path() / name;
}

/// The folder that a file lies in; "." for a bare name.
inline std::filesystem::path folderOf(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace volute
