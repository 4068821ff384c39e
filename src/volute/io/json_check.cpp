// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_check.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_set>
#include <vector>

#include "volute/base/printable.hpp"

namespace volute {
namespace {

/// What nlohmann::json takes on a machine of 64 bits: a value in a list that grows by doubling, a
/// list or an object, a member's node with its name, and a text on the heap.
constexpr std::uint64_t kValue = 32, kContainer = 64, kMember = 112, kText = 48;

/// Goes through the text once, by brackets, quotes and commas.
class JsonScan {
 public:
  JsonScan(std::string_view text, const std::string& file, const JsonLimits& limits)
      : text_(text), file_(file), limits_(limits) {}

  Status run() {
    for (std::size_t at = 0; at < text_.size(); ++at) {
      const char c = text_[at];
      if (c == '"') {
        const std::size_t begin = at;
        for (++at; at < text_.size() && text_[at] != '"'; ++at) at += text_[at] == '\\' ? 1 : 0;
        if (!open_.empty() && open_.back().isKeyNext)
          VOLUTE_TRY(addKey(begin, std::min(at + 1, text_.size())));
        else
          bytes_ += kText + at - begin;
      } else if (c == '{' || c == '[') {
        VOLUTE_TRY(open(c == '{', at));
      } else if ((c == '}' || c == ']') && !open_.empty()) {
        open_.pop_back();
      } else if (c == ',' && !open_.empty()) {
        open_.back().isKeyNext = open_.back().isObject;
        ++open_.back().index;
        bytes_ += kValue;
      }
    }
    if (bytes_ <= limits_.memory)
      return {};
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: its {} MB of JSON need about {} MiB, more than the {} MiB allowed", file_,
                text_.size() / 1'000'000, bytes_ >> 20, limits_.memory >> 20);
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

  Status open(bool isObject, std::size_t at) {
    if (open_.size() == kDeepestJson) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: lists and objects more than {} deep within each other (byte {}); "
                  "expected at most {}",
                  file_, lineOf(at), kDeepestJson, at, kDeepestJson);
    }
    Level& level = open_.emplace_back();
    level.isObject = level.isKeyNext = isObject;
    bytes_ += kContainer;
    return {};
  }

  std::ptrdiff_t lineOf(std::size_t at) const {
    return 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  }

  Status addKey(std::size_t begin, std::size_t end) {
    Level& level = open_.back();
    level.isKeyNext = false;
    bytes_ += kMember;
    level.key = keyAt(begin, end);
    if (!level.keys.insert(level.key).second) {
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: '{}' is there twice{}; expected it once: remove one of them", file_,
                  lineOf(begin), printable(level.key.substr(0, 60)), placeOf());
    }
    if (level.keys.size() > limits_.members) {
      return fail(ErrorCode::kTooLarge, "{}: line {}: an object of more than {} members{}", file_,
                  lineOf(begin), limits_.members, placeOf());
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
  const std::string& file_;
  const JsonLimits& limits_;
  std::vector<Level> open_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Status checkJson(std::string_view text, const std::string& file, const JsonLimits& limits) {
  return JsonScan(text, file, limits).run();
}

}  // namespace volute
