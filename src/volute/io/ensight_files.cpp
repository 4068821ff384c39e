// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/ensight_files.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/read_text.hpp"

namespace volute {
namespace {

/// A time set of the case: when its steps are and what number the files of each have.
struct TimeSet {
  std::vector<double> values;
  std::vector<int> numbers;
  int start = 0, increment = 1;
  double steps = 0;        ///< as the case says
  bool elsewhere = false;  ///< the numbers are in a file of their own

  /// The number in the name of the file shown at a time: of the last step that is not later.
  int numberAt(double time) const {
    const auto later = std::ranges::upper_bound(values, time);
    const auto step = std::max<std::ptrdiff_t>(later - values.begin() - 1, 0);
    return static_cast<std::size_t>(step) < numbers.size()
               ? numbers[static_cast<std::size_t>(step)]
               : static_cast<int>(start + std::int64_t{increment} * step);
  }
};

/// A file that a case names; `*` stand for the number of a step.
struct NamedFile {
  std::string pattern;
  int timeSet = 0;      ///< 0: none
  bool ofSets = false;  ///< several steps in a file
};

struct Case {
  bool gold = false;
  NamedFile geometry;
  std::map<std::string, NamedFile> scalars;
  std::map<int, TimeSet> times;
};

std::vector<std::string> wordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::optional<double> numberOf(const std::string& word) {
  double value = 0;
  return readNumber(word, value) ? std::optional(value) : std::nullopt;
}

/// A whole number of a line; nothing where an int does not hold it.
std::optional<int> wholeOf(const std::string& word) {
  const auto value = numberOf(word);
  constexpr double kMax = 1e9;
  if (!value || !(std::abs(*value) <= kMax))
    return std::nullopt;
  return static_cast<int>(*value);
}

/// The time set and file set before the names of a line.
NamedFile namedFile(const std::vector<std::string>& words, std::size_t names) {
  NamedFile file;
  if (words.size() > names) {
    file.timeSet = wholeOf(words[0]).value_or(0);
    file.ofSets = words.size() > names + 1;
  }
  file.pattern = words.back();
  std::erase(file.pattern, '"');
  return file;
}

/// A line without a colon or a number begins a part of the case, or is a remark. VTK's reader looks
/// for a word it does not find for a minute.
bool isSection(const std::vector<std::string>& words) {
  static constexpr std::string_view kSections[] = {
      "FORMAT", "GEOMETRY", "VARIABLE",           "TIME",
      "FILE",   "MATERIAL", "BLOCK_CONTINUATION", "SCRIPTS"};
  return words[0][0] == '#' || std::ranges::find(kSections, words[0]) != std::end(kSections);
}

Result<Case> readCase(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const std::string text, readText(path));
  std::istringstream stream(text);
  Case out;
  TimeSet* set = nullptr;
  std::vector<std::string> numbersAfter;
  std::string key;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const auto colon = line.find(':');
    std::string rest = line;
    if (colon != std::string::npos) {
      const auto before = wordsOf(line.substr(0, colon));
      key.clear();
      for (const std::string& word : before) key += (key.empty() ? "" : " ") + word;
      rest = line.substr(colon + 1);
    } else if (const auto words = wordsOf(line); words.empty() || !numberOf(words[0])) {
      if (!words.empty() && !isSection(words))
        return fail(ErrorCode::kInvalidData,
                    "{}: line {}: '{}' begins no part of a case; expected FORMAT, GEOMETRY, "
                    "VARIABLE, TIME or another that EnSight knows",
                    path.string(), number, words[0]);
      key.clear();
    }
    auto words = wordsOf(rest);
    if (words.empty())
      continue;
    if (key == "type") {
      out.gold = words.size() > 1 && words[0] == "ensight" && words[1] == "gold";
    } else if (key == "model") {
      while (words.size() > 1 && !numberOf(words.back()) && words.back() == "change_coords_only")
        words.pop_back();
      out.geometry = namedFile(words, 1);
    } else if ((key == "scalar per node" || key == "scalar per element") && words.size() > 1) {
      out.scalars[words[words.size() - 2]] = namedFile(words, 2);
    } else if (key == "time set") {
      set = &out.times[wholeOf(words[0]).value_or(0)];
    } else if (set && key == "number of steps") {
      set->steps = numberOf(words[0]).value_or(0);
    } else if (set && key == "filename numbers file") {
      set->elsewhere = true;
    } else if (set && key == "filename start number") {
      set->start = wholeOf(words[0]).value_or(0);
    } else if (set && key == "filename increment") {
      set->increment = wholeOf(words[0]).value_or(1);
    } else if (set && (key == "time values" || key == "filename numbers")) {
      for (const std::string& word : words) {
        if (key == "time values")
          set->values.push_back(numberOf(word).value_or(0));
        else
          set->numbers.push_back(wholeOf(word).value_or(0));
      }
    }
  }
  return out;
}

