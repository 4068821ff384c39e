// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/foam_files.hpp"

#include <fmt/ranges.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <optional>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/number_word.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/printable.hpp"

namespace volute {
namespace {

template <class T>
std::optional<T> numberOf(std::string_view word) {
  T value{};
  return readNumber(word, value) ? std::optional(value) : std::nullopt;
}

/// The first bytes of a file, unpacked.
std::string beginOf(const std::filesystem::path& path, unsigned most = 64 << 10) {
  const gzFile file = ::gzopen(path.c_str(), "rb");  // reads what is not packed as it is
  if (!file)
    return "";
  std::string text(most, ' ');
  text.resize(static_cast<std::size_t>(std::max(::gzread(file, text.data(), most), 0)));
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

/// Files of a folder, and of those so many levels below it.
Status checkKinds(const std::filesystem::path& folder, int below) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) {
      if (below > 0)
        VOLUTE_TRY(checkKinds(entry.path(), below - 1));
    } else if (entry.is_other(error)) {
      VOLUTE_TRY(ofFile(InputFile::check(entry.path()), entry.path().string()));
    }
  }
  return {};
}

std::filesystem::path caseFolder(const std::filesystem::path& casePath) {
  return casePath.parent_path().empty() ? "." : casePath.parent_path();
}

/// The folder of a time, which programs write in several ways ("10", "1e1").
std::optional<std::filesystem::path> folderAt(const std::filesystem::path& casePath, double time) {
  const auto folder = caseFolder(casePath);
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto named = numberOf<double>(entry.path().filename().string());
    if (named && entry.is_directory(error) &&
        std::abs(*named - time) <= 1e-9 * std::max(1.0, std::abs(time)))
      return entry.path();
  }
  return std::nullopt;
}

/// Of the folders of times [s], ascending.
std::vector<double> timesIn(const std::filesystem::path& folder) {
  std::vector<double> times;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto time = numberOf<double>(entry.path().filename().string());
    if (time && std::isfinite(*time) && entry.is_directory(error))
      times.push_back(*time);
  }
  std::ranges::sort(times);
  return times;
}

/// Folders that processors of a parallel run wrote, and the times in the first.
struct Processors {
  int count = 0;
  std::vector<double> times;  ///< [s], ascending
};

Processors processorsOf(const std::filesystem::path& folder) {
  Processors out;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    constexpr std::string_view kPrefix = "processor", kCollated = "processors";
    int count = 0;
    if (name.starts_with(kCollated))  // as many in one folder
      count = numberOf<int>(name.substr(kCollated.size())).value_or(0);
    else if (name.starts_with(kPrefix) && numberOf<int>(name.substr(kPrefix.size())))
      count = 1;
    if (count > 0 && out.times.empty())
      out.times = timesIn(entry.path());
    out.count += count;
  }
  return out;
}

/// Whether a time is among ascending ones.
bool has(std::span<const double> times, double time) {
  const double near = 1e-9 * std::max(1.0, std::abs(time));
  const auto at = std::ranges::lower_bound(times, time - near);
  return at != times.end() && *at <= time + near;
}

