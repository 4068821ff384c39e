// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/foam_files.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/number_word.hpp"

namespace volute {
namespace {

template <class T>
std::optional<T> numberOf(std::string_view word) {
  T value{};
  return readNumber(word, value) ? std::optional(value) : std::nullopt;
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
  const auto folder = casePath.parent_path().empty() ? "." : casePath.parent_path();
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

}  // namespace volute
