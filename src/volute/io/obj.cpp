// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/obj.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/file_as_written.hpp"
#include "volute/base/lower_case.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/read_text.hpp"
#include "volute/base/suggest.hpp"
#include "volute/geometry/polygon.hpp"
#include "volute/io/below_folder.hpp"

namespace volute {
namespace {

/// Takes the next word off a line.
std::string_view nextWord(std::string_view& line) {
  const auto begin = std::min(line.find_first_not_of(" \t\r"), line.size());
  line.remove_prefix(begin);
  const auto end = std::min(line.find_first_of(" \t\r"), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  return word;
}

/// The rest of a line: names of materials may have spaces in them.
std::string trimmedName(std::string_view rest) {
  constexpr std::string_view kSpace = " \t\r";
  const auto begin = std::min(rest.find_first_not_of(kSpace), rest.size());
  rest.remove_prefix(begin);
  return std::string(rest.substr(0, rest.find_last_not_of(kSpace) + 1));
}

/// Calls `statement(keyword, rest, lineNumber)` for each line that says something; a backslash at a
/// line's end goes on with the next.
template <class Statement>
Status forEachLine(std::string& text, Statement&& statement) {
  int number = 0, begins = 1;
  std::string joined;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line(text.data() + at, end - at);
    at = end + 1;
    ++number;
    if (joined.empty())
      begins = number;
    if (!line.empty() && line.back() == '\r')
      line.remove_suffix(1);
    if (!line.empty() && line.back() == '\\') {
      joined.append(line.substr(0, line.size() - 1)).push_back(' ');
      continue;
    }
    joined.append(line);
    std::string_view rest = std::string_view(joined).substr(0, joined.find('#'));
    const std::string_view keyword = nextWord(rest);
    if (!keyword.empty())
      VOLUTE_TRY(statement(keyword, rest, begins));
    joined.clear();
  }
  return {};
}

/// All that Wavefront's format has, and what exporters add.
constexpr std::string_view kObjWords[] = {
    "v",        "vt",         "vn",        "vp",     "f",      "l",     "p",     "g",
    "s",        "o",          "mg",        "usemtl", "mtllib", "bevel", "lod",   "c_interp",
    "d_interp", "shadow_obj", "trace_obj", "usemap", "maplib", "ctech", "stech", "cstype",
    "deg",      "bmat",       "step",      "curv",   "curv2",  "surf",  "parm",  "trim",
    "hole",     "scrv",       "sp",        "end",    "con",    "bzp",   "bsp",   "cdc",
    "cdp",      "res",        "call",      "csh",    "fo",     "vw",    "t"};

constexpr std::string_view kObjLines[] = {"p", "l", "curv", "curv2"};

/// What is read of materials, in lower case as some write it. Exporters add words of their own, so
/// others are passed over, but for what may be one of these with a slip.
constexpr std::string_view kMtlRead[] = {"newmtl", "kd", "ke"};
constexpr std::string_view kMtlOther[] = {"ka", "ks", "km", "kt", "kr", "tf", "tr", "ns", "ni",
                                          "ne", "nt", "d",  "pr", "pm", "ps", "pc", "ta", "pcr"};

bool isOneOf(std::string_view word, std::span<const std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

std::string unknownWord(std::string_view word, std::span<const std::string_view> words) {
  const auto near = nearest(word, words);
  std::string shown(word.substr(0, 40));
  std::ranges::replace_if(shown, [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return fmt::format("'{}' is no statement{}", shown,
                     near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
}

/// The unit that a comment near the file's begin names, if it is not metres.
std::string unitInComments(std::string_view text) {
  constexpr std::string_view kUnits[] = {
      "mm", "millimeter", "millimetre", "cm",   "centimeter", "centimetre", "inch",
      "ft", "foot",       "feet",       "yard", "km",         "kilometer"};
  constexpr std::size_t kBegin = 64 << 10;
  text = text.substr(0, kBegin);
  while (!text.empty()) {
    std::string line = lowerCase(text.substr(0, text.find('\n')));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (!line.starts_with('#') || line.find("unit") == line.npos)
      continue;
    std::ranges::replace_if(line, [](unsigned char c) { return c < 'a' || c > 'z'; }, ' ');
    std::string_view rest = line;
    bool said = false;
    while (!rest.empty()) {
      const std::string_view word = nextWord(rest);
      said = said || word == "unit" || word == "units";
      const auto names = [&](std::string_view unit) {
        return word == unit || (unit.size() > 2 && word.starts_with(unit));
      };
      if (said && std::ranges::any_of(kUnits, names))
        return std::string(word);
    }
  }
  return "";
}

class ObjReader {
 public:
  ObjReader(std::filesystem::path path, std::uint64_t maxMemory)
      : path_(std::move(path)), maxMemory_(maxMemory) {
    mesh_.materials.emplace_back();
  }

  Result<TriangleMesh> read() {
    VOLUTE_ASSIGN(std::string text, readText(path_, maxMemory_));
    VOLUTE_TRY(forEachLine(text, [&](std::string_view keyword, std::string_view rest, int line) {
      return statement(keyword, rest, line);
    }));
    if (mesh_.triangles.empty()) {
      return fail(ErrorCode::kInvalidData, "{}: has no faces; expected an .obj file with v and f",
                  path_.string());
    }
    if (const std::string unit = unitInComments(text); !unit.empty())
      mesh_.remarks.push_back(fmt::format(
          "a comment says that its unit is {}; taken as metres: a transform scales it", unit));
    if (!unknown_.empty())
      mesh_.remarks.push_back(fmt::format(
          "the material '{}' is {}; what names it has the default colour", printable(unknown_),
          missing_.empty() ? "not there" : "in " + printable(missing_) + ", which is not there"));
    if (!uncolored_.empty())
      mesh_.remarks.push_back(fmt::format(
          "the material '{}' has no Kd and is drawn in the default colour", printable(uncolored_)));
    if (!bright_.empty())
      mesh_.remarks.push_back(fmt::format(
          "a surface of {} reflects more light than it gets; expected shares of 0 to 1", bright_));
    if (hasLines_)
      mesh_.remarks.push_back("its points, lines and curves are not drawn, its faces alone");
    if (hasColors_)
      mesh_.remarks.push_back(
          "colours of vertices (v X Y Z R G B) are not drawn, those of its materials alone");
    if (hasMaps_)
      mesh_.remarks.push_back(
          "pictures as colours (map_Kd, map_Ke) are not drawn, Kd and Ke alone");
    if (isClear_)
      mesh_.remarks.push_back("materials that let light through (d, Tr) are drawn opaque");
    return std::move(mesh_);
  }

 private:
  template <class... Args>
  tl::unexpected<Error> fault(int line, fmt::format_string<Args...> format, Args&&... args) const {
    return fail(ErrorCode::kInvalidData, "{}: line {}: {}", path_.string(), line,
                fmt::format(format, std::forward<Args>(args)...));
  }

  Status statement(std::string_view keyword, std::string_view rest, int line) {
    if (keyword == "v")
      return addVertex(rest, line);
    if (keyword == "f" || keyword == "fo")  // as the format's first version called it
      return addFace(rest, line);
    if (keyword == "usemtl") {
      const std::string name = trimmedName(rest);
      const auto found = named_.find(name);
      material_ = found == named_.end() ? 0 : found->second;
      if (found == named_.end() && unknown_.empty() && name != "None" && name != "(null)")
        unknown_ = name;
      if (found != named_.end() && uncolored_.empty() && !colored_.contains(material_))
        uncolored_ = name;
    } else if (keyword == "mtllib") {
      // Several names, or one with blanks in it, as Blender writes it.
      const std::string whole = trimmedName(rest);
      if (whole.find(' ') != whole.npos && isThere(whole))
        return addLibrary(whole, line);
      while (!rest.empty()) {
        const std::string_view name = nextWord(rest);
        if (!name.empty())
          VOLUTE_TRY(addLibrary(std::string(name), line));
      }
    } else if (keyword == "call" || keyword == "csh") {
      return fault(line, "'{}': other files and programs are not run; export it as one file",
                   keyword);
    } else if (keyword == "surf") {
      return fault(line, "free-form surfaces are not read; export them as polygons");
    } else if (isOneOf(keyword, kObjLines)) {
      hasLines_ = true;
    } else if (!isOneOf(keyword, kObjWords)) {
      return fault(line, "{}", unknownWord(keyword, kObjWords));
    }
    return {};
  }

  Status addVertex(std::string_view rest, int line) {
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = nextWord(rest);
      if (!readNumber(word, point[axis]) || !std::isfinite(point[axis]))
        return fault(line, "'{}' is no coordinate; expected v X Y Z", word);
    }
    vertices_.push_back(point);
    int more = 0;  // a fourth is a weight, three or four are a colour
    for (auto word = nextWord(rest); !word.empty(); word = nextWord(rest), ++more) {
      double number = 0;
      if (!readNumber(word, number))
        return fault(line, "'{}' behind a coordinate; expected v X Y Z", word);
    }
    hasColors_ = hasColors_ || more >= 3;
    return {};
  }

  Status addFace(std::string_view rest, int line) {
    std::vector<Vec3> corners;
    for (std::string_view word = nextWord(rest); !word.empty(); word = nextWord(rest)) {
      const std::string_view digits = word.substr(0, word.find('/'));
      std::int64_t number = 0;
      const auto count = static_cast<std::int64_t>(vertices_.size());
      if (!readNumber(digits, number))
        return fault(line, "'{}' is no corner; expected the number of a vertex", word);
      const std::int64_t index = number > 0 ? number - 1 : count + number;
      if (number == 0 || index < 0 || index >= count)
        return fault(line, "vertex {} of {} is not there", number, count);
      corners.push_back(vertices_[static_cast<std::size_t>(index)]);
    }
    if (corners.size() < 3)
      return fault(line, "a face of {} corners; expected at least 3", corners.size());
    if ((mesh_.triangles.size() + corners.size()) * sizeof(Triangle) > maxMemory_)
      return fail(ErrorCode::kTooLarge,
                  "{}: line {}: the triangles need more than the {} MiB of memory allowed",
                  path_.string(), line, maxMemory_ >> 20);
    const auto triangles = trianglesOf(corners);
    if (!triangles) {
      return fault(line, "a face of {} corners: {}; split it into triangles when exporting",
                   corners.size(), triangles.error().message);
    }
    for (const auto& [a, b, c] : *triangles)
      mesh_.triangles.push_back({{corners[a], corners[b], corners[c]}, material_});
    return {};
  }

  std::filesystem::path folderOf() const {
    return path_.has_parent_path() ? path_.parent_path() : std::filesystem::path(".");
  }

  bool isThere(const std::string& name) const {
    FilesAsWritten asked = written_;  // which counts names that differ
    const auto file = asked.find(folderOf(), name);
    std::error_code error;
    return isBelowFolder(file, folderOf()) && std::filesystem::is_regular_file(file, error);
  }

  /// A library that is not there leaves its materials at the default, as such files often travel
  /// alone.
  Status addLibrary(const std::string& name, int line) {
    const auto folder = folderOf();
    const auto file = written_.find(folder, name);
    if (!isBelowFolder(file, folder))
      return fault(line, "'{}' is not below the file's own folder", name);
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) {
      missing_ = missing_.empty() ? name : missing_;
      return {};
    }
    if (!libraries_.insert(file).second)
      return {};
    VOLUTE_ASSIGN(std::string text, readText(file, maxMemory_));
    std::uint32_t current = 0;
    std::set<std::string> colors;  // that the current one has
    std::map<std::string, std::vector<std::uint32_t>> own;
    VOLUTE_TRY(
        forEachLine(text, [&](std::string_view keyword, std::string_view rest, int at) -> Status {
          const std::string word = lowerCase(keyword);
          if (word == "newmtl") {
            current = static_cast<std::uint32_t>(mesh_.materials.size());
            named_[trimmedName(rest)] = current;
            own[trimmedName(rest)].push_back(current);
            mesh_.materials.emplace_back();
            colors.clear();
            return {};
          }
          const bool slip = !isOneOf(word, kMtlRead) && !isOneOf(word, kMtlOther) &&
                            std::ranges::any_of(
                                kMtlRead, [&](auto read) { return editDistance(word, read) < 2; });
          if (slip) {
            return fail(ErrorCode::kInvalidData, "{}: line {}: {}", file.string(), at,
                        unknownWord(keyword, kMtlRead));
          }
          hasMaps_ = hasMaps_ || word == "map_kd" || word == "map_ke";
          if (double share = 1; word == "d" || word == "tr") {
            isClear_ =
                isClear_ || (readNumber(nextWord(rest), share) && share != (word == "d" ? 1 : 0));
          }
          if (word != "kd" && word != "ke")
            return {};
          if (current == 0) {
            return fail(ErrorCode::kInvalidData,
                        "{}: line {}: {} is before newmtl; expected the name of its material first",
                        file.string(), at, keyword);
          }
          Rgb color;
          for (int c = 0; c < 3; ++c) {
            const std::string_view share = nextWord(rest);
            if (c == 0 && (share == "spectral" || share == "xyz")) {
              return fail(ErrorCode::kUnsupported,
                          "{}: line {}: {} by '{}' is not read; expected shares of red, green and "
                          "blue",
                          file.string(), at, keyword, share);
            }
            if (!readNumber(share, color[c]) || !(color[c] >= 0) || !std::isfinite(color[c])) {
              return fail(ErrorCode::kInvalidData, "{}: line {}: '{}' is no share of a color",
                          file.string(), at, share);
            }
          }
          const bool isMore = !nextWord(rest).empty();
          if (isMore || !colors.insert(word).second) {
            return fail(ErrorCode::kInvalidData, "{}: line {}: {} {}; expected three shares once",
                        file.string(), at, keyword,
                        isMore ? "has more than three shares" : "is there twice for a material");
          }
          if (word == "kd" && bright_.empty() && (color > 1).any())
            bright_ = fmt::format("{} {:g} {:g} {:g}", keyword, color[0], color[1], color[2]);
          if (word == "kd")
            colored_.insert(current);
          Material& material = mesh_.materials[current];
          (word == "kd" ? material.baseColor : material.emission) = color;
          return {};
        }));
    for (const auto& [called, places] : own) {
      const Material& first = mesh_.materials[places.front()];
      const Material& last = mesh_.materials[places.back()];
      if ((first.baseColor != last.baseColor).any() || (first.emission != last.emission).any()) {
        return fail(ErrorCode::kInvalidData,
                    "{}: the material '{}' is there twice, with other colors", file.string(),
                    printable(called));
      }
    }
    return {};
  }

  std::filesystem::path path_;
  std::uint64_t maxMemory_;
  TriangleMesh mesh_;
  std::vector<Vec3> vertices_;
  std::map<std::string, std::uint32_t> named_;
  FilesAsWritten written_;
  std::set<std::filesystem::path> libraries_;  ///< that were read
  std::set<std::uint32_t> colored_;            ///< materials with Kd
  // The first library that is not there, such a material, one without Kd, and a colour above 1.
  std::string missing_, unknown_, uncolored_, bright_;
  std::uint32_t material_ = 0;
  bool hasLines_ = false, hasColors_ = false, hasMaps_ = false,
       isClear_ = false;  ///< is there what is not drawn
};

}  // namespace

Result<TriangleMesh> readObj(const std::filesystem::path& path, std::uint64_t maxMemory) {
  return ObjReader(path, maxMemory).read();
}

}  // namespace volute
