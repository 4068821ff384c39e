// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_name.hpp"

#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>

#include "volute/base/file_name.hpp"
#include "volute/base/frame_name.hpp"

namespace volute {

namespace fs = std::filesystem;

Status checkOutput(const std::string& target, bool standardOutput) {
  if (target == "-") {
    if (standardOutput)
      return {};
    return fail(ErrorCode::kInvalidArgument, "'-' is no target here; expected a file's name");
  }
  const fs::path path(target);
  const fs::path folder = folderOf(path);
  if (const std::size_t bytes = path.filename().native().size(); bytes > NAME_MAX) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: a name of {} bytes; expected at most {}, which file systems take", target,
                bytes, NAME_MAX);
  }
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return fail(ErrorCode::kIo, "{}: there is no folder {}; make it first", target,
                folder.string());
  }
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    return fail(ErrorCode::kIo, "{}: this is a folder; expected a file's name", target);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return fail(ErrorCode::kIo,
                "{}: this is no regular file, and would be replaced by one; give another name",
                target);
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot write into its folder: {}", target,
                std::strerror(errno));
  }
  return {};
}

std::string derivedOutput(const std::string& input, std::string_view end) {
  fs::path path = fs::path(input).lexically_normal();
  if (path.filename().empty())
    path = path.parent_path();  // a folder with its slash
  std::string stem = path.stem().string();
  if (const auto field = findFrameField(path.filename().string());
      namesSeriesOfFiles(path) && field && *field)
    stem.resize(std::min((*field)->begin, stem.size()));
  // A file that is called like a pattern, which its output is not.
  const std::string plain = stem + std::string(end);
  if (const auto field = findFrameField(plain); namesSeries(plain) && field && *field)
    stem.resize((*field)->begin);
  while (!stem.empty() && std::string_view("_.- ").find(stem.back()) != std::string_view::npos)
    stem.pop_back();
  if (stem.empty())
    stem = "volute";
  std::error_code ignored;
  for (int i = 1;; ++i) {
    const std::string name = fmt::format("{}{}{}", stem, i == 1 ? "" : fmt::format("_{}", i), end);
    if (!fs::exists(fs::symlink_status(name, ignored)))
      return name;
  }
}

}  // namespace volute
