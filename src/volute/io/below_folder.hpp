// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

namespace volute {

/// Whether a file that another file names lies below that one's folder: an untrusted file does not
/// get to read the rest of the machine.
inline bool isBelowFolder(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto inside = std::filesystem::weakly_canonical(file, error);
  const auto root = std::filesystem::weakly_canonical(folder, error);
  const auto relative = inside.lexically_relative(root);
  return !error && !relative.empty() && *relative.begin() != "..";
}

}  // namespace volute
