// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/frame_name.hpp"

#include <cstdlib>

namespace volute {
namespace {

constexpr int kMaxWidth = 9;
constexpr std::string_view kDigits = "0123456789";

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Its length in `rest`, which begins with '%': "%d", "%04d". One with another width has width 0.
std::optional<FrameField> conversion(std::string_view rest) {
  std::size_t end = 1;
  while (end < rest.size() && isDigit(rest[end])) ++end;
  if (end == rest.size() || rest[end] != 'd')
    return std::nullopt;
  const std::string_view digits = rest.substr(1, end - 1);
  FrameField field{0, end + 1};
  if (!digits.empty())
    field.width = digits.size() == 2 && digits[0] == '0' ? digits[1] - '0' : 0;
  return field;
}

/// "####"; a lone '#' where the stem ends with it.
std::optional<FrameField> hashes(std::string_view rest, bool inExtension) {
  const std::size_t end = std::min(rest.find_first_not_of('#'), rest.size());
  const bool atEnd =
      !inExtension && (end == rest.size() ||
                       (rest[end] == '.' && rest.find('.', end + 1) == std::string_view::npos));
  if (end < 2 && !atEnd)
    return std::nullopt;
  return FrameField{0, end, static_cast<int>(end)};
}

/// "$F", "$FF" (a number with decimals), "$F4", "${F4}".
std::optional<FrameField> variable(std::string_view rest) {
  const bool braced = rest.starts_with("${F");
  if (!braced && !rest.starts_with("$F"))
    return std::nullopt;
  const std::size_t begin = rest.starts_with("$FF") || braced ? 3 : 2;
  const std::size_t end = std::min(rest.find_first_not_of(kDigits, begin), rest.size());
  FrameField field{0, end};
  if (end > begin)
    field.width = end - begin == 1 ? rest[begin] - '0' : kMaxWidth + 1;
  if (braced && (end == rest.size() || rest[end] != '}'))
    return std::nullopt;
  if (braced)
    ++field.end;
  // "$Folder" is another variable.
  const char next = field.end < rest.size() ? rest[field.end] : '\0';
  const bool letter = (next >= 'a' && next <= 'z') || (next >= 'A' && next <= 'Z');
  if (!braced && end == begin && letter)
    return std::nullopt;
  return field;
}

std::optional<FrameField> placeholder(std::string_view rest) {
  constexpr std::string_view kFrame = "<frame>";
  if (!rest.starts_with(kFrame))
    return std::nullopt;
  return FrameField{0, kFrame.size(), 1, true};
}

std::optional<FrameField> fieldAt(std::string_view name, std::size_t at) {
  const std::string_view rest = name.substr(at);
  switch (rest[0]) {
    case '%':
      return conversion(rest);
    case '#':
      return hashes(rest, at > name.rfind('.') && name.rfind('.') != name.npos);
    case '$':
      return variable(rest);
    case '<':
      return placeholder(rest);
    default:
      return std::nullopt;
  }
}

}  // namespace

int FrameScale::unit() const {
  int unit = 1;
  for (int i = 0; i < decimals; ++i) unit *= 10;
  return unit;
}

std::string frameText(int number, FrameScale scale, int width) {
  const std::int64_t size = std::abs(static_cast<std::int64_t>(number));
  std::string text = fmt::format("{}{:0{}}", number < 0 ? "-" : "", size / scale.unit(), width);
  if (scale.decimals == 0)
    return text;
  std::string decimals = fmt::format("{:0{}}", size % scale.unit(), scale.decimals);
  if (!scale.allDecimals)
    decimals.resize(decimals.find_last_not_of('0') + 1);
  return decimals.empty() ? text : text + '.' + decimals;
}

Result<std::optional<FrameField>> findFrameField(std::string_view fileName) {
  const auto refuse = [](std::string_view reason) {
    return fail(ErrorCode::kInvalidArgument,
                "{}; expected one frame number, as %04d, %d, #### or $F4", reason);
  };
  std::optional<FrameField> found;
  for (std::size_t at = 0; at < fileName.size();) {
    if (fileName.substr(at).starts_with("%%")) {
      at += 2;
      continue;
    }
    auto field = fieldAt(fileName, at);
    if (!field) {
      ++at;
      continue;
    }
    if (found)
      return refuse("more than one frame number");
    if (field->width < 1)
      return refuse("a frame number without leading zeros or of more than 9 digits");
    if (field->width > kMaxWidth)
      return refuse("a frame number of more than 9 digits");
    field->begin += at, field->end += at;
    at = field->end;
    found = field;
  }
  return found;
}

bool namesSeries(const std::filesystem::path& path) {
  const auto field = findFrameField(path.filename().string());
  return !field || *field;
}

bool namesSeriesOfFiles(const std::filesystem::path& path) {
  std::error_code error;
  return namesSeries(path) && !std::filesystem::exists(path, error);
}

}  // namespace volute
