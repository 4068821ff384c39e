// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/foam_files.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/read_text.hpp"

namespace volute {
namespace {

template <class T>
std::optional<T> numberOf(std::string_view word) {
  T value{};
  return readNumber(word, value) ? std::optional(value) : std::nullopt;
}

/// Words and brackets of OpenFOAM's format; knows how long the binary blocks in it are.
class FoamWalk {
 public:
  explicit FoamWalk(std::string_view bytes) : bytes_(bytes) {}

  Status run(std::string_view kind) {
    while (at_ < bytes_.size()) {
      const char c = bytes_[at_];
      if (std::string_view(" \t\r\n").find(c) != std::string_view::npos) {
        ++at_;
      } else if (bytes_.substr(at_).starts_with("//")) {
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      } else if (bytes_.substr(at_).starts_with("/*")) {
        VOLUTE_TRY(goBehind("*/", "a comment"));
      } else if (c == '"') {
        ++at_;
        VOLUTE_TRY(goBehind("\"", "a text in quotes"));
        ended_ = false;
      } else if (std::string_view("({[").find(c) != std::string_view::npos) {
        VOLUTE_TRY(open(c));
      } else if (std::string_view(")}]").find(c) != std::string_view::npos) {
        VOLUTE_TRY(close(c));
      } else if (c == ';') {
        ++at_;
        last_ = list_ = {};
        if (open_.empty())
          ended_ = true;
      } else {
        word();
      }
      if (unknown_)
        return {};
    }
    return end(kind);
  }

 private:
  Status goBehind(std::string_view mark, const char* what) {
    const auto found = bytes_.find(mark, at_);
    if (found == std::string_view::npos)
      return missing(fmt::format("{} at byte {} has no end", what, at_));
    at_ = found + mark.size();
    return {};
  }

  void word() {
    const auto stop = std::min(bytes_.find_first_of(" \t\r\n(){}[];\"", at_), bytes_.size());
    const std::string_view found = bytes_.substr(at_, stop - at_);
    at_ = stop;
    ended_ = false;
    hasField_ = hasField_ || (open_.empty() && found == "internalField");
    if (inHeader_ && before_ == "format")
      binary_ = found == "binary";
    if (inHeader_ && before_ == "class")
      class_ = found;
    if (found.starts_with("List<"))
      list_ = found;
    last_ = found;
    before_ = found;
  }

  /// Bytes of a value in the block that begins here; 0: text, or not known.
  std::size_t valueSize() const {
    std::string_view type = list_;
    if (open_.empty() && list_.empty()) {
      if (class_ == "vectorField")
        type = "List<vector>";
      else if (class_ == "scalarField")
        type = "List<scalar>";
      else if (class_ == "labelList" || class_ == "faceCompactList")
        type = "List<label>";
    }
    const auto labels = widthOf("label=", 4), scalars = widthOf("scalar=", 8);
    if (type == "List<label>")
      return labels;
    if (type == "List<scalar>" || type == "List<sphericalTensor>")
      return scalars;
    if (type == "List<vector>")
      return 3 * scalars;
    if (type == "List<symmTensor>")
      return 6 * scalars;
    return type == "List<tensor>" ? 9 * scalars : 0;
  }

  /// Bytes of a label or scalar by the header's `arch`.
  std::size_t widthOf(std::string_view name, std::size_t usual) const {
    const auto at = bytes_.substr(0, 4096).find(name);
    if (at == std::string_view::npos)
      return usual;
    return bytes_.substr(at + name.size()).starts_with("32") ? 4 : 8;
  }

  Status open(char bracket) {
    const auto number = numberOf<std::uint64_t>(last_);
    const std::uint64_t count = bracket == '(' && number ? *number : 0;
    const bool ofText = list_.empty() && (!open_.empty() || class_ == "polyBoundaryMesh");
    inHeader_ = bracket == '{' && open_.empty() && last_ == "FoamFile";
    ++at_;
    if (binary_ && bracket == '(' && number && !ofText) {
      const std::size_t size = valueSize();
      if (size == 0) {
        unknown_ = true;
        return {};
      }
      const std::uint64_t left = bytes_.size() - at_;
      if (count > left / size)
        return missing(fmt::format("a list of {} values at byte {} goes beyond it", count, at_));
      at_ += count * size;
    }
    lists_ += open_.empty() && bracket == '(';
    open_.push_back(bracket);
    last_ = list_ = {};
    ended_ = false;
    return {};
  }

  Status close(char bracket) {
    const char wanted = bracket == ')' ? '(' : bracket == '}' ? '{' : '[';
    if (open_.empty() || open_.back() != wanted) {
      return fail(ErrorCode::kInvalidData, "has a '{}' at byte {} that closes nothing", bracket,
                  at_);
    }
    ++at_;
    open_.pop_back();
    inHeader_ = false;
    last_ = {};
    ended_ = open_.empty() && bracket != ']';
    return {};
  }

