// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/cli/option.hpp"
#include "volute/grid/region.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/image/pixels.hpp"
#include "volute/math/box.hpp"

namespace volute::cli {

/// A count of bytes (kBytes).
struct Bytes {
  std::uint64_t count = 0;
  bool operator==(const Bytes&) const = default;
};

/// A parsed value: bool for kFlag, std::string for kText, kFile, kOutput and kChoice, double for
/// kNumber, int for kInteger, and the type of the same name for the others; several texts are a
/// vector.
using Value = std::variant<bool, std::string, double, int, Bytes, FrameRange, Region, Box3, Vec3,
                           Pixels, std::vector<std::string>>;

/// The parts between separators, empty ones too; at least one.
std::vector<std::string_view> split(std::string_view text, char separator);

/// The errors of these are one sentence (kInvalidArgument) with the offending text and what was
/// expected.
[[nodiscard]] Result<double> parseNumber(std::string_view text);
/// The same, or 24000/1001.
[[nodiscard]] Result<double> parseFraction(std::string_view text);
/// Numbers with commas between.
[[nodiscard]] Result<std::vector<double>> parseNumbers(std::string_view text);
[[nodiscard]] Result<int> parseInteger(std::string_view text);
/// 123, 64K, 512M, 2G, 1.5GiB: powers of 1024.
[[nodiscard]] Result<Bytes> parseBytes(std::string_view text);
/// A:B, A:, :B, A:B:S, or one number A for that frame alone. Frame numbers are not negative.
[[nodiscard]] Result<FrameRange> parseFrames(std::string_view text);
[[nodiscard]] Result<Region> parseRegion(std::string_view text);
[[nodiscard]] Result<Box3> parseBounds(std::string_view text);
[[nodiscard]] Result<Vec3> parseVector(std::string_view text);
[[nodiscard]] Result<Pixels> parsePixels(std::string_view text);

/// The value that `option` gives to `text`, its limits and choices checked.
[[nodiscard]] Result<Value> parseValue(const Option& option, std::string_view text);

/// The error of a value says which option it is of.
template <class Value>
Result<Value> ofOption(std::string_view option, Result<Value> value) {
  if (!value)
    value.error().message = fmt::format("--{}: {}", option, value.error().message);
  return value;
}

}  // namespace volute::cli
