// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_file.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_set>
#include <vector>

#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/json_depth.hpp"

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

/// Finds members that are in their object twice, of which parsers keep the last one. Of text that
/// is no JSON it may find nothing.
class KeyScan {
 public:
  explicit KeyScan(const std::string& text) : text_(text) {}

  Status run(const std::string& file, std::size_t mostMembers) {
    for (std::size_t at = 0; at < text_.size(); ++at) {
      const char c = text_[at];
      if (c == '"') {
        const std::size_t begin = at;
        for (++at; at < text_.size() && text_[at] != '"'; ++at) at += text_[at] == '\\' ? 1 : 0;
        if (!open_.empty() && open_.back().isKeyNext)
          VOLUTE_TRY(add(begin, std::min(at + 1, text_.size()), file, mostMembers));
      } else if (c == '{' || c == '[') {
        open_.emplace_back().isKeyNext = c == '{';
        open_.back().isObject = c == '{';
      } else if ((c == '}' || c == ']') && !open_.empty()) {
        open_.pop_back();
      } else if (c == ',' && !open_.empty()) {
        open_.back().isKeyNext = open_.back().isObject;
        ++open_.back().index;
      }
    }
    return {};
  }

 private:
  struct Level {
    bool isObject = false, isKeyNext = false;
    std::size_t index = 0;
    std::string key{};
    std::unordered_set<std::string> keys{};
  };

  std::string keyAt(std::size_t begin, std::size_t end) const {
    const std::string quoted = text_.substr(begin, end - begin);
    if (quoted.find('\\') != quoted.npos) {
      const auto parsed = nlohmann::json::parse(quoted, nullptr, false);
      if (parsed.is_string())
        return parsed.get<std::string>();
    }
    return quoted.size() < 2 ? std::string() : quoted.substr(1, quoted.size() - 2);
  }

  Status add(std::size_t begin, std::size_t end, const std::string& file, std::size_t mostMembers) {
    Level& level = open_.back();
    level.isKeyNext = false;
    level.key = keyAt(begin, end);
    const auto line = [&] {
      return 1 +
             std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(begin), '\n');
    };
    if (!level.keys.insert(level.key).second) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: '{}' is there twice{}; expected it once: remove one of them", file,
                  line(), printable(level.key.substr(0, 60)), placeOf());
    }
    if (level.keys.size() > mostMembers) {
      return fail(ErrorCode::kTooLarge, "{}: line {}: an object of more than {} members{}", file,
                  line(), mostMembers, placeOf());
    }
    return {};
  }

  /// " in media[0]/time", of the object that is open.
  std::string placeOf() const {
    std::string path;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      if (open_[i].isObject)
        path += (path.empty() ? "" : "/") + printable(open_[i].key.substr(0, 60));
      else
        path += fmt::format("[{}]", open_[i].index);
    }
    return path.empty() ? "" : " in " + path;
  }

  const std::string& text_;
  std::vector<Level> open_;
};

}  // namespace

Result<nlohmann::json> readJson(const std::filesystem::path& path, std::size_t mostMembers) {
  constexpr std::uint64_t kMaxBytes = 16 << 20;
  const std::string file = path.string();
  VOLUTE_ASSIGN(const auto text, readText(path, kMaxBytes));
  if (text.empty())
    return fail(ErrorCode::kInvalidData, "{}: is empty; expected JSON", file);
  VOLUTE_TRY(checkJsonDepth(text, file));
  VOLUTE_TRY(KeyScan(text).run(file, mostMembers));
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
