// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// What the whole numbers that stand for frames mean: 125 with two decimals is frame 1.25.
struct FrameScale {
  static constexpr int kMaxDecimals = 6;

  int decimals = 0;          ///< frames are numbered in units of 10^-decimals
  bool allDecimals = false;  ///< names have all of them, "1.50"; else those that are needed, "1.5"

  bool operator==(const FrameScale&) const = default;

  int unit() const;  ///< from one whole frame to the next: 10^decimals

  double frame(int number) const { return static_cast<double>(number) / unit(); }
};

/// A frame's number for people and for names: "12", "-0003", "0001.25".
/// @param width  digits of the whole part, at least
std::string frameText(int number, FrameScale scale = {}, int width = 1);

/// Where the frame's number stands in the name of a series of files.
struct FrameField {
  std::size_t begin = 0, end = 0;
  int width = 1;          ///< digits, at least
  bool anyWidth = false;  ///< files may have any number of digits
};

/// The frame number in a file's name (without folder): %d, %0Nd (N <= 9), two or more '#' or one at
/// the end of the stem, $F, $FN, ${FN}, or <frame>. Other '%', '#' and '$' are characters. Nothing
/// when there is none; an error, that wants a subject, for several and for those that are too wide.
[[nodiscard]] Result<std::optional<FrameField>> findFrameField(std::string_view fileName);

/// Whether a path names a series of files: its last component has a frame number.
bool namesSeries(const std::filesystem::path& path);

/// The same of an input: a file of this name that is there is that file.
bool namesSeriesOfFiles(const std::filesystem::path& path);

}  // namespace volute
