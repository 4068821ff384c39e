// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/report/json.hpp"

namespace volute {

/// Large values of a JSON file, as text in a file of their own until it is written: as a tree,
/// numbers of a million points take more memory than all else.
class JsonParts {
 public:
  /// The parts wait in a file in this folder.
  explicit JsonParts(const std::filesystem::path& folder) : file_(folder / "parts.tmp") {}

  ~JsonParts();
  JsonParts(const JsonParts&) = delete;
  JsonParts& operator=(const JsonParts&) = delete;

  /// @param text  a JSON value
  /// @return  what stands for it in the tree: a binary value, which no text of a file becomes
  Json add(std::string_view text);

  /// Writes the tree as dumpJson() would, with each part in its place. Also fails where a part
  /// could not be kept.
  [[nodiscard]] Status write(const std::filesystem::path& path, const Json& json) const;

 private:
  struct Part {
    std::uint64_t begin = 0, size = 0;
  };

  std::filesystem::path file_;
  std::vector<Part> parts_;
  Status kept_;
};

/// Appends a number as dumpJson() writes it; null when it is not finite.
void appendJson(std::string& text, double value);

}  // namespace volute
