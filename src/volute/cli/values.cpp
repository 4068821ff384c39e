// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/values.hpp"

#include <fmt/ranges.h>

#include <cmath>
#include <vector>

#include "volute/base/number_word.hpp"
#include "volute/base/suggest.hpp"

namespace volute::cli {
namespace {

bool parseCount(std::string_view text, std::size_t count, std::vector<double>& numbers) {
  if (const auto found = parseNumbers(text))
    numbers = *found;
  return numbers.size() == count;
}

/// An empty part stays empty; false when there is something that is no frame number.
bool parseFrameNumber(std::string_view text, std::optional<double>& number) {
  double value = 0;
  if (!text.empty() && (!readNumber(text, value) || !(std::abs(value) < 1e9)))
    return false;
  if (!text.empty())
    number = value;
  return true;
}

Status checkLimits(const Option& option, double number, std::string_view text) {
  const bool low = option.positive ? number > 0 : number >= option.least;
  if (low && (option.below ? number < option.most : number <= option.most))
    return {};
  const std::string least =
      option.positive ? "more than 0" : fmt::format("at least {}", option.least);
  const std::string expected =
      option.below              ? fmt::format("{} and less than {}", least, option.most)
      : std::isinf(option.most) ? least
      : option.positive && low  ? fmt::format("more than 0 and at most {}", option.most)
      : option.positive         ? least
                                : fmt::format("{} to {}", option.least, option.most);
  return fail(ErrorCode::kInvalidArgument, "'{}' is out of range; expected {}", text, expected);
}

Result<Value> parseChoice(const Option& option, std::string_view text) {
  for (const auto choice : option.choices) {
    if (choice == text)
      return std::string(text);
  }
  const auto near = nearest(text, option.choices);
  return fail(ErrorCode::kInvalidArgument, "'{}' is unknown{}; expected one of {}", text,
              near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near),
              fmt::join(option.choices, ", "));
}

}  // namespace

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos)
      return parts;
    begin = end + 1;
  }
}

Result<double> parseNumber(std::string_view text) {
  double value = 0;
  if (!readNumber(text, value) || !std::isfinite(value)) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is not a finite number; expected one like 0.003 or 3e-3", text);
  }
  return value;
}

Result<double> parseFraction(std::string_view text) {
  const auto parts = split(text, '/');
  double above = 0, below = 1;
  if (parts.size() > 2 || !readNumber(parts[0], above) || !std::isfinite(above) ||
      (parts.size() == 2 &&
       (!readNumber(parts[1], below) || !std::isfinite(below) || below == 0))) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is not a finite number; expected one like 25, 23.976 or 24000/1001", text);
  }
  return above / below;
}

Result<std::vector<double>> parseNumbers(std::string_view text) {
  std::vector<double> numbers;
  for (const auto part : split(text, ',')) {
    VOLUTE_ASSIGN(const double number, parseNumber(part));
    numbers.push_back(number);
  }
  return numbers;
}

Result<int> parseInteger(std::string_view text) {
  int value = 0;
  if (!readNumber(text, value)) {
    return fail(ErrorCode::kInvalidArgument, "'{}' is not a whole number; expected one like 8",
                text);
  }
  return value;
}

Result<Bytes> parseBytes(std::string_view text) {
  const auto wrong =
      fail(ErrorCode::kInvalidArgument,
           "'{}' is not a number of bytes; expected one like 123456, 512M or 2G", text);
  const std::size_t digits = text.find_first_not_of("0123456789.");
  std::string_view unit = digits == std::string_view::npos ? "" : text.substr(digits);
  double number = 0;
  if (!readNumber(text.substr(0, digits), number))
    return wrong;
  double factor = 1;
  if (!unit.empty()) {
    constexpr std::string_view kUnits = "BKMGT";
    const std::size_t power = kUnits.find(static_cast<char>(std::toupper(unit.front())));
    const bool known = unit.size() == 1 || unit.substr(1) == "B" || unit.substr(1) == "iB";
    if (power == std::string_view::npos || !known || (power == 0 && unit.size() > 1))
      return wrong;
    factor = std::pow(1024.0, static_cast<double>(power));
  }
  const double bytes = std::floor(number * factor);
  if (!(bytes >= 1) || bytes > 0x1p62)
    return wrong;
  return Bytes{static_cast<std::uint64_t>(bytes)};
}