/// The name with the number of the step in place of its `*`; nothing where files that are not
/// looked at say the number.
std::optional<std::filesystem::path> pathOf(const Case& opened, const NamedFile& file,
                                            const std::filesystem::path& folder, double time) {
  std::string name = file.pattern;
  const auto stars = static_cast<std::size_t>(std::ranges::count(name, '*'));
  if (stars == 0)
    return folder / name;
  auto set = opened.times.find(file.timeSet);
  if (set == opened.times.end())
    set = opened.times.begin();
  if (set == opened.times.end() || set->second.values.empty() || set->second.elsewhere)
    return std::nullopt;
  name.replace(name.find('*'), stars, fmt::format("{:0{}}", set->second.numberAt(time), stars));
  return folder / name;
}

/// A file of lines and numbers, in ASCII or binary. Binary ones are read where they are looked at.
class Cursor {
 public:
  static Result<Cursor> open(const std::filesystem::path& path, bool binary) {
    VOLUTE_ASSIGN(auto file, InputFile::open(path));
    Cursor cursor(std::move(file), binary);
    if (!binary) {
      VOLUTE_ASSIGN(cursor.text_, readText(path, UINT64_MAX));  // in a process of limited memory
    }
    return cursor;
  }

  const std::filesystem::path& path() const { return file_.path(); }

  bool isBinary() const { return binary_; }

  bool atEnd() const {
    return binary_ ? at_ >= file_.size()
                   : text_.find_first_not_of(" \t\r\n", at_) == std::string::npos;
  }

  Result<std::string> line() {
    std::string out;
    if (binary_) {
      constexpr std::size_t kLine = 80;
      out.resize(kLine);
      VOLUTE_TRY(take(std::as_writable_bytes(std::span(out))));
      out = out.substr(0, out.find('\0'));
    } else {
      const auto end = text_.find('\n', at_);
      if (end == std::string::npos)
        return tooShort();
      out = text_.substr(at_, end - at_);
      at_ = end + 1;
    }
    out.erase(out.find_last_not_of(" \t\r\n") + 1);
    out.erase(0, out.find_first_not_of(" \t"));
    return out;
  }

  /// Counts, one a line.
  Result<std::vector<std::int64_t>> integers(std::int64_t count) {
    std::vector<std::int64_t> out;
    if (binary_)
      VOLUTE_TRY(need(bytesOf(count)));
    for (std::int64_t i = 0; i < count; ++i) {
      VOLUTE_ASSIGN(const std::int64_t value, integer());
      out.push_back(value);
    }
    return out;
  }

  Result<std::int64_t> integer() {
    if (!binary_) {
      VOLUTE_ASSIGN(const std::string text, line());
      const auto value = numberOf(text);
      if (!value || !(*value >= 0 && *value < 1e15))
        return notACount(text);
      return static_cast<std::int64_t>(*value);
    }
    std::array<std::byte, 4> raw{};
    VOLUTE_TRY(take(raw));
    if (swapped_)
      std::ranges::reverse(raw);
    std::int32_t value = 0;
    std::memcpy(&value, raw.data(), raw.size());
    if (value < 0)
      return notACount(fmt::format("{}", value));
    return value;
  }