  Status end(std::string_view kind) const {
    if (!open_.empty())
      return missing(
          fmt::format("{} brackets are open at its end, a '{}' last", open_.size(), open_.back()));
    const bool emptyList = binary_ && last_ == "0";
    if (!ended_ && !emptyList)
      return missing("its last entry has no end");
    if (kind == "internalField" && !hasField_)
      return missing("it has no internalField");
    const int wanted = kind == "internalField" ? 0 : class_ == "faceCompactList" ? 2 : 1;
    if (lists_ < wanted && !emptyList)
      return missing(fmt::format("it has {} lists of {}", lists_, wanted));
    return {};
  }

  static tl::unexpected<Error> missing(const std::string& what) {
    return fail(ErrorCode::kTruncated, "is cut off: {}; copy the file again or write it anew",
                what);
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::vector<char> open_;   ///< brackets
  std::string_view last_;    ///< the word just before, in this bracket
  std::string_view before_;  ///< the same across brackets
  std::string_view list_;    ///< the last List<...>, up to its bracket
  std::string_view class_;
  bool binary_ = false, unknown_ = false;
  bool inHeader_ = false, hasField_ = false;
  int lists_ = 0;       ///< outside of other brackets
  bool ended_ = false;  ///< nothing is begun outside of brackets
};

/// The bytes of a file, unpacked.
Result<std::string> contentOf(const std::filesystem::path& path) {
  if (extensionOf(path) != ".gz")
    return readText(path);
  std::string text;
  VOLUTE_TRY(InputFile::check(path));
  const gzFile file = ::gzopen(path.c_str(), "rb");
  if (!file)
    return fail(ErrorCode::kNotFound, "{}: cannot be read", path.string());
  constexpr std::size_t kBlock = 1 << 20;
  int taken = 0;
  do {
    const std::size_t size = text.size();
    text.resize(size + kBlock);
    taken = ::gzread(file, text.data() + size, kBlock);
    text.resize(size + static_cast<std::size_t>(std::max(taken, 0)));
  } while (taken > 0);
  int error = Z_OK;
  ::gzerror(file, &error);
  const bool whole = ::gzclose(file) == Z_OK && taken == 0 && error == Z_OK;
  if (whole)
    return text;
  return fail(ErrorCode::kTruncated,
              "{}: cannot be unpacked to its end: it is cut off or damaged; copy the file again or "
              "write it anew",
              path.string());
}

/// The first bytes of a file, unpacked.
std::string beginOf(const std::filesystem::path& path) {
  constexpr unsigned kEnough = 64 << 10;
  const gzFile file = ::gzopen(path.c_str(), "rb");  // reads what is not packed as it is
  if (!file)
    return "";
  std::string text(kEnough, ' ');
  text.resize(static_cast<std::size_t>(std::max(::gzread(file, text.data(), kEnough), 0)));
  ::gzclose(file);
  return text;
}

/// Without comments.
std::string withoutComments(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const bool line = text.substr(at).starts_with("//"), block = text.substr(at).starts_with("/*");
    if (!line && !block) {
      out += text[at++];
      continue;
    }
    const auto end = text.find(line ? "\n" : "*/", at);
    at = end == text.npos ? text.size() : end + (line ? 0 : 2);
    out += ' ';
  }
  return out;
}

/// The file or its packed form; nothing when there is neither.
std::optional<std::filesystem::path> present(const std::filesystem::path& path) {
  std::error_code error;
  for (const char* suffix : {"", ".gz"}) {
    const std::filesystem::path file = path.string() + suffix;
    if (std::filesystem::is_regular_file(file, error))
      return file;
  }
  return std::nullopt;
}

Status checkFile(const std::filesystem::path& path, std::string_view kind) {
  const auto file = present(path);
  if (!file)
    return {};
  VOLUTE_ASSIGN(const std::string content, contentOf(*file));
  const auto checked = checkFoamText(content, kind);
  if (checked)
    return {};
  return fail(checked.error().code, checked.error().hints, "{}: {}", file->string(),
              checked.error().message);
}

Status checkMesh(const std::filesystem::path& folder) {
  for (const char* name : {"points", "faces", "owner", "neighbour", "boundary"})
    VOLUTE_TRY(checkFile(folder / "polyMesh" / name, name));
  return {};
}

/// Files of a folder, and of those so many levels below it.
Status checkKinds(const std::filesystem::path& folder, int below) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) {
      if (below > 0)
        VOLUTE_TRY(checkKinds(entry.path(), below - 1));
    } else if (entry.is_other(error)) {
      VOLUTE_TRY(InputFile::check(entry.path()));
    }
  }
  return {};
}