/// With meshes of their own.
std::vector<std::string> regionsOf(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "constant", error)) {
    if (std::filesystem::exists(entry.path() / "polyMesh" / "points", error) ||
        std::filesystem::exists(entry.path() / "polyMesh" / "points.gz", error))
      names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

/// At the last time.
std::vector<std::string> cloudsOf(const std::filesystem::path& folder,
                                  std::span<const double> times) {
  std::vector<std::string> names;
  const auto last = times.empty() ? std::nullopt : folderAt(folder / "case", times.back());
  std::error_code error;
  if (!last)
    return names;
  for (const auto& entry : std::filesystem::directory_iterator(*last / "lagrangian", error))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

/// What constant/g states [m/s2].
std::optional<std::array<double, 3>> gravityOf(const std::filesystem::path& folder) {
  const auto file = present(folder / "constant" / "g");
  if (!file)
    return std::nullopt;
  const std::string text = withoutComments(beginOf(*file));
  const auto value = text.rfind("value");
  const auto open = text.find('(', std::min(value, text.size())), close = text.find(')', open);
  if (value == text.npos || close == text.npos)
    return std::nullopt;
  std::istringstream words(text.substr(open + 1, close - open - 1));
  std::array<double, 3> gravity{};
  for (double& one : gravity) {
    std::string word;
    words >> word;
    const auto read = numberOf<double>(word);
    if (!read)
      return std::nullopt;
    one = *read;
  }
  return gravity;
}

/// What stands in the brackets of a field's dimensions; nothing where it states none.
std::optional<std::string> dimensionsText(const std::filesystem::path& file) {
  const std::string text = withoutComments(beginOf(file));
  constexpr std::string_view kKey = "dimensions";
  const std::size_t field = std::min(text.find("internalField"), text.size());
  for (std::size_t at = text.find(kKey); at < field; at = text.find(kKey, at + 1)) {
    const std::size_t open = text.find_first_not_of(" \t\r\n", at + kKey.size());
    const bool own = at == 0 || std::string_view(" \t\r\n;}").find(text[at - 1]) != text.npos;
    if (own && open != text.npos && text[open] == '[')
      return text.substr(open + 1, text.find(']', open) - open - 1);
  }
  return std::nullopt;
}

}  // namespace

std::optional<FoamDimensions> foamDimensions(const std::filesystem::path& casePath,
                                             const std::string& field, double time) {
  const auto folder = folderAt(casePath, time);
  const auto file = folder ? present(*folder / field) : std::nullopt;
  const auto text = file ? dimensionsText(*file) : std::nullopt;
  if (!text)
    return std::nullopt;
  const std::string_view list = *text;
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
  return count == 5 || count == 7 ? std::optional(dimensions) : std::nullopt;
}

Status checkFoamDimensions(const std::filesystem::path& casePath) {
  const auto folder = caseFolder(casePath);
  std::error_code error;
  for (const auto& time : std::filesystem::directory_iterator(folder, error)) {
    if (!time.is_directory(error) || !numberOf<double>(time.path().filename().string()))
      continue;
    for (const auto& entry : std::filesystem::directory_iterator(time.path(), error)) {
      const auto text = entry.is_regular_file(error) ? dimensionsText(entry.path()) : std::nullopt;
      if (text && std::ranges::any_of(*text, [](char c) { return c >= 'a' && c <= 'z'; })) {
        return failIn(entry.path().string(), "", ErrorCode::kUnsupported,
                      "its dimensions are units' names, [{}]; expected the powers of kg, m, s, K, "
                      "mol, A and cd, as [1 -3 0 0 0 0 0] for kg/m3",
                      *text);
      }
    }
  }
  return {};
}

Status checkFoamReference(const std::filesystem::path& casePath, const std::string& field,
                          double time) {
  const auto folder = folderAt(casePath, time);
  const auto file = folder ? present(*folder / field) : std::nullopt;
  const std::string text = file ? withoutComments(beginOf(*file)) : "";
  const std::string_view head = std::string_view(text).substr(0, text.find("internalField"));
  constexpr std::string_view kKey = "referenceLevel", kSpace = " \t\r\n";
  const std::size_t key = head.find(kKey);
  if (key == head.npos)
    return {};
  const std::size_t begin =
      std::min(head.find_first_not_of(kSpace, key + kKey.size()), head.size());
  const std::string_view level = head.substr(begin, head.find(';', begin) - begin);
  const auto number = numberOf<double>(level.substr(0, level.find_first_of(kSpace)));
  if (number && *number == 0)
    return {};
  return failIn(file->string(), "", ErrorCode::kUnsupported,
                "its referenceLevel, {}, is added to all values by OpenFOAM and not here; expected "
                "0: write the field without one",
                printable(level));
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
    constexpr unsigned kHead = 4 << 10;  // of a file whose class is asked for
    const std::string head = withoutComments(beginOf(entry.path(), kHead));
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

Status checkFoamMesh(const std::filesystem::path& casePath) {
  const auto folder = caseFolder(casePath);
  std::error_code error;
  const Processors processors = processorsOf(folder);
  if (std::filesystem::exists(folder / "constant" / "polyMesh", error)) {
    const auto times = timesIn(folder);
    const bool goesOn = processors.times.size() > 1 &&
                        (times.empty() || !(times.back() > processors.times.front()));
    if (times.size() > 1 || !goesOn)
      return {};
    return fail(ErrorCode::kUnsupported,
                "{}: the case itself has {} of the {} times that its {} processors have until "
                "{} s; expected them in one: run reconstructPar in its folder",
                casePath.string(), times.empty() ? "none" : "one", processors.times.size(),
                processors.count, plainNumber(processors.times.back()));
  }
  if (processors.count > 0) {
    return fail(ErrorCode::kUnsupported,
                "{}: the case is decomposed into {} processors; expected it in one: run "
                "reconstructPar (reconstructParMesh first where the mesh changes) in its folder",
                casePath.string(), processors.count);
  }
  if (const auto regions = regionsOf(folder); !regions.empty()) {
    return fail(ErrorCode::kUnsupported,
                "{}: its meshes are of regions ({}); expected one in constant/polyMesh: write the "
                "region as a case of its own, or with foamToVTK",
                casePath.string(), fmt::join(regions, ", "));
  }
  return {};
}

bool FoamPatch::isWall() const {
  constexpr std::string_view kOpen[] = {"yclic",    "processor", "empty",       "wedge",
                                        "symmetry", "overset",   "nonConformal"};
  return std::ranges::none_of(
      kOpen, [&](std::string_view open) { return type.find(open) != std::string::npos; });
}

std::vector<FoamPatch> foamPatches(const std::filesystem::path& casePath, double time) {
  constexpr unsigned kMax = 4 << 20;  // bytes
  const auto folder = caseFolder(casePath);
  auto file = present(folder / "constant" / "polyMesh" / "boundary");
  for (const double own : timesIn(folder)) {
    const auto at = own <= time ? folderAt(casePath, own) : std::nullopt;
    const auto later = at ? present(*at / "polyMesh" / "boundary") : std::nullopt;
    if (later)
      file = later;
  }
  std::vector<FoamPatch> patches;
  std::string text = file ? withoutComments(beginOf(*file, kMax)) : "";
  std::vector<std::string> words;
  constexpr std::string_view kMarks = "{}();";
  std::string word;
  for (const char c : text + ' ') {
    const bool mark = kMarks.find(c) != kMarks.npos;
    if (!mark && std::isspace(static_cast<unsigned char>(c)) == 0) {
      if (c != '"')
        word += c;
      continue;
    }
    if (!word.empty())
      words.push_back(std::exchange(word, ""));
    if (mark)
      words.emplace_back(1, c);
  }
  int depth = 0;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "}")
      --depth;
    else if (words[i] == "{" && ++depth == 1)
      patches.push_back({words[i - 1], ""});
    else if (depth == 1 && words[i] == "type" && i + 1 < words.size() && !patches.empty())
      patches.back().type = words[i + 1];
  }
  std::erase_if(patches, [](const FoamPatch& one) { return one.name == "FoamFile"; });
  return patches;
}

