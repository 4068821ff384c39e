// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/opencv_storage.hpp"

#include <fmt/format.h>
#include <yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "volute/base/file_name.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/json_check.hpp"

namespace volute {
namespace {

/// What a matrix is stored as.
struct Parts {
  std::optional<double> rows, columns;
  int channels = 1;
  bool whole = false;  ///< its numbers are integers
  std::optional<std::vector<double>> data;

  /// OpenCV's "dt": channels before the letter of the type, e.g. "2f".
  void take(std::string_view type) {
    const std::size_t first = type.find_first_of("0123456789");
    channels = first == std::string_view::npos ? 1 : std::max(1, std::atoi(type.data() + first));
    whole = type.find_first_of("ucwsi") != std::string_view::npos;
  }
};

/// Nothing where the parts do not fit together. An empty matrix is one.
std::optional<OpenCvMatrix> matrixOf(Parts parts) {
  const auto isCount = [](const std::optional<double>& number) {
    return number && *number >= 0 && *number <= std::numeric_limits<int>::max() &&
           *number == static_cast<int>(*number);
  };
  if (!isCount(parts.rows) || !isCount(parts.columns) || !parts.data ||
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): isCount() asks
      *parts.rows * *parts.columns * parts.channels != static_cast<double>(parts.data->size()))
    return std::nullopt;
  const auto isFraction = [](double value) { return value != std::floor(value); };
  if (parts.whole && std::ranges::any_of(*parts.data, isFraction))
    return std::nullopt;
  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): isCount() asked
  return OpenCvMatrix{static_cast<int>(*parts.rows), static_cast<int>(*parts.columns),
                      std::move(*parts.data)};
}

tl::unexpected<Error> notWhole(const std::string& where, std::string_view name) {
  return fail(ErrorCode::kInvalidData,
              "{}: {} is no whole matrix; expected rows, cols and data of its type (dt): the file "
              "is cut off or damaged",
              where, name);
}

/// What stands between <name ...> and </name>, from `at` on, which goes behind it; nothing at the
/// end of the text.
struct XmlElement {
  std::string_view name, content;
};

Result<std::optional<XmlElement>> nextElement(std::string_view text, std::size_t& at,
                                              const std::string& file) {
  while ((at = text.find('<', at)) != std::string_view::npos) {
    const bool comment = text.substr(at).starts_with("<!--");
    const std::size_t end = text.find(comment ? "-->" : ">", at);
    if (end == std::string_view::npos)
      return fail(ErrorCode::kInvalidData, "{}: a tag is cut off at its end", file);
    const std::string_view tag = text.substr(at + 1, end - at - 1);
    at = end + (comment ? 3 : 1);
    if (comment || tag.starts_with('?') || tag.starts_with('!') || tag.ends_with('/'))
      continue;
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n"));
    const std::string close = fmt::format("</{}>", name);
    const std::size_t last = text.find(close, at);
    if (name.empty() || name.starts_with('/') || last == std::string_view::npos)
      return fail(ErrorCode::kInvalidData, "{}: <{}> has no end: the file is cut off or damaged",
                  file, name);
    const XmlElement element{name, text.substr(at, last - at)};
    at = last + close.size();
    return element;
  }
  return std::nullopt;
}

/// All numbers of a text; nothing where there is something else.
std::optional<std::vector<double>> numbersOf(std::string_view text) {
  std::vector<double> numbers;
  const std::string copy(text);
  const char* at = copy.c_str();
  for (char* after = nullptr;; at = after) {
    const double number = std::strtod(at, &after);
    if (after == at)
      break;
    numbers.push_back(number);
  }
  if (std::string_view(at).find_first_not_of(" \t\r\n") != std::string_view::npos)
    return std::nullopt;
  return numbers;
}