  /// The number of a part, from which the order of bytes is known.
  Result<std::int64_t> partNumber() {
    constexpr std::int64_t kMax = 1 << 16;
    if (!binary_)
      return integer();
    const std::uint64_t at = at_;
    swapped_ = false;
    const auto number = integer();
    if (number && *number < kMax)
      return number;
    at_ = at;
    swapped_ = true;
    return integer();
  }

  /// Rows of numbers: a line each, or 4 bytes for each number.
  Status skip(std::int64_t rows, std::int64_t perRow = 1) {
    if (binary_) {
      const std::uint64_t bytes = bytesOf(rows) * static_cast<std::uint64_t>(perRow);
      VOLUTE_TRY(need(bytes));
      at_ += bytes;
      return {};
    }
    for (std::int64_t i = 0; i < rows; ++i) {
      const auto end = text_.find('\n', at_);
      if (end == std::string::npos)
        return tooShort();
      VOLUTE_TRY(checkRow(std::string_view(text_).substr(at_, end - at_), perRow));
      at_ = end + 1;
    }
    return {};
  }

 private:
  Cursor(InputFile file, bool binary) : file_(std::move(file)), binary_(binary) {}

  static std::uint64_t bytesOf(std::int64_t count) { return 4 * static_cast<std::uint64_t>(count); }

  Status need(std::uint64_t bytes) const {
    if (at_ > file_.size() || bytes > file_.size() - at_)
      return tooShort();
    return {};
  }

  Status take(std::span<std::byte> bytes) {
    VOLUTE_TRY(need(bytes.size()));
    VOLUTE_TRY(file_.read(at_, bytes));
    at_ += bytes.size();
    return {};
  }

  /// VTK takes what is no number for 0. Several integers may stand without space between them.
  Status checkRow(std::string_view row, std::int64_t perRow) const {
    const auto first = row.find_first_not_of(" \t+");
    const auto last = row.find_last_not_of(" \t\r");
    bool good = first != std::string_view::npos && first <= last;
    if (good) {
      row = row.substr(first, last + 1 - first);
      double value = 0;
      const auto [end, error] = std::from_chars(row.data(), row.data() + row.size(), value);
      good = perRow == 1 ? end == row.data() + row.size()
                         : row.find_first_not_of("0123456789 \t+-.eE") == std::string_view::npos;
      if (perRow == 1 && error == std::errc::invalid_argument)
        good = false;
    }
    if (good)
      return {};
    return fail(ErrorCode::kInvalidData, "{}: the line at byte {} is '{}'; expected {}",
                path().string(), at_, row.substr(0, 40),
                perRow == 1 ? "a number" : fmt::format("{} numbers", perRow));
  }

  tl::unexpected<Error> tooShort() const {
    return fail(ErrorCode::kTruncated,
                "{}: has {} bytes, and counts in it that ask for more: the end is missing; copy "
                "the file again or write it anew",
                path().string(), file_.size());
  }

  tl::unexpected<Error> notACount(const std::string& found) const {
    return fail(ErrorCode::kInvalidData, "{}: '{}' before byte {}; expected a count",
                path().string(), found, at_);
  }

  InputFile file_;
  bool binary_;
  bool swapped_ = false;
  std::string text_;  ///< all of it, in ASCII
  std::uint64_t at_ = 0;
};

struct Part {
  std::int64_t nodes = 0;
  bool hasVolumes = false;
  std::map<std::string, std::int64_t> elements;  ///< how many of each kind
};

struct Geometry {
  std::map<std::int64_t, Part> parts;
  bool binary = false;
  bool whole = true;  ///< false: something is in it that is not known here
};

