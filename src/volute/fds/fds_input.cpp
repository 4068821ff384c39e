// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_input.hpp"

#include <algorithm>
#include <cctype>

#include "volute/base/file_as_written.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/fds/text_lines.hpp"

namespace volute {

std::string capitals(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return out;
}

namespace {

constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 28;
constexpr int kMaxRepeats = 10000;
constexpr const char* kMassExtinction = "MASS_EXTINCTION_COEFFICIENT";

bool isWordEnd(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == '/' || c == '=' ||
         c == '!' || c == '\'' || c == '"' || c == '(';
}

class NamelistScanner {
 public:
  explicit NamelistScanner(std::string_view text) : text_(text) {}

  std::vector<FdsNamelist> all(const std::vector<std::string_view>& groups) {
    std::vector<FdsNamelist> found;
    while (at_ < text_.size()) {
      skipBlanks();
      if (peek() != '&') {
        nextLine();
        continue;
      }
      ++at_;
      FdsNamelist group{capitals(word()), line_, {}};
      read(group);
      if (std::ranges::find(groups, group.group) != groups.end())
        found.push_back(std::move(group));
      nextLine();
    }
    return found;
  }

 private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  void skipBlanks() {
    while (peek() == ' ' || peek() == '\t' || peek() == '\r') ++at_;
  }

  void nextLine() {
    at_ = std::min(text_.find('\n', at_), text_.size());
    if (at_ < text_.size()) {
      ++at_;
      ++line_;
    }
  }

  /// Past blanks, ends of lines and comments.
  void skipComments() {
    for (skipBlanks(); peek() == '\n' || peek() == '!'; skipBlanks()) nextLine();
  }

