// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// A file of a numbered series.
struct NumberedFile {
  int number = 0;
  std::filesystem::path path;
};

/// The name of a series of files, one for each frame: "flame_%04d.vdb", "out/%d.png",
/// "flame_####.vdb". The number stands in the file's name, not in its folder's.
class FramePattern {
 public:
  /// True when the file's name has a '%' or a '#'.
  static bool isPattern(const std::filesystem::path& path);

  /// kInvalidArgument unless there is just one number, as %d, %0Nd (N <= 9) or a run of '#'. "%%"
  /// is a percent sign.
  [[nodiscard]] static Result<FramePattern> parse(const std::filesystem::path& path);

  /// The file of frame `number` (>= 0).
  std::filesystem::path format(int number) const;

  /// The number in a file's name (without folder), when it is one that format() would give.
  std::optional<int> match(std::string_view fileName) const;

  /// The files that are there, by ascending number; kNotFound when there are none.
  [[nodiscard]] Result<std::vector<NumberedFile>> list() const;

  std::string string() const { return path_.string(); }

 private:
  FramePattern() = default;

  std::filesystem::path path_;
  std::string prefix_, suffix_;
  int width_ = 1;
};

/// The number of a single file: the last group of digits in its stem; nothing when there is none or
/// it is beyond 9 digits.
std::optional<int> frameNumberOf(const std::filesystem::path& file);

/// Frames that a sequence leaves out.
struct FrameGap {
  int first = 0, last = 0, count = 0;
};

/// The gaps in ascending numbers whose steps are multiples of the smallest; of others, none.
std::vector<FrameGap> gapsOf(std::span<const int> numbers);

/// The same for people: "3 of the frames 1 to 10 are missing: 5, 8 to 9"; empty when none is.
std::string missingNumbers(std::span<const int> numbers);

/// The numbered files with `extension` (".vdb") in a folder, by ascending number. An error when
/// there are none or two have the same number.
[[nodiscard]] Result<std::vector<NumberedFile>> listNumberedFiles(
    const std::filesystem::path& folder, std::string_view extension);

}  // namespace volute
