// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/read_text.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// The lines of a text file, one at a time, so that memory does not grow with the file.
class TextLines {
 public:
  [[nodiscard]] static Result<TextLines> open(const std::filesystem::path& path,
                                              std::size_t longestLine = kLongestLine);

  static constexpr std::size_t kLongestLine = std::size_t{1} << 16;

  /// The next line without its end; nothing after the last. A last line that no newline ends is
  /// left out: whoever writes the file has not finished it. A longer line than that is an error.
  [[nodiscard]] Result<std::optional<std::string>> next();

  int lineNumber() const { return lineNumber_; }  ///< of the line that next() gave last, from 1

  /// Whether the file ended in the middle of a line.
  bool endedWithinLine() const { return endedWithinLine_; }

  const std::filesystem::path& path() const { return file_.path(); }

 private:
  TextLines(InputFile file, std::size_t longestLine)
      : file_(std::move(file)), longestLine_(longestLine) {}

  Result<bool> fill();

  InputFile file_;
  std::size_t longestLine_;
  std::uint64_t offset_ = 0;
  std::string buffer_;
  std::size_t place_ = 0;
  int lineNumber_ = 0;
  bool endedWithinLine_ = false;
};

/// The words of a line, which spaces separate.
std::vector<std::string_view> words(std::string_view text);

/// A whole word as a number; nothing when it is none or not finite.
std::optional<double> numberOf(std::string_view word);
std::optional<int> integerOf(std::string_view word);

}  // namespace volute
