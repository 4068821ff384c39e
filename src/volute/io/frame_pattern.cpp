// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/frame_pattern.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>

#include "volute/base/file_name.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxDigits = 9;
constexpr std::string_view kDigits = "0123456789";

/// A frame number as it stands in a name: "-0001.25".
struct WrittenNumber {
  std::string_view text;
  bool negative = false;
  std::string_view whole, decimals;
};

/// Nothing unless `text` is all of a number.
std::optional<WrittenNumber> writtenNumber(std::string_view text) {
  WrittenNumber number;
  number.text = text;
  number.negative = text.starts_with('-');
  text.remove_prefix(number.negative ? 1 : 0);
  const std::size_t end = std::min(text.find_first_not_of(kDigits), text.size());
  number.whole = text.substr(0, end);
  if (number.whole.empty() || number.whole.size() > kMaxDigits)
    return std::nullopt;
  if (end == text.size())
    return number;
  number.decimals = text.substr(end + 1);
  const bool sound = text[end] == '.' && !number.decimals.empty() &&
                     number.decimals.size() <= FrameScale::kMaxDecimals &&
                     number.decimals.find_first_not_of(kDigits) == std::string_view::npos;
  return sound ? std::optional(number) : std::nullopt;
}

/// In units of 10^-decimals of its own; nothing where that is beyond an int, and for "-0".
std::optional<NumberedFile> numberedBy(const WrittenNumber& written, std::filesystem::path path) {
  std::int64_t number = 0;
  for (const std::string_view digits : {written.whole, written.decimals})
    for (const char digit : digits) number = 10 * number + (digit - '0');
  if (number > std::numeric_limits<int>::max() || (written.negative && number == 0))
    return std::nullopt;
  return NumberedFile{static_cast<int>(written.negative ? -number : number),
                      std::move(path),
                      {static_cast<int>(written.decimals.size()), true},
                      std::string(written.text)};
}

/// Brings all numbers to one scale.
Status toOneScale(std::vector<NumberedFile>& files) {
  FrameScale scale{0, true};
  for (const NumberedFile& file : files)
    scale.decimals = std::max(scale.decimals, file.scale.decimals);
  for (const NumberedFile& file : files)
    scale.allDecimals = scale.allDecimals && file.scale.decimals == scale.decimals;
  if (scale.decimals == 0)
    scale.allDecimals = false;
  for (NumberedFile& file : files) {
    const std::int64_t number = std::int64_t{file.number} * (scale.unit() / file.scale.unit());
    if (std::abs(number) > std::numeric_limits<int>::max()) {
      return fail(
          ErrorCode::kTooLarge,
          "{}: its frame number and {} decimals have more than 9 digits; expected at most 9",
          file.path.string(), scale.decimals);
    }
    file.number = static_cast<int>(number);
    file.scale = scale;
  }
  return {};
}

/// All entries of a folder; errors of the system name it.
Result<std::vector<std::filesystem::path>> filesOf(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator it(folder.empty() ? "." : folder, error);
  for (; !error && it != std::filesystem::directory_iterator(); it.increment(error))
    files.push_back(folder / it->path().filename());
  if (error) {
    return fail(
        error == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo,
        "{}: cannot list the folder: {}", folder.empty() ? "." : folder.string(), error.message());
  }
  return files;
}

/// What has a frame's name and is no file would be a gap that nobody sees.
Status checkFiles(const std::vector<NumberedFile>& files) {
  for (const NumberedFile& file : files) {
    std::error_code error;
    const auto kind = std::filesystem::status(file.path, error).type();
    if (kind == std::filesystem::file_type::regular)
      continue;
    return fail(ErrorCode::kInvalidData, "{}: has the name of a frame and is {}; expected a file",
                file.path.string(),
                kind == std::filesystem::file_type::directory   ? "a folder"
                : kind == std::filesystem::file_type::not_found ? "a link to what is not there"
                                                                : "no file that can be read");
  }
  return {};
}