Result<FrameRange> parseFrames(std::string_view text) {
  const auto wrong = fail(
      ErrorCode::kInvalidArgument,
      "'{}' is not a range of frames; expected A:B or A:B:S with frame numbers A <= n < B and a "
      "step S of at least 1, like 0:48 or 10:100:5",
      text);
  const auto parts = split(text, ':');
  if (parts.size() > 3 || text.empty())
    return wrong;
  FrameRange range;
  if (!parseFrameNumber(parts[0], range.begin))
    return wrong;
  if (parts.size() == 1)
    range = FrameRange::only(*range.begin);
  if (parts.size() > 1 && !parseFrameNumber(parts[1], range.end))
    return wrong;
  if (parts.size() > 2 && !parts[2].empty() && !readNumber(parts[2], range.step))
    return wrong;
  if (range.step < 1 || (range.begin && range.end && *range.begin >= *range.end))
    return wrong;
  return range;
}

Result<Region> parseRegion(std::string_view text) {
  const auto wrong = fail(
      ErrorCode::kInvalidArgument,
      "'{}' is not a region; expected X0:X1,Y0:Y1,Z0:Z1 in voxels, half-open, like 0:16,8:24,0:64",
      text);
  Region region;
  const auto axes = split(text, ',');
  if (axes.size() != 3)
    return wrong;
  for (int axis = 0; axis < 3; ++axis) {
    const auto ends = split(axes[axis], ':');
    if (ends.size() != 2 || !readNumber(ends[0], region.begin[axis]) ||
        !readNumber(ends[1], region.end[axis])) {
      return wrong;
    }
    if (region.begin[axis] < 0 || region.begin[axis] >= region.end[axis])
      return wrong;
  }
  return region;
}

Result<Box3> parseBounds(std::string_view text) {
  std::vector<double> n;
  if (parseCount(text, 6, n)) {
    const Box3 box{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
    if (!box.empty())
      return box;
  }
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is not a bounding box; expected X0,Y0,Z0,X1,Y1,Z1 in metres, each first less "
              "than its second",
              text);
}

Result<Vec3> parseVector(std::string_view text) {
  std::vector<double> n;
  if (parseCount(text, 3, n))
    return Vec3(n[0], n[1], n[2]);
  return fail(ErrorCode::kInvalidArgument, "'{}' is not a vector; expected X,Y,Z like 0,-2.5,1",
              text);
}

Result<Pixels> parsePixels(std::string_view text) {
  constexpr int kMax = 32768;
  const auto parts = split(text, 'x');
  Pixels pixels;
  if (parts.size() == 2 && readNumber(parts[0], pixels.width) &&
      readNumber(parts[1], pixels.height) && std::min(pixels.width, pixels.height) >= 1 &&
      std::max(pixels.width, pixels.height) <= kMax) {
    return pixels;
  }
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is not a picture size; expected WxH of 1 to {} pixels, like 800x600", text,
              kMax);
}

Result<Value> parseValue(const Option& option, std::string_view text) {
  switch (option.kind) {
    case ValueKind::kFlag:
      return true;
    case ValueKind::kText:
    case ValueKind::kFile:
    case ValueKind::kOutput:
      if (text.empty())
        return fail(ErrorCode::kInvalidArgument, "the value is empty; expected {}", option.value);
      return std::string(text);
    case ValueKind::kChoice:
      return parseChoice(option, text);
    case ValueKind::kNumber: {
      VOLUTE_ASSIGN(const double number, option.fraction ? parseFraction(text) : parseNumber(text));
      VOLUTE_TRY(checkLimits(option, number, text));
      return number;
    }
    case ValueKind::kInteger: {
      VOLUTE_ASSIGN(const int number, parseInteger(text));
      VOLUTE_TRY(checkLimits(option, number, text));
      return number;
    }
    case ValueKind::kBytes:
      return parseBytes(text);
    case ValueKind::kFrames:
      return parseFrames(text);
    case ValueKind::kRegion:
      return parseRegion(text);
    case ValueKind::kBounds:
      return parseBounds(text);
    case ValueKind::kVector:
      return parseVector(text);
    case ValueKind::kPixels:
      return parsePixels(text);
  }
  return fail(ErrorCode::kInvalidArgument, "'{}' cannot be understood", text);
}

}  // namespace volute::cli