/// <opencv_storage> of matrices with <rows>, <cols> and <data>, and of numbers.
Result<OpenCvStorage> readXml(std::string_view text, const std::string& file,
                              bool (*isNeeded)(std::string_view)) {
  std::size_t at = 0;
  VOLUTE_ASSIGN(const auto root, nextElement(text, at, file));
  if (!root || root->name != "opencv_storage")
    return fail(ErrorCode::kInvalidData, "{}: expected OpenCV's <opencv_storage>", file);
  OpenCvStorage storage;
  at = 0;
  while (true) {
    VOLUTE_ASSIGN(const auto element, nextElement(root->content, at, file));
    if (!element)
      return storage;
    const std::string name(element->name);
    std::optional<OpenCvMatrix> matrix;
    if (auto number = numbersOf(element->content)) {
      if (number->size() > 1)
        storage.others.push_back(name);
      if (number->size() != 1)
        continue;  // lists, or nothing
      matrix = {1, 1, std::move(*number)};
    } else {
      Parts parts;
      std::size_t inside = 0;
      while (element->content.find('<', inside) != std::string_view::npos) {
        VOLUTE_ASSIGN(const auto part, nextElement(element->content, inside, file));
        if (!part)
          break;
        if (part->name == "data")
          parts.data = numbersOf(part->content);
        if (part->name == "dt")
          parts.take(std::string(part->content));
        if (part->name != "rows" && part->name != "cols")
          continue;
        if (const auto count = numbersOf(part->content); count && count->size() == 1)
          (part->name == "rows" ? parts.rows : parts.columns) = count->front();
      }
      matrix = matrixOf(std::move(parts));
      if (!matrix && !isNeeded(name)) {  // words, or other structures
        storage.others.push_back(name);
        continue;
      }
      if (!matrix)
        return notWhole(file, name);
    }
    if (!storage.add(name, std::move(*matrix)))
      return fail(ErrorCode::kInvalidData, "{}: {} is there twice; expected it once", file, name);
  }
}