/// What helps where two files have one number: a pattern that only one of them has, if there is
/// one.
std::string adviceOnTwins(const NumberedFile& one, const NumberedFile& other) {
  const auto digits = [](const NumberedFile& file) {
    const std::string& text = file.written;
    return std::min(text.find('.'), text.size()) - (text.starts_with('-') ? 1 : 0);
  };
  if (digits(one) == digits(other))
    return "move one of them elsewhere";
  std::string name = other.path.filename().string();
  const std::string field = digits(other) == 1 ? "%d" : fmt::format("%0{}d", digits(other));
  name.replace(name.rfind(other.written), other.written.size(), field);
  return fmt::format("name one series with a pattern such as {}",
                     (other.path.parent_path() / name).string());
}

Status sortByNumber(std::vector<NumberedFile>& files) {
  std::ranges::sort(files, [](const NumberedFile& a, const NumberedFile& b) {
    return std::pair(a.number, a.path) < std::pair(b.number, b.path);
  });
  const auto twice = std::ranges::adjacent_find(files, {}, &NumberedFile::number);
  if (twice == files.end())
    return {};
  const NumberedFile& other = *std::next(twice);
  return fail(ErrorCode::kInvalidArgument, "{} and {} are both frame {}; {}", twice->path.string(),
              other.path.filename().string(), frameText(twice->number, twice->scale),
              adviceOnTwins(*twice, other));
}

/// The last number in a file's stem: where it begins and ends in the name.
struct NumberPlace {
  std::size_t begin = 0, end = 0;
};

/// @param decimals  "1.25" is one number
std::optional<NumberPlace> lastNumber(const std::string& stem, bool decimals) {
  const auto groupBefore = [&](std::size_t last) {
    const auto before = stem.find_last_not_of(kDigits, last);
    return before == std::string::npos ? 0 : before + 1;
  };
  const auto last = stem.find_last_of(kDigits);
  if (last == std::string::npos)
    return std::nullopt;
  NumberPlace place{groupBefore(last), last + 1};
  const bool fraction = decimals && place.begin >= 2 && stem[place.begin - 1] == '.' &&
                        kDigits.find(stem[place.begin - 2]) != std::string_view::npos;
  if (fraction)
    place.begin = groupBefore(place.begin - 2);
  // "s_-2" has a sign, "s-2" a separator.
  const auto isSeparator = [](char c) { return c == '_' || c == '.' || c == '-' || c == ' '; };
  if (place.begin >= 1 && stem[place.begin - 1] == '-' &&
      (place.begin == 1 || isSeparator(stem[place.begin - 2])))
    --place.begin;
  return place;
}

std::optional<NumberedFile> numberedFile(const std::filesystem::path& file, bool decimals) {
  const std::string stem = file.stem().string();
  const auto place = lastNumber(stem, decimals);
  if (!place)
    return std::nullopt;
  const auto written =
      writtenNumber(std::string_view(stem).substr(place->begin, place->end - place->begin));
  return written ? numberedBy(*written, file) : std::nullopt;
}

/// Files' names without their numbers, and those that have each.
using Sequences = std::map<std::pair<std::string, std::string>, std::vector<std::string>>;

Sequences sequencesOf(const std::vector<NumberedFile>& files, bool decimals) {
  Sequences sequences;
  for (const NumberedFile& file : files) {
    const std::string name = file.path.filename().string();
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): it is one of these
    const auto place = *lastNumber(file.path.stem().string(), decimals);
    sequences[{name.substr(0, place.begin), name.substr(place.end)}].push_back(name);
  }
  return sequences;
}

/// The first of some patterns that all files of a sequence have.
std::string patternOf(const Sequences::value_type& sequence) {
  const auto& [text, names] = sequence;
  const auto named = [&](std::string_view field) {
    return fmt::format("{}{}{}", text.first, field, text.second);
  };
  // Of the whole part, with its sign, which printf counts.
  std::size_t width = std::string::npos;
  for (const std::string& name : names) {
    const std::string_view number = std::string_view(name).substr(
        text.first.size(), name.size() - text.first.size() - text.second.size());
    width = std::min({width, number.find('.'), number.size()});
  }
  for (const std::string& field : {std::string(width, '#'), std::string("%d")}) {
    if (field == "#")
      continue;  // not everywhere in a name
    const auto pattern = FramePattern::parse(named(field));
    if (pattern && std::ranges::all_of(names, [&](const std::string& name) {
          return pattern->match(name).has_value();
        }))
      return named(field);
  }
  return named("<frame>");
}