/// The nodes of an element; 0 for kinds with numbers of their own.
std::optional<int> nodesOf(const std::string& kind) {
  static const std::map<std::string, int> all{
      {"point", 1},      {"bar2", 2},   {"bar3", 3},     {"tria3", 3},    {"tria6", 6},
      {"quad4", 4},      {"quad8", 8},  {"tetra4", 4},   {"tetra10", 10}, {"pyramid5", 5},
      {"pyramid13", 13}, {"penta6", 6}, {"penta15", 15}, {"hexa8", 8},    {"hexa20", 20},
      {"nsided", 0},     {"nfaced", 0}};
  const auto found = all.find(kind.starts_with("g_") ? kind.substr(2) : kind);
  return found == all.end() ? std::nullopt : std::optional(found->second);
}

bool isVolume(const std::string& kind) {
  return nodesOf(kind) &&
         (kind.find("tetra") != std::string::npos || kind.find("pyramid") != std::string::npos ||
          kind.find("penta") != std::string::npos || kind.find("hexa") != std::string::npos ||
          kind.find("nfaced") != std::string::npos);
}

std::int64_t sumOf(const std::vector<std::int64_t>& counts) {
  std::int64_t sum = 0;
  for (const std::int64_t count : counts) sum += count;
  return sum;
}

Status skipElements(Cursor& cursor, const std::string& kind, std::int64_t count) {
  const int nodes = nodesOf(kind).value_or(0);
  if (nodes > 0)
    return cursor.skip(count, nodes);
  VOLUTE_ASSIGN(auto counts, cursor.integers(count));
  if (kind.ends_with("nfaced")) {
    VOLUTE_ASSIGN(counts, cursor.integers(sumOf(counts)));
  }
  if (cursor.isBinary())
    return cursor.skip(sumOf(counts));
  constexpr int kSeveral = 3;  // or more
  return cursor.skip(static_cast<std::int64_t>(counts.size()), kSeveral);
}

/// From the line after "part" to the next part or the end; `line` is what follows.
Result<bool> readPart(Cursor& cursor, bool nodeIds, bool elementIds, Part& part,
                      std::string& line) {
  VOLUTE_ASSIGN(line, cursor.line());  // the description
  VOLUTE_ASSIGN(line, cursor.line());
  if (line != "coordinates")
    return false;
  VOLUTE_ASSIGN(part.nodes, cursor.integer());
  VOLUTE_TRY(cursor.skip((nodeIds ? 4 : 3) * part.nodes));
  while (!cursor.atEnd()) {
    VOLUTE_ASSIGN(line, cursor.line());
    if (line == "part" || line == "END TIME STEP")
      return true;
    if (!nodesOf(line))
      return false;
    VOLUTE_ASSIGN(const std::int64_t count, cursor.integer());
    part.elements[line] += count;
    part.hasVolumes = part.hasVolumes || isVolume(line);
    if (elementIds)
      VOLUTE_TRY(cursor.skip(count));
    VOLUTE_TRY(skipElements(cursor, line, count));
  }
  line.clear();
  return true;
}

bool hasIds(const std::string& line) {
  return line.ends_with("given") || line.ends_with("ignore");
}

