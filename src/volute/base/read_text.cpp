// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/read_text.hpp"

#include <string_view>

#include "volute/base/input_file.hpp"

namespace volute {

static std::string sizeOf(std::uint64_t bytes) {
  constexpr std::uint64_t kMebi = 1 << 20;
  return bytes < kMebi ? fmt::format("{} bytes", bytes)
                       : fmt::format("{:.4g} MiB", static_cast<double>(bytes) / kMebi);
}

Result<std::string> readText(const std::filesystem::path& path, std::uint64_t most) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  if (file.size() > most) {
    return fail(ErrorCode::kTooLarge, "{}: {} of text are too many; expected at most {}",
                path.string(), sizeOf(file.size()), sizeOf(most));
  }
  std::string text(file.size(), '\0');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text))));
  if (text.starts_with("\xEF\xBB\xBF"))
    text.erase(0, 3);
  // A byte order mark, then a letter in two bytes.
  const auto wide = [&](std::string_view mark, std::size_t zero, std::size_t letter) {
    return text.size() >= 4 && text.starts_with(mark) && text[zero] == 0 && text[letter] != 0;
  };
  if (wide("\xFF\xFE", 3, 2) || wide("\xFE\xFF", 2, 3)) {
    return fail(ErrorCode::kInvalidData, "{}: is text in UTF-16; expected UTF-8: save it so",
                path.string());
  }
  return text;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpaces(" \t\r\n\f\v\0", 7);
  const std::size_t begin = std::min(text.find_first_not_of(kSpaces), text.size());
  return text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

}  // namespace volute