/// Files of two sequences would be shown in turn.
Status checkOneSequence(const std::filesystem::path& folder, const Sequences& sequences) {
  if (sequences.size() < 2)
    return {};
  std::string found;
  for (const auto& sequence : sequences) {
    const std::size_t count = sequence.second.size();
    found += fmt::format("{}{} ({} file{})", found.empty() ? "" : " and ", patternOf(sequence),
                         count, count == 1 ? "" : "s");
  }
  return fail(ErrorCode::kInvalidArgument,
              "{}: holds {} sequences, {}; name one of them with its pattern", folder.string(),
              sequences.size(), found);
}

bool isVisible(const std::filesystem::path& file, std::string_view extension) {
  return extensionOf(file) == extension && !file.filename().string().starts_with('.');
}

}  // namespace

Result<FramePattern> FramePattern::parse(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const auto field = findFrameField(name);
  if (!field)
    return fail(field.error().code, field.error().hints, "{}: {}", path.string(),
                field.error().message);
  if (!*field) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: no frame number in the file's name; expected one, as %04d, %d, #### or $F4",
                path.string());
  }
  const auto text = [](std::string_view part) {
    std::string plain;
    for (std::size_t at = 0; at < part.size(); ++at) {
      plain += part[at];
      at += part.substr(at).starts_with("%%") ? 1 : 0;
    }
    return plain;
  };
  FramePattern pattern;
  pattern.path_ = path;
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
  pattern.field_ = **field;
  pattern.prefix_ = text(std::string_view(name).substr(0, pattern.field_.begin));
  pattern.suffix_ = text(std::string_view(name).substr(pattern.field_.end));
  return pattern;
}

std::filesystem::path FramePattern::format(int number, FrameScale scale) const {
  return path_.parent_path() / (prefix_ + frameText(number, scale, field_.width) + suffix_);
}

std::filesystem::path FramePattern::format(int number, FrameScale scale,
                                           std::string_view written) const {
  const std::string name = prefix_ + std::string(written) + suffix_;
  const auto same = match(name);
  return same && same->frame() == scale.frame(number) ? path_.parent_path() / name
                                                      : format(number, scale);
}

std::optional<std::string_view> FramePattern::numberIn(std::string_view fileName) const {
  if (fileName.size() < prefix_.size() + suffix_.size() || !fileName.starts_with(prefix_) ||
      !fileName.ends_with(suffix_)) {
    return std::nullopt;
  }
  fileName.remove_prefix(prefix_.size());
  fileName.remove_suffix(suffix_.size());
  return fileName;
}

std::optional<NumberedFile> FramePattern::match(std::string_view fileName) const {
  const auto text = numberIn(fileName);
  const auto written = text ? writtenNumber(*text) : std::nullopt;
  if (!written)
    return std::nullopt;
  // printf counts the sign: %04d of -2 is -002, while most programs write -0002.
  const std::size_t digits = written->whole.size();
  const auto width = static_cast<std::size_t>(field_.width);
  const bool signedWidth = written->negative && width > 1 && digits + 1 == width;
  const bool canonical = field_.anyWidth || digits == width || signedWidth ||
                         (digits > width && written->whole[0] != '0');
  return canonical ? numberedBy(*written, fileName) : std::nullopt;
}