Result<Geometry> readGeometry(const std::filesystem::path& path) {
  Geometry out;
  std::array<char, 80> head{};
  {
    VOLUTE_ASSIGN(const auto file, InputFile::open(path));
    const auto present = std::min<std::uint64_t>(head.size(), file.size());
    VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(head)).first(present)));
  }
  const std::string_view begin(head.data(), head.size());
  if (begin.substr(0, 16).find("Fortran") != std::string_view::npos) {
    out.whole = false;
    return out;
  }
  out.binary = begin.starts_with("C Binary");
  VOLUTE_ASSIGN(auto cursor, Cursor::open(path, out.binary));
  std::string line;
  VOLUTE_ASSIGN(line, cursor.line());
  if (line.starts_with("C Binary")) {
    VOLUTE_ASSIGN(line, cursor.line());
  }
  if (line == "BEGIN TIME STEP") {
    VOLUTE_ASSIGN(line, cursor.line());
  }
  VOLUTE_ASSIGN(line, cursor.line());
  VOLUTE_ASSIGN(const std::string nodeIds, cursor.line());
  VOLUTE_ASSIGN(const std::string elementIds, cursor.line());
  VOLUTE_ASSIGN(line, cursor.line());
  if (line == "extents") {
    constexpr int kExtents = 6;
    VOLUTE_TRY(cursor.isBinary() ? cursor.skip(kExtents) : cursor.skip(kExtents / 2, 2));
    VOLUTE_ASSIGN(line, cursor.line());
  }
  while (line == "part") {
    VOLUTE_ASSIGN(const std::int64_t number, cursor.partNumber());
    VOLUTE_ASSIGN(out.whole,
                  readPart(cursor, hasIds(nodeIds), hasIds(elementIds), out.parts[number], line));
    if (!out.whole)
      return out;
  }
  const auto bare = std::ranges::find_if(out.parts, [](const auto& part) {
    return part.second.nodes > 0 && part.second.elements.empty();
  });
  if (bare != out.parts.end()) {
    return fail(ErrorCode::kTruncated,
                "{}: part {} has {} nodes and no elements; expected a mesh; the end may be missing",
                path.string(), bare->first, bare->second.nodes);
  }
  return out;
}

Result<std::int64_t> countOf(Cursor& cursor, const Part& part, const std::string& kind) {
  if (kind == "coordinates")
    return part.nodes;
  const auto known = part.elements.find(kind);
  if (known != part.elements.end())
    return known->second;
  return fail(ErrorCode::kInvalidData,
              "{}: has values for elements '{}' that the geometry's part does not have; one of the "
              "two is cut off or of another case",
              cursor.path().string(), kind);
}

/// One part of a field: values of its nodes or of one kind of its elements after the other. False
/// when it is of a kind that is not known here.
Result<bool> readValues(Cursor& cursor, const Part& part, std::set<std::string>& found,
                        std::string& line) {
  while (!cursor.atEnd()) {
    VOLUTE_ASSIGN(line, cursor.line());
    if (line == "part" || line == "END TIME STEP")
      return true;
    const auto words = wordsOf(line);
    const std::string kind = words.empty() ? "" : words[0];
    if (kind != "coordinates" && !nodesOf(kind))
      return false;
    VOLUTE_ASSIGN(std::int64_t count, countOf(cursor, part, kind));
    if (words.size() > 1 && words[1] == "undef")
      VOLUTE_TRY(cursor.skip(1));
    if (words.size() > 1 && words[1] == "partial") {
      VOLUTE_ASSIGN(count, cursor.integer());
      VOLUTE_TRY(cursor.skip(count));
    }
    VOLUTE_TRY(cursor.skip(count));
    found.insert(kind);
  }
  line.clear();
  return true;
}

Status checkField(const std::filesystem::path& path, const Geometry& geometry) {
  VOLUTE_ASSIGN(auto cursor, Cursor::open(path, geometry.binary));
  std::string line;
  VOLUTE_ASSIGN(line, cursor.line());
  if (line == "BEGIN TIME STEP") {
    VOLUTE_ASSIGN(line, cursor.line());
  }
  std::map<std::int64_t, std::set<std::string>> found;
  if (!cursor.atEnd()) {
    VOLUTE_ASSIGN(line, cursor.line());
  }
  while (line == "part") {
    VOLUTE_ASSIGN(const std::int64_t number, cursor.partNumber());
    const auto part = geometry.parts.find(number);
    if (part == geometry.parts.end()) {
      return fail(ErrorCode::kInvalidData,
                  "{}: has values for part {}, which the geometry does not have; the geometry's "
                  "file is cut off or of another case",
                  path.string(), number);
    }
    VOLUTE_ASSIGN(const bool known, readValues(cursor, part->second, found[number], line));
    if (!known)
      return {};
  }
  for (const auto& [number, part] : geometry.parts) {
    if (!part.hasVolumes)
      continue;
    const auto& kinds = found[number];
    const bool whole =
        kinds.contains("coordinates") || std::ranges::all_of(part.elements, [&](const auto& e) {
          return !isVolume(e.first) || kinds.contains(e.first);
        });
    if (kinds.empty()) {
      return fail(
          ErrorCode::kUnsupported,
          "{}: has no values of part {} of the geometry: the field is of other parts alone, "
          "or the end is missing; expected values of all parts with a volume",
          path.string(), number);
    }
    if (!whole) {
      return fail(ErrorCode::kTruncated,
                  "{}: has not all values of part {} of the geometry: the end is missing; copy the "
                  "file again or write it anew",
                  path.string(), number);
    }
  }
  return {};
}