/// Reads YAML, and JSON, which is YAML too, by libyaml's events: nothing is built but the matrices.
class YamlReader {
 public:
  YamlReader(std::string_view text, std::string file, bool (*isNeeded)(std::string_view))
      : text_(text), file_(std::move(file)), isNeeded_(isNeeded) {
    isReady_ = yaml_parser_initialize(&parser_) != 0;
    if (!isReady_)
      return;
    yaml_parser_set_encoding(&parser_, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()),
                                 text.size());
  }

  YamlReader(const YamlReader&) = delete;
  YamlReader& operator=(const YamlReader&) = delete;

  ~YamlReader() {
    yaml_event_delete(&event_);
    if (isReady_)
      yaml_parser_delete(&parser_);
  }

  /// All documents: OpenCV appends further ones, and looks for a name in each.
  Result<OpenCvStorage> read() {
    do {
      VOLUTE_TRY(next());
      if (event_.type == YAML_DOCUMENT_START_EVENT)
        VOLUTE_TRY(readDocument());
    } while (event_.type != YAML_STREAM_END_EVENT);
    return std::move(storage_);
  }

 private:
  enum class Kind { kOther, kList, kMatrix };

  /// Numbers of a list, or a matrix or number.
  struct Value {
    Kind kind = Kind::kOther;
    OpenCvMatrix content;
    bool isTagged = false;  // as a matrix
  };

  std::string where() const {
    return fmt::format("{}: line {}", file_, event_.start_mark.line + 1);
  }

  Status next() {
    yaml_event_delete(&event_);
    event_ = {};
    if (isReady_ && yaml_parser_parse(&parser_, &event_) != 0)
      return {};
    event_ = {};
    if (!isReady_ || parser_.error == YAML_MEMORY_ERROR)
      return fail(ErrorCode::kTooLarge, "{}: there is not enough memory to read it", file_);
    std::size_t line = parser_.problem_mark.line, column = parser_.problem_mark.column;
    if (parser_.error == YAML_READER_ERROR) {  // a byte, not a mark
      const auto before = text_.substr(0, parser_.problem_offset);
      line = static_cast<std::size_t>(std::ranges::count(before, '\n'));
      column = before.size() - (before.rfind('\n') + 1);
    }
    return fail(ErrorCode::kInvalidData, "{}: line {}: no valid YAML or JSON: {} at column {}",
                file_, line + 1, parser_.problem, column + 1);
  }

  Status readDocument() {
    VOLUTE_TRY(next());
    const bool isEmpty = event_.type == YAML_SCALAR_EVENT && event_.data.scalar.length == 0;
    if (event_.type != YAML_MAPPING_START_EVENT && !(isEmpty && storage_.begin() != storage_.end()))
      return fail(ErrorCode::kInvalidData,
                  "{}: holds no named matrices; expected OpenCV's FileStorage", file_);
    while (event_.type != YAML_DOCUMENT_END_EVENT) {
      VOLUTE_TRY(next());
      if (event_.type != YAML_MAPPING_END_EVENT && event_.type != YAML_DOCUMENT_END_EVENT)
        VOLUTE_TRY(readMember());
    }
    anchors_.clear();
    return {};
  }

  Status readMember() {
    const std::string place = where();
    const std::string name = scalar();
    VOLUTE_TRY(readValue(1));  // a name may be a structure, which is none of ours
    VOLUTE_TRY(next());
    VOLUTE_ASSIGN(auto value, readValue(1));
    const bool isMatrix = value.kind == Kind::kMatrix;
    if (!isMatrix && (value.isTagged || isNeeded_(name)))
      return notWhole(place, name);
    if (!isMatrix && !name.empty())
      storage_.others.push_back(name);
    if (isMatrix && !storage_.add(name, std::move(value.content)))
      return fail(ErrorCode::kInvalidData, "{}: {} is there twice; expected it once", place, name);
    return {};
  }

  template <class Scalar>
  static std::string_view text(const Scalar& scalar) {
    return {reinterpret_cast<const char*>(scalar.value), scalar.length};
  }

  std::string scalar() const {
    return event_.type == YAML_SCALAR_EVENT ? std::string(text(event_.data.scalar)) : "";
  }

  /// Begins at the value's first event and ends at its last.
  Result<Value> readValue(int depth) {
    if (depth > kDeepestJson)
      return fail(ErrorCode::kInvalidData,
                  "{}: lists and matrices more than {} deep within each other", where(),
                  kDeepestJson);
    const auto named = [](const yaml_char_t* anchor) {
      return anchor ? std::string(reinterpret_cast<const char*>(anchor)) : std::string();
    };
    Value value;
    std::string anchor;
    if (event_.type == YAML_ALIAS_EVENT) {
      const std::string name = named(event_.data.alias.anchor);
      const auto found = anchors_.find(name);
      if (found == anchors_.end())
        return fail(ErrorCode::kInvalidData, "{}: no valid YAML: there is no &{} before *{}",
                    where(), name, name);
      VOLUTE_TRY(count(found->second.content.values.size()));
      return found->second;
    }
    if (event_.type == YAML_SCALAR_EVENT) {
      anchor = named(event_.data.scalar.anchor);
      if (const auto number = numberOf(text(event_.data.scalar))) {
        VOLUTE_TRY(count(1));
        value = {Kind::kMatrix, {1, 1, {*number}}};
      }
    } else if (event_.type == YAML_SEQUENCE_START_EVENT) {
      anchor = named(event_.data.sequence_start.anchor);
      VOLUTE_ASSIGN(value, readList(depth));
    } else {
      anchor = named(event_.data.mapping_start.anchor);
      const std::string tag = named(event_.data.mapping_start.tag);
      VOLUTE_ASSIGN(value, readMatrix(depth));
      value.isTagged = tag.ends_with("opencv-matrix");
    }
    if (!anchor.empty())
      anchors_[anchor] = value;
    return value;
  }

  Result<Value> readList(int depth) {
    Value list{Kind::kList, {}};
    while (true) {
      VOLUTE_TRY(next());
      if (event_.type == YAML_SEQUENCE_END_EVENT)
        return list;
      std::optional<double> number;
      if (event_.type == YAML_SCALAR_EVENT && !event_.data.scalar.anchor) {
        number = numberOf(text(event_.data.scalar));
        VOLUTE_TRY(count(1));
      } else {
        VOLUTE_ASSIGN(const auto item, readValue(depth + 1));
        if (item.kind == Kind::kMatrix && item.content.values.size() == 1)
          number = item.content.values.front();
      }
      if (number)
        list.content.values.push_back(*number);
      else
        list.kind = Kind::kOther;
    }
  }

  Result<Value> readMatrix(int depth) {
    Parts parts;
    std::array<bool, 4> seen{};
    while (true) {
      VOLUTE_TRY(next());
      if (event_.type == YAML_MAPPING_END_EVENT)
        break;
      const std::string place = where(), key = scalar();
      VOLUTE_TRY(readValue(depth + 1));
      VOLUTE_TRY(next());
      constexpr std::array<std::string_view, 4> kKeys{"rows", "cols", "dt", "data"};
      const auto which = static_cast<std::size_t>(std::ranges::find(kKeys, key) - kKeys.begin());
      if (which < kKeys.size() && std::exchange(seen[which], true))
        return fail(ErrorCode::kInvalidData,
                    "{}: {} is there twice in one matrix; expected it once", place, key);
      if (key == "dt")
        parts.take(scalar());
      VOLUTE_ASSIGN(auto value, readValue(depth + 1));
      if (key == "data")
        parts.data = value.kind == Kind::kList ? std::optional(std::move(value.content.values))
                                               : std::nullopt;
      if ((key == "rows" || key == "cols") && value.kind == Kind::kMatrix &&
          value.content.values.size() == 1)
        (key == "rows" ? parts.rows : parts.columns) = value.content.values.front();
    }
    auto matrix = matrixOf(std::move(parts));
    return matrix ? Value{Kind::kMatrix, std::move(*matrix)} : Value{};
  }

  /// As from_chars reads it, or YAML's ".inf" and ".nan".
  static std::optional<double> numberOf(std::string_view word) {
    double number = 0;
    if (readNumber(word, number))
      return number;
    const bool isNegative = word.starts_with('-');
    word.remove_prefix(isNegative || word.starts_with('+') ? 1 : 0);
    if (!word.starts_with('.') || !readNumber(word.substr(1), number) || std::isfinite(number))
      return std::nullopt;
    return isNegative ? -number : number;
  }

  Status count(std::size_t values) {
    values_ += values;
    if (values_ <= text_.size())
      return {};
    return fail(ErrorCode::kTooLarge,
                "{}: its matrices repeat others (as aliases, *name) more often than the file has "
                "characters; expected each matrix written out",
                where());
  }

  std::string_view text_;
  std::string file_;
  bool (*isNeeded_)(std::string_view);
  bool isReady_ = false;
  yaml_parser_t parser_{};
  yaml_event_t event_{};
  std::unordered_map<std::string, Value> anchors_;
  std::size_t values_ = 0;
  OpenCvStorage storage_;
};

}  // namespace

Result<OpenCvStorage> readOpenCvStorage(const std::filesystem::path& file,
                                        bool (*isNeeded)(std::string_view)) {
  constexpr std::uint64_t kMaxBytes = 128 << 20;
  VOLUTE_ASSIGN(std::string text, readText(file, kMaxBytes));
  if (extensionOf(file) == ".xml")
    return readXml(text, file.string(), isNeeded);
  if (extensionOf(file) == ".json")
    VOLUTE_TRY(checkJson(text, file.string()));
  // OpenCV's first line is no YAML directive as the standard has it, and old versions put no "---"
  // after it.
  if (text.starts_with("%YAML"))
    text.replace(0, text.find('\n'), "# ");
  return YamlReader(text, file.string(), isNeeded).read();
}

}  // namespace volute