Result<std::vector<std::string_view>> FolderFiles::named(const std::filesystem::path& folder,
                                                         std::string_view prefix,
                                                         std::string_view suffix) {
  const auto backwards = [](std::string_view a, std::string_view b) {
    return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
  };
  auto found = folders_.find(folder);
  if (found == folders_.end()) {
    VOLUTE_ASSIGN(const auto files, filesOf(folder));
    found = folders_.try_emplace(folder).first;
    Names& names = found->second;
    for (const auto& file : files) names.sorted.push_back(file.filename().string());
    std::ranges::sort(names.sorted);
    for (const std::string& name : names.sorted) names.byEnd.push_back(&name);
    std::ranges::sort(names.byEnd, backwards, [](const std::string* name) { return *name; });
  }
  const Names& names = found->second;
  const auto begin = std::ranges::lower_bound(names.sorted, prefix, std::less<>());
  const auto end = std::partition_point(
      begin, names.sorted.end(), [&](const std::string& name) { return name.starts_with(prefix); });
  const auto beginOfEnds =
      std::lower_bound(names.byEnd.begin(), names.byEnd.end(), suffix,
                       [&](const std::string* a, std::string_view b) { return backwards(*a, b); });
  const auto endOfEnds =
      std::partition_point(beginOfEnds, names.byEnd.end(),
                           [&](const std::string* name) { return name->ends_with(suffix); });
  std::vector<std::string_view> chosen;
  const auto choose = [&](std::string_view name) {
    if (name.starts_with(prefix) && name.ends_with(suffix))
      chosen.push_back(name);
  };
  if (end - begin <= endOfEnds - beginOfEnds)
    std::for_each(begin, end, choose);
  else
    std::for_each(beginOfEnds, endOfEnds, [&](const std::string* name) { choose(*name); });
  return chosen;
}

Result<std::vector<NumberedFile>> FramePattern::list(SubFrames subFrames) const {
  FolderFiles folders;
  return list(folders, subFrames);
}

Result<std::vector<NumberedFile>> FramePattern::list(FolderFiles& folders,
                                                     SubFrames subFrames) const {
  const auto folder = path_.parent_path();
  VOLUTE_ASSIGN(const auto names, folders.named(folder, prefix_, suffix_));
  std::vector<NumberedFile> matching;
  for (const std::string_view name : names) {
    auto found = match(name);
    if (!found)
      continue;
    found->path = folder / name;
    matching.push_back(std::move(*found));
  }
  if (matching.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: no file matches this pattern; the first was expected as {}", path_.string(),
                format(1).string());
  }
  VOLUTE_TRY(checkFiles(matching));
  VOLUTE_TRY(toOneScale(matching));
  if (subFrames == SubFrames::kRefused && matching.front().scale.decimals > 0) {
    const auto part = std::ranges::find_if(
        matching, [](const NumberedFile& file) { return file.number % file.scale.unit() != 0; });
    return fail(ErrorCode::kUnsupported,
                "{}: a frame between whole ones, which only volumes have; move it elsewhere",
                (part == matching.end() ? matching.front() : *part).path.string());
  }
  VOLUTE_TRY(sortByNumber(matching));
  return matching;
}

std::vector<std::string> FramePattern::others() const {
  std::vector<std::string> names;
  const auto files = filesOf(path_.parent_path());
  for (std::size_t i = 0; files && i < files->size(); ++i) {
    std::string name = (*files)[i].filename().string();
    const std::string itsName = name;
    // "s_0002.NPY" is taken for one of a sequence, too.
    const std::size_t end = name.size() - std::min(name.size(), suffix_.size());
    if (lowerCase(name.substr(end)) == lowerCase(suffix_))
      name.replace(end, std::string::npos, suffix_);
    const auto text = numberIn(name);
    const bool numeric = text && !text->empty() && kDigits.find(text->back()) != text->npos &&
                         text->find_first_not_of("+- .0123456789") == text->npos;
    if (numeric && !match(itsName))
      names.push_back(itsName);
  }
  std::ranges::sort(names);
  return names;
}

std::optional<int> frameNumberOf(const std::filesystem::path& file) {
  const auto numbered = numberedFile(file, false);
  return numbered ? std::optional(numbered->number) : std::nullopt;
}

