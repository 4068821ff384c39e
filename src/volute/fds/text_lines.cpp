// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/text_lines.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/number_word.hpp"

namespace volute {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;

bool isSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v' || c == '\0';
}

template <class T>
std::optional<T> parsed(std::string_view word) {
  T value{};
  return readNumber(word, value) ? std::optional(value) : std::nullopt;
}

}  // namespace

Result<TextLines> TextLines::open(const std::filesystem::path& path, std::size_t longestLine) {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  return TextLines(std::move(file), longestLine);
}

/// Appends the next bytes of the file; false at its end.
Result<bool> TextLines::fill() {
  if (offset_ >= file_.size())
    return false;
  buffer_.erase(0, place_);
  place_ = 0;
  const std::size_t count = std::min<std::uint64_t>(kChunk, file_.size() - offset_);
  const std::size_t before = buffer_.size();
  buffer_.resize(before + count);
  VOLUTE_TRY(file_.read(offset_, std::as_writable_bytes(std::span(buffer_).subspan(before))));
  offset_ += count;
  return true;
}

Result<std::optional<std::string>> TextLines::next() {
  std::size_t end = buffer_.find('\n', place_);
  while (end == std::string::npos) {
    if (buffer_.size() - place_ > longestLine_) {
      return fail(ErrorCode::kInvalidData, "{}: line {} is longer than {} bytes: not a text file",
                  file_.path().string(), lineNumber_ + 1, longestLine_);
    }
    VOLUTE_ASSIGN(const bool more, fill());
    if (!more) {
      endedWithinLine_ = !trimmed(std::string_view(buffer_).substr(place_)).empty();
      place_ = buffer_.size();
      return std::nullopt;
    }
    end = buffer_.find('\n', place_);
  }
  std::string line = buffer_.substr(place_, end - place_);
  if (line.ends_with('\r'))
    line.pop_back();
  place_ = end + 1;
  ++lineNumber_;
  return line;
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> out;
  std::size_t place = 0;
  while (place < text.size()) {
    while (place < text.size() && isSpace(text[place])) ++place;
    const std::size_t begin = place;
    while (place < text.size() && !isSpace(text[place])) ++place;
    if (place > begin)
      out.push_back(text.substr(begin, place - begin));
  }
  return out;
}

std::optional<double> numberOf(std::string_view word) {
  const auto value = parsed<double>(word);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<int> integerOf(std::string_view word) {
  return parsed<int>(word);
}

}  // namespace volute
