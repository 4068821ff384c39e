// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/output_names.hpp"

#include <algorithm>
#include <climits>

#include "volute/base/file_name.hpp"
#include "volute/base/printable.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/named_files.hpp"

namespace volute {
namespace {

namespace fs = std::filesystem;

/// The same for all spellings of a file, whether it is there or not, and for links to it.
fs::path placeOf(const fs::path& name) {
  constexpr int kMaxLinks = 40;  // as Linux follows
  fs::path target = fs::absolute(name);
  std::error_code error;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(target, error); ++i) {
    const auto next = fs::read_symlink(target, error);
    if (error)
      break;
    target = target.parent_path() / next;
  }
  const auto place = fs::weakly_canonical(target, error);
  return error ? target.lexically_normal() : place;
}

/// Whether `file` is one of the pattern's, or one of these is a link to it.
bool isOneOf(const fs::path& file, const fs::path& pattern) {
  const auto parsed = FramePattern::parse(pattern);
  if (!parsed || FramePattern::parse(file))
    return false;
  if (file.parent_path() == pattern.parent_path() && parsed->match(file.filename().string()))
    return true;
  std::error_code error;
  for (fs::directory_iterator at(pattern.parent_path(), error), end; !error && at != end;
       at.increment(error)) {
    std::error_code ignored;
    if (at->is_symlink(ignored) && parsed->match(at->path().filename().string()) &&
        placeOf(at->path()) == file)
      return true;
  }
  return false;
}

bool isSame(const fs::path& place, const fs::path& other) {
  return place == other || isOneOf(place, other) || isOneOf(other, place);
}

/// A file, or any of a pattern's.
bool isThere(const fs::path& place) {
  const auto pattern = FramePattern::parse(place);
  std::error_code error;
  if (!pattern)
    return fs::exists(place, error);
  for (fs::directory_iterator at(place.parent_path(), error), end; !error && at != end;
       at.increment(error)) {
    if (pattern->match(at->path().filename().string()))
      return true;
  }
  return false;
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
    if (isSame(place, other)) {
      return fail(ErrorCode::kInvalidArgument,
                  "two outputs have the name {}: {} and {}; give one of them another", name,
                  otherWhat, what);
    }
  }
  names_.emplace_back(place, what);
  return {};
}

bool replaces(const std::string& output, const std::string& input) {
  const fs::path place = placeOf(output);
  std::error_code error;
  if (fs::is_directory(input, error)) {
    // What volumes in a folder are called.
    const std::string extension = extensionOf(place);
    return (extension == ".vdb" || extension == ".npy") && isThere(place) &&
           place.parent_path() == placeOf(input);
  }
  return isSameFile(output, input) || isSame(place, placeOf(input));
}

Status checkReplacesNothing(const std::string& output, const std::vector<std::string>& inputs,
                            std::string_view setting) {
  const auto check = [&](const std::string& input, const std::string& reader) -> Status {
    if (!replaces(output, input))
      return {};
    return failFor(setting, ErrorCode::kInvalidArgument,
                   "{} is read{} and would be replaced; give another name", output,
                   reader.empty() ? "" : " by " + reader);
  };
  if (output.empty() || output == "-")
    return {};
  for (const std::string& input : inputs) {
    if (input.empty())
      continue;
    VOLUTE_TRY(check(input, ""));
    for (const std::string& named : filesNamedIn(input)) VOLUTE_TRY(check(named, input));
    if (extensionOf(input) != ".pvd")
      continue;
    for (const std::string& name : namesInCollection(input))
      VOLUTE_TRY(check((fs::path(input).parent_path() / name).string(), input));
  }
  return {};
}

bool liesIn(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const auto inside = fs::weakly_canonical(fs::absolute(file), error);
  const auto whole = fs::weakly_canonical(fs::absolute(folder / ".").lexically_normal(), error);
  const auto from = inside.lexically_relative(whole.has_filename() ? whole : whole.parent_path());
  return !error && !from.empty() && *from.begin() != "..";
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