std::vector<FrameGap> gapsOf(std::span<const int> numbers) {
  std::int64_t step = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    const auto gap = std::int64_t{numbers[i]} - numbers[i - 1];
    step = i == 1 ? gap : std::min(step, gap);
  }
  std::vector<FrameGap> gaps;
  for (std::size_t i = 1; step > 0 && i < numbers.size(); ++i) {
    const auto gap = std::int64_t{numbers[i]} - numbers[i - 1];
    if (gap % step != 0)
      return {};
    if (gap > step) {
      gaps.push_back({static_cast<int>(numbers[i - 1] + step), static_cast<int>(numbers[i] - step),
                      static_cast<int>(gap / step - 1)});
    }
  }
  return gaps;
}

std::string missingNumbers(std::span<const int> numbers, FrameScale scale) {
  constexpr std::size_t kShown = 8;
  const auto text = [&](int number) { return frameText(number, scale); };
  const auto gaps = gapsOf(numbers);
  if (gaps.empty())
    return {};
  std::int64_t missing = 0;
  std::string ranges;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    missing += gaps[i].count;
    if (i >= kShown)
      continue;
    ranges += ranges.empty() ? "" : ", ";
    ranges += gaps[i].count == 1 ? text(gaps[i].first)
                                 : fmt::format("{} to {}", text(gaps[i].first), text(gaps[i].last));
  }
  return fmt::format(
      "{} of the frames {} to {} {} missing: {}{}", missing, text(numbers.front()),
      text(numbers.back()), missing == 1 ? "is" : "are", ranges,
      gaps.size() > kShown ? fmt::format(" and {} more gaps", gaps.size() - kShown) : "");
}

Result<std::vector<NumberedFile>> listNumberedFiles(const std::filesystem::path& folder,
                                                    std::string_view extension) {
  VOLUTE_ASSIGN(const auto files, filesOf(folder));
  const auto numbered = [&](bool decimals) {
    std::vector<NumberedFile> found;
    for (const auto& file : files) {
      auto one = isVisible(file, extension) ? numberedFile(file, decimals) : std::nullopt;
      if (one)
        found.push_back(std::move(*one));
    }
    return found;
  };
  std::vector<NumberedFile> found = numbered(false);
  if (found.empty()) {
    return fail(ErrorCode::kNotFound, "{}: no numbered {} files in this folder", folder.string(),
                extension);
  }
  // "s.1.25" is frame 1.25 where that makes one sequence of them, "v1.0025" is frame 25.
  const Sequences sequences = sequencesOf(found, false);
  if (sequences.size() > 1) {
    std::vector<NumberedFile> fractions = numbered(true);
    const Sequences fewer = sequencesOf(fractions, true);
    const bool all = fractions.size() == found.size();  // some may have too many digits
    if (!all || fewer.size() > 1)
      VOLUTE_TRY(
          checkOneSequence(folder, all && fewer.size() < sequences.size() ? fewer : sequences));
    found = std::move(fractions);
  }
  VOLUTE_TRY(checkFiles(found));
  VOLUTE_TRY(toOneScale(found));
  VOLUTE_TRY(sortByNumber(found));
  return found;
}

std::string leftOutFiles(const std::filesystem::path& input, std::string_view extension) {
  constexpr std::size_t kShown = 4;
  std::vector<std::string> names;
  std::error_code error;
  if (std::filesystem::is_directory(input, error)) {
    const auto files = filesOf(input);
    for (std::size_t i = 0; files && i < files->size(); ++i) {
      if (isVisible((*files)[i], extension) && !numberedFile((*files)[i], false))
        names.push_back((*files)[i].filename().string());
    }
    std::ranges::sort(names);
  } else if (namesSeriesOfFiles(input)) {
    if (const auto pattern = FramePattern::parse(input))
      names = pattern->others();
  }
  if (names.empty())
    return {};
  std::string text =
      fmt::format("{} file{} left out: ", names.size(), names.size() == 1 ? " is" : "s are");
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i)
    text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kShown ? text + fmt::format(" and {} more", names.size() - kShown) : text;
}

}  // namespace volute