std::vector<Remark> foamRemarks(const std::filesystem::path& casePath) {
  const auto folder = caseFolder(casePath);
  std::vector<Remark> remarks;
  const auto say = [&](RemarkCode code, const std::string& what) {
    remarks.push_back(
        Remark(code, fmt::format("{}: {}", casePath.string(), what)).in(casePath.string()));
  };
  const auto own = timesIn(folder);
  std::vector<double> missing;
  for (const double time : processorsOf(folder).times) {
    if (!has(own, time))
      missing.push_back(time);
  }
  if (!missing.empty()) {
    say(RemarkCode::kLeftOut,
        fmt::format("times that its processors alone have are left out: {} from {} to {} s; "
                    "run reconstructPar in its folder",
                    missing.size(), plainNumber(missing.front()), plainNumber(missing.back())));
  }
  if (const auto regions = regionsOf(folder); !regions.empty())
    say(RemarkCode::kLeftOut,
        fmt::format("regions besides the default one are left out: {}", fmt::join(regions, ", ")));
  if (const auto clouds = cloudsOf(folder, own); !clouds.empty())
    say(RemarkCode::kLeftOut,
        fmt::format("clouds of particles are left out: {}", fmt::join(clouds, ", ")));
  return remarks;
}

std::string foamGravity(const std::filesystem::path& casePath) {
  const auto gravity = gravityOf(caseFolder(casePath));
  if (!gravity)
    return "";
  const auto [x, y, z] = *gravity;
  const double pull = std::hypot(x, y, z);
  if (!(pull > 0) || -z > 0.5 * pull)
    return "";
  return fmt::format(
      "{}: constant/g is ({:g} {:g} {:g}), and z is upwards here: floors and heights of eyes are "
      "on their side; turn the mesh (transformPoints)",
      casePath.string(), x, y, z);
}

Status checkFoamByteOrder(const std::filesystem::path& casePath) {
  constexpr std::string_view kOther = std::endian::native == std::endian::little ? "MSB" : "LSB";
  const auto folder = caseFolder(casePath);
  std::vector<std::filesystem::path> folders{folder / "constant" / "polyMesh"};
  if (const auto times = timesIn(folder); !times.empty()) {
    for (const double time : {times.front(), times.back()})
      folders.push_back(*folderAt(casePath, time));
  }
  std::error_code error;
  for (const auto& one : folders) {
    for (const auto& entry : std::filesystem::directory_iterator(one, error)) {
      if (!entry.is_regular_file(error))
        continue;
      const std::string head = withoutComments(beginOf(entry.path()));
      const std::string_view top = std::string_view(head).substr(0, head.find('}'));
      const auto arch = top.find("arch");
      if (top.find("binary") == top.npos || arch == top.npos ||
          top.substr(arch).find(kOther) == top.npos)
        continue;
      return failIn(entry.path().string(), "", ErrorCode::kUnsupported,
                    "is binary in the byte order of another machine ({}); expected that of this "
                    "one: write the case in ASCII there (foamFormatConvert)",
                    kOther);
    }
  }
  return {};
}

Status checkFoamKinds(const std::filesystem::path& casePath) {
  const auto folder = caseFolder(casePath);
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

}  // namespace volute
