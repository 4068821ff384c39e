// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_keys.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_set>
#include <vector>

#include "volute/base/printable.hpp"

namespace volute {
namespace {

/// Finds members that are in their object twice, of which parsers keep the last one. Of text that
/// is no JSON it may find nothing.
class KeyScan {
 public:
  explicit KeyScan(std::string_view text) : text_(text) {}

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
    const std::string quoted(text_.substr(begin, end - begin));
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

  std::string_view text_;
  std::vector<Level> open_;
};

}  // namespace

Status checkJsonKeys(std::string_view text, const std::string& file, std::size_t mostMembers) {
  return KeyScan(text).run(file, mostMembers);
}

}  // namespace volute