/// What VTK allocates for or leaves out without a word.
Status checkTimes(const Case& opened, const std::string& name) {
  for (const auto& [number, set] : opened.times) {
    if (!set.values.empty() && set.steps != static_cast<double>(set.values.size())) {
      return fail(ErrorCode::kInvalidData, "{}: time set {} has {} steps and {} time values", name,
                  number, set.steps, set.values.size());
    }
    for (std::size_t i = 1; i < set.values.size(); ++i) {
      if (!(set.values[i] > set.values[i - 1])) {
        return fail(ErrorCode::kInvalidData,
                    "{}: step {} of time set {} is at {} s, after {} s; expected ascending times",
                    name, i, number, set.values[i], set.values[i - 1]);
      }
    }
  }
  return {};
}

}  // namespace

Status checkEnsight(const std::filesystem::path& casePath, const std::string& field, double time) {
  VOLUTE_ASSIGN(const Case opened, readCase(casePath));
  VOLUTE_TRY(checkTimes(opened, casePath.string()));
  if (!opened.gold || opened.geometry.pattern.empty())
    return {};
  const auto folder = casePath.parent_path();
  const auto geometryPath = pathOf(opened, opened.geometry, folder, time);
  if (!geometryPath)
    return {};
  VOLUTE_ASSIGN(const Geometry geometry,
                ofFile(readGeometry(*geometryPath), geometryPath->string()));
  if (!geometry.whole)
    return {};
  if (std::ranges::none_of(geometry.parts,
                           [](const auto& part) { return part.second.hasVolumes; })) {
    return failIn(geometryPath->string(), "", ErrorCode::kInvalidData,
                  "has no elements with a volume; expected a mesh of them");
  }
  const auto scalar = opened.scalars.find(field);
  if (opened.geometry.ofSets || scalar == opened.scalars.end() || scalar->second.ofSets)
    return {};
  const auto fieldPath = pathOf(opened, scalar->second, folder, time);
  return fieldPath ? ofFile(checkField(*fieldPath, geometry), fieldPath->string()) : Status();
}

std::optional<std::vector<double>> ensightTimes(const std::filesystem::path& casePath,
                                                const std::string& field) {
  const auto opened = readCase(casePath);
  if (!opened || opened->times.size() < 2)
    return std::nullopt;
  const auto& scalars = opened->scalars;
  auto scalar = scalars.find(field.empty() ? "density" : field);
  if (field.empty() && scalars.size() == 1)
    scalar = scalars.begin();
  if (scalar == scalars.end())
    return std::nullopt;
  const auto set = opened->times.find(scalar->second.timeSet);
  if (set == opened->times.end() || set->second.values.empty())
    return std::nullopt;
  return set->second.values;
}

Status checkEnsightCase(const std::filesystem::path& casePath) {
  VOLUTE_ASSIGN(const Case opened, readCase(casePath));
  bool ofSets = opened.geometry.ofSets;
  for (const auto& [name, file] : opened.scalars) ofSets = ofSets || file.ofSets;
  if (ofSets) {
    return fail(ErrorCode::kUnsupported,
                "{}: has several times in one file (a file set); expected a file for each time, "
                "with * in its name",
                casePath.string());
  }
  return checkTimes(opened, casePath.string());
}

}  // namespace volute
