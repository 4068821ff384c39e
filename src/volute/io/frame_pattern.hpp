// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// A file of a numbered series.
struct NumberedFile {
  int number = 0;  ///< in units of its scale, the same one for the whole series
  std::filesystem::path path;
  FrameScale scale{};
  std::string written{};  ///< the number as it stands in the name: "-0001.25"

  double frame() const { return scale.frame(number); }
};

/// Whether a series may have numbers between whole ones.
enum class SubFrames { kRefused, kAllowed };

/// The regular files of folders, each of which is listed once and looked through by the beginnings
/// and ends of names: for many series in one folder.
class FolderFiles {
 public:
  FolderFiles() = default;
  FolderFiles(const FolderFiles&) = delete;
  FolderFiles& operator=(const FolderFiles&) = delete;

  /// Names that begin with `prefix` and end with `suffix`, in no order; kNotFound or kIo where the
  /// folder cannot be listed.
  [[nodiscard]] Result<std::vector<std::string_view>> named(const std::filesystem::path& folder,
                                                            std::string_view prefix,
                                                            std::string_view suffix);

 private:
  struct Names {
    std::vector<std::string> sorted;
    std::vector<const std::string*> byEnd;  // sorted by what they read backwards
  };

  std::map<std::filesystem::path, Names> folders_;
};

/// The name of a series of files, one for each frame: "flame_%04d.vdb", "out/%d.png",
/// "flame_####.vdb" (see findFrameField). Numbers may be negative ("flame_-0002.vdb") and have
/// decimals ("flame_0001.25.vdb").
class FramePattern {
 public:
  /// kInvalidArgument unless there is just one frame number in the file's name. "%%" is a percent
  /// sign.
  [[nodiscard]] static Result<FramePattern> parse(const std::filesystem::path& path);

  /// The file of a frame.
  std::filesystem::path format(int number, FrameScale scale = {}) const;

  /// The same with the number as it is written where that is one of this pattern's.
  std::filesystem::path format(int number, FrameScale scale, std::string_view written) const;

  /// The number in a file's name (without folder), when it is one that format() would give.
  std::optional<NumberedFile> match(std::string_view fileName) const;

  /// The files that are there, by ascending number; kNotFound when there are none.
  [[nodiscard]] Result<std::vector<NumberedFile>> list(
      SubFrames subFrames = SubFrames::kRefused) const;

  /// The same by what is known of its folder.
  [[nodiscard]] Result<std::vector<NumberedFile>> list(
      FolderFiles& folders, SubFrames subFrames = SubFrames::kRefused) const;

  /// Names of files that are there and have another frame number in this place, such as one of
  /// another width; ascending.
  std::vector<std::string> others() const;

  std::string string() const { return path_.string(); }

 private:
  FramePattern() = default;

  std::optional<std::string_view> numberIn(std::string_view fileName) const;

  std::filesystem::path path_;
  std::string prefix_, suffix_;
  FrameField field_;
};

/// The number of a single file: the last group of digits in its stem, negative where a '-' stands
/// before it that is no separator; nothing when there is none or it is beyond 9 digits.
std::optional<int> frameNumberOf(const std::filesystem::path& file);

/// Frames that a sequence leaves out.
struct FrameGap {
  int first = 0, last = 0, count = 0;
};

/// The gaps in ascending numbers whose steps are multiples of the smallest; of others, none.
std::vector<FrameGap> gapsOf(std::span<const int> numbers);

/// The same for people: "3 of the frames 1 to 10 are missing: 5, 8 to 9"; empty when none is.
std::string missingNumbers(std::span<const int> numbers, FrameScale scale = {});

/// The numbered files with `extension` (".vdb") in a folder, by ascending number. An error when
/// there are none or two have the same number.
[[nodiscard]] Result<std::vector<NumberedFile>> listNumberedFiles(
    const std::filesystem::path& folder, std::string_view extension);

/// What a pattern or a folder of files with `extension` leaves out though it looks like a part of
/// the sequence: "2 files are left out: s_01.vdb, s_02.vdb"; empty when nothing is.
std::string leftOutFiles(const std::filesystem::path& input, std::string_view extension);

}  // namespace volute
