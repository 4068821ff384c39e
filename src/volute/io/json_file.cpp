// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_file.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>

#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/json_depth.hpp"
#include "volute/io/json_keys.hpp"

namespace volute {

namespace {

/// The letters around the byte before `end`.
std::string wordAt(const std::string& text, std::size_t end) {
  const auto letter = [&](std::size_t i) {
    return std::isalpha(static_cast<unsigned char>(text[i])) != 0;
  };
  std::size_t first = end, last = end;
  while (first > 0 && letter(first - 1)) --first;
  while (last < text.size() && letter(last)) ++last;
  return text.substr(first, last - first);
}

}  // namespace

Result<nlohmann::json> readJson(const std::filesystem::path& path, std::size_t mostMembers) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  const std::string file = path.string();
  VOLUTE_ASSIGN(const auto text, readText(path, kMaxBytes));
  if (text.empty())
    return fail(ErrorCode::kInvalidData, "{}: is empty; expected JSON", file);
  if (const std::size_t end = text.find('\0'); end != text.npos) {  // where the parser would end
    return fail(ErrorCode::kInvalidData,
                "{}: byte {} is 0; expected text: the file is damaged, or of another encoding",
                file, end + 1);
  }
  VOLUTE_TRY(checkJsonDepth(text, file));
  VOLUTE_TRY(checkJsonKeys(text, file, mostMembers));
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    const std::string word = wordAt(text, end);
    const bool number = word == "NaN" || word == "Infinity";
    return fail(ErrorCode::kInvalidData, "{}: line {} is no valid JSON (byte {}){}", file, line,
                error.byte,
                number ? fmt::format(": it has no {}; expected a finite number", word) : "");
  } catch (const nlohmann::json::exception& error) {  // a number beyond double: its text is quoted
    const std::string what = error.what();
    const std::size_t quote = what.find('\'');
    const std::string number =
        quote == what.npos ? what : what.substr(quote + 1, what.rfind('\'') - quote - 1);
    const auto at = static_cast<std::ptrdiff_t>(std::min(text.find(number), text.size()));
    return fail(ErrorCode::kInvalidData,
                "{}: line {}: {} is beyond the numbers of 64 bits; expected a finite number", file,
                1 + std::count(text.begin(), text.begin() + at, '\n'),
                printable(number.substr(0, 60)));
  }
}

}  // namespace volute
