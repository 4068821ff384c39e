// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/output_names.hpp"

#include <algorithm>
#include <climits>

#include "volute/base/file_name.hpp"
#include "volute/base/printable.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

/// The same for all spellings of a file, whether it is there or not.
fs::path placeOf(const std::string& name) {
  std::error_code error;
  const auto place = fs::weakly_canonical(fs::absolute(name), error);
  return error ? fs::absolute(name).lexically_normal() : place;
}

/// Whether `file` is one of the pattern's.
bool isOneOf(const fs::path& file, const fs::path& pattern) {
  if (file.parent_path() != pattern.parent_path())
    return false;
  const auto parsed = FramePattern::parse(pattern);
  return parsed && parsed->match(file.filename().string()).has_value();
}

}  // namespace

Status OutputNames::add(const std::string& name, std::string_view what) {
  const auto frames = FramePattern::parse(name);
  const fs::path file = frames ? frames->format(0) : fs::path(name);
  if (const std::size_t bytes = file.filename().native().size(); bytes > NAME_MAX) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: {} has a name of {} bytes; expected at most {}, which file systems take", name,
                what, bytes, NAME_MAX);
  }
  const fs::path place = placeOf(name);
  for (const auto& [other, otherWhat] : names_) {
    if (place == other || isOneOf(place, other) || isOneOf(other, place)) {
      return fail(ErrorCode::kInvalidArgument,
                  "two outputs have the name {}: {} and {}; give one of them another", name,
                  otherWhat, what);
    }
  }
  names_.emplace_back(place, what);
  return {};
}

Status checkNamePart(std::string_view name, const std::string& what) {
  const bool wrong = name.empty() || name == "." || name == ".." ||
                     std::ranges::any_of(name, [](unsigned char letter) {
                       return letter == '/' || letter < ' ' || letter == 0x7f;
                     });
  if (!wrong)
    return {};
  return fail(ErrorCode::kInvalidData,
              "{} is called '{}'; expected a name that may be part of a file's, without slashes: "
              "take it out alone, into a file that you name",
              what, printable(name));
}

}  // namespace volute