  /// Past blanks, commas, ends of lines and comments; false where the group ends.
  bool next() {
    for (;;) {
      skipBlanks();
      if (peek() == ',') {
        ++at_;
      } else if (peek() == '\n' || peek() == '!') {
        nextLine();
        skipBlanks();
        if (peek() == '&') {  // a slash is missing: the next group begins here
          at_ = at_ == 0 ? 0 : text_.rfind('\n', at_);
          --line_;
          return false;
        }
      } else {
        break;
      }
    }
    return at_ < text_.size() && peek() != '/';
  }

  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !isWordEnd(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::string quoted(char quote) {
    std::string out;
    for (++at_; at_ < text_.size() && text_[at_] != '\n'; ++at_) {
      if (text_[at_] != quote) {
        out += text_[at_];
      } else if (at_ + 1 < text_.size() && text_[at_ + 1] == quote) {
        out += text_[++at_];
      } else {
        ++at_;
        break;
      }
    }
    return std::string(trimmed(out));
  }

  /// "(2)" or "(1:3)" of a key.
  void skipIndices() {
    if (peek() == '(')
      at_ = std::min(text_.find_first_of(")\n", at_), text_.size());
    if (peek() == ')')
      ++at_;
  }

  void read(FdsNamelist& group) {
    std::vector<std::string>* values = nullptr;
    while (next()) {
      const char c = peek();
      if (c == '\'' || c == '"') {
        std::string text = quoted(c);
        if (values != nullptr)
          values->push_back(std::move(text));
        continue;
      }
      const std::string_view one = word();
      const std::size_t after = at_;
      const int line = line_;
      skipIndices();
      const bool indexed = at_ != after;
      skipComments();
      if (peek() == '=') {
        ++at_;
        values = &group.values[capitals(one)];
        if (!indexed)  // what is assigned again has the later value
          values->clear();
        continue;
      }
      at_ = after;
      line_ = line;
      if (one.empty()) {
        ++at_;  // what has no place here
        continue;
      }
      if (values != nullptr)
        take(one, *values);
    }
  }

  /// "3*0.5" stands three times.
  static void take(std::string_view word, std::vector<std::string>& values) {
    const std::size_t star = word.find('*');
    const auto count = star == word.npos ? std::nullopt : integerOf(word.substr(0, star));
    if (!count || *count < 1 || *count > kMaxRepeats)
      values.emplace_back(word);
    else
      values.insert(values.end(), static_cast<std::size_t>(*count),
                    std::string(word.substr(star + 1)));
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// With D instead of E, as Fortran takes it.
std::optional<double> fortranValue(std::string text) {
  for (char& c : text) c = c == 'd' || c == 'D' ? 'e' : c;
  return numberOf(text);
}

Status takeNumber(const FdsNamelist& group, const char* key, const std::filesystem::path& path,
                  std::optional<double>& into) {
  if (group.text(key).empty())
    return {};
  into = group.number(key);
  if (into && *into > 0)
    return {};
  return fail(ErrorCode::kInvalidData, "{}: line {}: {} is '{}'; expected a number above 0",
              path.string(), group.line, key, group.text(key).substr(0, 40));
}

Status takeExtinction(const FdsNamelist& group, const std::filesystem::path& path,
                      FdsInput& input) {
  const auto before = input.massExtinction;
  VOLUTE_TRY(takeNumber(group, kMassExtinction, path, input.massExtinction));
  if (before && before != input.massExtinction)
    input.otherExtinction = before;
  return {};
}

/// ".TRUE.", "T".
bool isTrue(const std::string& value) {
  return capitals(value).starts_with("T") || capitals(value).starts_with(".T");
}

FdsInput::Device deviceOf(const FdsNamelist& group) {
  FdsInput::Device device{group.text("QUANTITY"), group.text("SPEC_ID"), {}, false};
  for (const char* key : {"SPATIAL_STATISTIC", "STATISTICS", "TEMPORAL_STATISTIC"}) {
    const std::string statistic = capitals(group.text(key));
    if (!statistic.empty() && statistic != "TIME AVERAGE" && statistic != "INSTANT VALUE")
      device.statistic = statistic;
  }
  for (const char* key : {"RELATIVE", "DRY"}) {  // to the first value; without the water in the air
    if (isTrue(group.text(key)))
      device.statistic = key;
  }
  device.scaled = (group.number("CONVERSION_FACTOR").value_or(1) != 1 ||
                   group.number("CONVERSION_ADDEND").value_or(0) != 0) &&
                  group.text("UNITS").empty();
  return device;
}

/// What the text of a file says. `others`: names of more files, if these are to be read.
Status take(const std::string& text, const std::filesystem::path& path, FdsInput& input,
            std::map<std::string, std::string>& formulas, std::vector<std::string>* others) {
  for (const FdsNamelist& group : fdsNamelists(
           text, {"HEAD", "CATF", "TIME", "MISC", "REAC", "SPEC", "SURF", "DEVC", "MESH"})) {
    const std::string id = group.text("ID");
    if (group.group == "HEAD") {
      if (input.chid.empty())
        input.chid = group.text("CHID");
    } else if (group.group == "CATF") {
      const auto names = group.values.find("OTHER_FILES");
      if (others != nullptr && names != group.values.end())
        others->insert(others->end(), names->second.begin(), names->second.end());
    } else if (group.group == "TIME") {
      input.begin = group.values.contains("T_BEGIN") ? group.number("T_BEGIN") : input.begin;
    } else if (group.group == "MISC") {
      VOLUTE_TRY(takeNumber(group, "VISIBILITY_FACTOR", path, input.visibilityFactor));
      VOLUTE_TRY(takeNumber(group, "MAXIMUM_VISIBILITY", path, input.maximumVisibility));
      input.ambient = group.values.contains("TMPA") ? group.number("TMPA") : input.ambient;
    } else if (group.group == "REAC") {
      const std::string fuel = group.text("FUEL").empty() ? id : group.text("FUEL");
      input.reactions.push_back(
          {fuel, group.number("SOOT_YIELD").value_or(0), group.number("CO_YIELD").value_or(0)});
      VOLUTE_TRY(takeExtinction(group, path, input));
    } else if (group.group == "SPEC") {
      if (!group.text("FORMULA").empty())
        formulas[id] = group.text("FORMULA");
      if (capitals(id) == "SOOT")
        VOLUTE_TRY(takeExtinction(group, path, input));
    } else if (group.group == "SURF") {
      const bool burns =
          group.number("HRRPUA").value_or(0) > 0 || group.number("MLRPUA").value_or(0) > 0;
      // What has to be ignited may never be: its flames tell.
      if (burns && !group.values.contains("IGNITION_TEMPERATURE"))
        input.burning.insert(id);
    } else if (group.group == "MESH") {
      if (const auto offset = group.number("EVAC_Z_OFFSET"))
        input.evacuationOffsets[id] = *offset;
    } else if (!id.empty()) {
      input.devices.emplace(id, deviceOf(group));
    }
  }
  return {};
}

}  // namespace

std::string FdsNamelist::text(const std::string& key) const {
  const auto found = values.find(key);
  return found == values.end() || found->second.empty() ? "" : found->second.front();
}

std::optional<double> FdsNamelist::number(const std::string& key) const {
  return fortranValue(text(key));
}

std::vector<FdsNamelist> fdsNamelists(std::string_view text,
                                      const std::vector<std::string_view>& groups) {
  return NamelistScanner(text).all(groups);
}

Result<FdsInput> FdsInput::read(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto bytes, readText(path, kLargestFile));
  FdsInput input;
  input.path = path;
  std::map<std::string, std::string> formulas;
  std::vector<std::string> more;
  VOLUTE_TRY(take(asUtf8(bytes), path, input, formulas, &more));
  for (const std::string& name : more) {  // FDS reads what these name as if it stood here
    const std::filesystem::path file = FilesAsWritten().find(path.parent_path(), name);
    const auto other = readText(file, kLargestFile);
    if (!other) {
      return fail(ErrorCode::kInvalidData,
                  "{}: names another input file (CATF), which cannot be read: {}", path.string(),
                  other.error().message);
    }
    VOLUTE_TRY(take(asUtf8(*other), file, input, formulas, nullptr));
  }
  for (auto& [id, device] : input.devices) {
    const auto formula = formulas.find(device.species);
    if (formula != formulas.end())
      device.species = formula->second;
  }
  return input;
}

}  // namespace volute
