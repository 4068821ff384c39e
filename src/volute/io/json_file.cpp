// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_file.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>

#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"

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

/// @param keep  whether a value becomes part of the result
Result<nlohmann::json> read(const std::filesystem::path& path, const JsonLimits& limits,
                            const nlohmann::json::parser_callback_t& keep) {
  constexpr std::uint64_t kMaxBytes = 128 << 20;
  const std::string file = path.string();
  VOLUTE_ASSIGN(const auto text, readText(path, std::min(kMaxBytes, limits.memory)));
  if (text.empty())
    return fail(ErrorCode::kInvalidData, "{}: is empty; expected JSON", file);
  if (const std::size_t end = text.find('\0'); end != text.npos) {  // where the parser would end
    return fail(ErrorCode::kInvalidData,
                "{}: byte {} is 0; expected text: the file is damaged, or of another encoding",
                file, end + 1);
  }
  VOLUTE_TRY(checkJson(text, file, limits));
  try {
    return nlohmann::json::parse(text, keep);
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

}  // namespace

Result<nlohmann::json> readJson(const std::filesystem::path& path, const JsonLimits& limits) {
  return read(path, limits, nullptr);
}

Result<nlohmann::json> readOutermostJson(const std::filesystem::path& path) {
  using Event = nlohmann::json::parse_event_t;
  nlohmann::json members = nlohmann::json::object();
  std::string name;
  const auto keep = [&](int depth, Event event, nlohmann::json& value) {
    if (depth == 1 && event == Event::key)
      members[name = value.get<std::string>()] = nullptr;
    else if (depth == 1 && event == Event::value && !name.empty())
      members[name] = value;
    return depth == 0;
  };
  VOLUTE_ASSIGN(auto outermost, read(path, {}, keep));
  return outermost.is_object() ? std::move(members) : std::move(outermost);
}

Status forEachJsonText(const std::filesystem::path& path,
                       const std::function<void(const std::string&)>& function) {
  using Event = nlohmann::json::parse_event_t;
  const auto keep = [&](int, Event event, nlohmann::json& value) {
    if (event == Event::value && value.is_string())
      function(value.get_ref<const std::string&>());
    return event == Event::object_start || event == Event::array_start;
  };
  VOLUTE_TRY(read(path, {}, keep));
  return {};
}

}  // namespace volute