/// The folder of a time, which programs write in several ways ("10", "1e1").
std::optional<std::filesystem::path> folderAt(const std::filesystem::path& casePath, double time) {
  const auto folder = casePath.parent_path().empty() ? "." : casePath.parent_path();
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto named = numberOf<double>(entry.path().filename().string());
    if (named && entry.is_directory(error) &&
        std::abs(*named - time) <= 1e-9 * std::max(1.0, std::abs(time)))
      return entry.path();
  }
  return std::nullopt;
}

}  // namespace

std::optional<FoamDimensions> foamDimensions(const std::filesystem::path& casePath,
                                             const std::string& field, double time) {
  const auto folder = folderAt(casePath, time);
  const auto file = folder ? present(*folder / field) : std::nullopt;
  if (!file)
    return std::nullopt;
  const std::string text = withoutComments(beginOf(*file));
  constexpr std::string_view kKey = "dimensions";
  const std::size_t field0 = std::min(text.find("internalField"), text.size());
  for (std::size_t at = text.find(kKey); at < field0; at = text.find(kKey, at + 1)) {
    const std::size_t open = text.find_first_not_of(" \t\r\n", at + kKey.size());
    const bool own = at == 0 || std::string_view(" \t\r\n;}").find(text[at - 1]) != text.npos;
    if (!own || open == text.npos || text[open] != '[')
      continue;
    const std::string_view list =
        std::string_view(text).substr(open + 1, text.find(']', open) - open - 1);
    FoamDimensions dimensions{};
    std::size_t count = 0;
    for (std::size_t begin = list.find_first_not_of(" \t\r\n"); begin < list.size();) {
      const std::size_t end = std::min(list.find_first_of(" \t\r\n", begin), list.size());
      const auto power = numberOf<double>(list.substr(begin, end - begin));
      if (!power || count == dimensions.size())
        return std::nullopt;
      dimensions[count++] = *power;
      begin = list.find_first_not_of(" \t\r\n", end);
    }
    if (count == 5 || count == 7)
      return dimensions;
    return std::nullopt;
  }
  return std::nullopt;
}

bool hasFoamField(const std::filesystem::path& casePath, const std::string& field, double time) {
  const auto folder = folderAt(casePath, time);
  return folder && present(*folder / field);
}

std::vector<std::string> foamFields(const std::filesystem::path& casePath, double time) {
  std::vector<std::string> names;
  const auto folder = folderAt(casePath, time);
  if (!folder)
    return names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(*folder, error)) {
    if (!entry.is_regular_file(error))
      continue;
    const std::string head = withoutComments(beginOf(entry.path()));
    const std::size_t type = head.find_first_not_of(" \t\r\n", head.find("class") + 5);
    const std::string_view word = std::string_view(head).substr(std::min(type, head.size()));
    if (head.find("class") == head.npos ||
        !(word.starts_with("vol") || word.starts_with("point")) ||
        word.substr(0, word.find(';')).find("Field") == word.npos)
      continue;
    std::string name = entry.path().filename().string();
    if (name.ends_with(".gz"))
      name.resize(name.size() - 3);
    names.push_back(std::move(name));
  }
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

Status checkFoamDecomposed(const std::filesystem::path& casePath) {
  const auto folder = casePath.parent_path().empty() ? "." : casePath.parent_path();
  std::error_code error;
  if (std::filesystem::exists(folder / "constant" / "polyMesh", error))
    return {};
  int processors = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    constexpr std::string_view kPrefix = "processor";
    processors += name.starts_with(kPrefix) && name.size() > kPrefix.size() &&
                          name.find_first_not_of("0123456789", kPrefix.size()) == name.npos
                      ? 1
                      : 0;
    constexpr std::string_view kCollated = "processors";
    if (name.starts_with(kCollated))
      processors += numberOf<int>(name.substr(kCollated.size())).value_or(0);
  }
  if (processors == 0)
    return {};
  return fail(ErrorCode::kUnsupported,
              "{}: the case is decomposed into {} processors; expected it in one: run "
              "reconstructPar (reconstructParMesh first where the mesh changes) in its folder",
              casePath.string(), processors);
}

Status checkFoamKinds(const std::filesystem::path& casePath) {
  const auto folder = casePath.parent_path().empty() ? "." : casePath.parent_path();
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory(error))
      continue;
    if (name == "constant" || name == "system" || numberOf<double>(name))
      VOLUTE_TRY(checkKinds(entry.path(), 2));  // REGION/polyMesh
  }
  return {};
}

Status checkFoamText(std::string_view bytes, std::string_view kind) {
  return FoamWalk(bytes).run(kind);
}

Status checkFoam(const std::filesystem::path& casePath, const std::string& field, double time) {
  const auto folder = casePath.parent_path().empty() ? "." : casePath.parent_path();
  VOLUTE_TRY(checkMesh(folder / "constant"));
  const auto at = folderAt(casePath, time);
  if (!at)
    return {};
  VOLUTE_TRY(checkMesh(*at));
  return field.empty() ? Status() : checkFile(*at / field, "internalField");
}

}  // namespace volute
