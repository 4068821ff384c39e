// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/frame_pattern.hpp"

#include <algorithm>
#include <charconv>
#include <map>

namespace volute {
namespace {

constexpr std::size_t kMaxDigits = 9;

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

std::optional<int> toNumber(std::string_view digits) {
  if (digits.empty() || digits.size() > kMaxDigits || !std::ranges::all_of(digits, isDigit))
    return std::nullopt;
  int number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

/// All regular files of a folder; errors of the system name it.
Result<std::vector<std::filesystem::path>> filesOf(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator it(folder.empty() ? "." : folder, error);
  for (; !error && it != std::filesystem::directory_iterator(); it.increment(error)) {
    std::error_code unknown;
    if (it->is_regular_file(unknown))
      files.push_back(folder / it->path().filename());
  }
  if (error) {
    return fail(
        error == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo,
        "{}: cannot list the folder: {}", folder.empty() ? "." : folder.string(), error.message());
  }
  return files;
}

Status sortByNumber(std::vector<NumberedFile>& files) {
  std::ranges::sort(files, [](const NumberedFile& a, const NumberedFile& b) {
    return std::pair(a.number, a.path) < std::pair(b.number, b.path);
  });
  const auto twice = std::ranges::adjacent_find(files, {}, &NumberedFile::number);
  if (twice == files.end())
    return {};
  return fail(
      ErrorCode::kInvalidArgument,
      "{} and {} have the same frame number; name one series with a pattern such as {}",
      twice->path.string(), std::next(twice)->path.filename().string(),
      (twice->path.parent_path() / ("name_%04d" + twice->path.extension().string())).string());
}

/// A file's name without its number.
std::pair<std::string, std::string> aroundNumber(const std::filesystem::path& file) {
  const std::string name = file.filename().string(), stem = file.stem().string();
  const auto last = stem.find_last_of("0123456789");
  const auto before = stem.find_last_not_of("0123456789", last);
  return {name.substr(0, before == std::string::npos ? 0 : before + 1), name.substr(last + 1)};
}

/// Files of two sequences would be shown in turn.
Status checkOneSequence(const std::filesystem::path& folder,
                        const std::vector<NumberedFile>& files) {
  std::map<std::pair<std::string, std::string>, int> sequences;
  for (const NumberedFile& file : files) ++sequences[aroundNumber(file.path)];
  if (sequences.size() < 2)
    return {};
  std::string found;
  for (const auto& [name, count] : sequences) {
    found += fmt::format("{}{}####{} ({} file{})", found.empty() ? "" : " and ", name.first,
                         name.second, count, count == 1 ? "" : "s");
  }
  return fail(ErrorCode::kInvalidArgument,
              "{}: holds {} sequences, {}; name one of them with its pattern", folder.string(),
              sequences.size(), found);
}

}  // namespace

bool FramePattern::isPattern(const std::filesystem::path& path) {
  return path.filename().string().find_first_of("%#") != std::string::npos;
}

Result<FramePattern> FramePattern::parse(const std::filesystem::path& path) {
  const auto refuse = [&](const char* reason) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: {}; expected one frame number, as %04d, %d or ####", path.string(), reason);
  };
  if (path.parent_path().string().find_first_of("%#") != std::string::npos) {
    return refuse("a frame number in the folder's name");
  }
  FramePattern pattern;
  pattern.path_ = path;
  bool found = false;
  const std::string name = path.filename().string();
  for (std::size_t at = 0; at < name.size();) {
    std::string& text = found ? pattern.suffix_ : pattern.prefix_;
    if (name.compare(at, 2, "%%") == 0) {
      text += '%';
      at += 2;
      continue;
    }
    if (name[at] != '%' && name[at] != '#') {
      text += name[at++];
      continue;
    }
    if (found)
      return refuse("more than one frame number");
    found = true;
    if (name[at] == '#') {
      const std::size_t end = std::min(name.find_first_not_of('#', at), name.size());
      pattern.width_ = static_cast<int>(end - at);
      at = end;
    } else {
      const bool padded = at + 3 < name.size() && name[at + 1] == '0' && name[at + 2] >= '1' &&
                          name[at + 2] <= '9' && name[at + 3] == 'd';
      if (!padded && name.compare(at, 2, "%d") != 0)
        return refuse("no frame number after '%'");
      pattern.width_ = padded ? name[at + 2] - '0' : 1;
      at += padded ? 4 : 2;
    }
    if (pattern.width_ > static_cast<int>(kMaxDigits))
      return refuse("a frame number of more than 9 digits");
  }
  if (!found)
    return refuse("no frame number");
  return pattern;
}

std::filesystem::path FramePattern::format(int number) const {
  return path_.parent_path() / fmt::format("{}{:0{}}{}", prefix_, number, width_, suffix_);
}

std::optional<int> FramePattern::match(std::string_view fileName) const {
  if (fileName.size() < prefix_.size() + suffix_.size() || !fileName.starts_with(prefix_) ||
      !fileName.ends_with(suffix_)) {
    return std::nullopt;
  }
  fileName.remove_prefix(prefix_.size());
  fileName.remove_suffix(suffix_.size());
  const auto number = toNumber(fileName);
  const bool canonical = fileName.size() == static_cast<std::size_t>(width_) ||
                         (fileName.size() > static_cast<std::size_t>(width_) && fileName[0] != '0');
  return canonical ? number : std::nullopt;
}

Result<std::vector<NumberedFile>> FramePattern::list() const {
  VOLUTE_ASSIGN(const auto files, filesOf(path_.parent_path()));
  std::vector<NumberedFile> matching;
  for (const auto& file : files) {
    if (const auto number = match(file.filename().string()))
      matching.push_back({*number, file});
  }
  if (matching.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: no file matches this pattern; the first was expected as {}", path_.string(),
                format(1).string());
  }
  VOLUTE_TRY(sortByNumber(matching));
  return matching;
}

std::optional<int> frameNumberOf(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  const auto last = stem.find_last_of("0123456789");
  if (last == std::string::npos)
    return std::nullopt;
  const auto before = stem.find_last_not_of("0123456789", last);
  const auto begin = before == std::string::npos ? 0 : before + 1;
  return toNumber(std::string_view(stem).substr(begin, last + 1 - begin));
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

std::string missingNumbers(std::span<const int> numbers) {
  constexpr std::size_t kShown = 8;
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
    ranges += gaps[i].count == 1 ? fmt::format("{}", gaps[i].first)
                                 : fmt::format("{} to {}", gaps[i].first, gaps[i].last);
  }
  return fmt::format(
      "{} of the frames {} to {} {} missing: {}{}", missing, numbers.front(), numbers.back(),
      missing == 1 ? "is" : "are", ranges,
      gaps.size() > kShown ? fmt::format(" and {} more gaps", gaps.size() - kShown) : "");
}

Result<std::vector<NumberedFile>> listNumberedFiles(const std::filesystem::path& folder,
                                                    std::string_view extension) {
  VOLUTE_ASSIGN(const auto files, filesOf(folder));
  std::vector<NumberedFile> numbered;
  for (const auto& file : files) {
    const bool hidden = file.filename().string().starts_with('.');
    if (hidden || file.extension() != extension)
      continue;
    if (const auto number = frameNumberOf(file))
      numbered.push_back({*number, file});
  }
  if (numbered.empty()) {
    return fail(ErrorCode::kNotFound, "{}: no numbered {} files in this folder", folder.string(),
                extension);
  }
  VOLUTE_TRY(checkOneSequence(folder, numbered));
  VOLUTE_TRY(sortByNumber(numbered));
  return numbered;
}

}  // namespace volute
