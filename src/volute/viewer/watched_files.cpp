// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/watched_files.hpp"

#include <algorithm>
#include <string_view>

#include "volute/io/frame_pattern.hpp"
#include "volute/io/named_files.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

/// Which results of an FDS case are looked at: those of a run that goes on grow.
bool grows(const std::string& name) {
  constexpr std::string_view kKinds[] = {".sf", ".s3d", ".q", ".iso", ".prt5"};
  return std::ranges::any_of(kKinds, [&](std::string_view kind) { return name.ends_with(kind); });
}

std::filesystem::path besideOf(const std::filesystem::path& file, const std::string& name) {
  return file.parent_path() / name;
}

}  // namespace

std::vector<std::filesystem::path> filesOf(const std::string& name) {
  std::vector<std::filesystem::path> files;
  if (namesSeriesOfFiles(name)) {
    const auto pattern = FramePattern::parse(name);
    const auto there =
        pattern ? pattern->list(SubFrames::kAllowed) : Result<std::vector<NumberedFile>>();
    if (!pattern || !there || there->empty())
      return {name};
    for (const NumberedFile& file : *there) files.push_back(file.path);
    files.push_back(
        pattern->format(there->back().number + there->back().scale.unit(), there->back().scale));
    return files;
  }
  files.emplace_back(name);
  if (extensionOf(name) == ".pvd") {
    for (const std::string& part : namesInCollection(name)) files.push_back(besideOf(name, part));
  }
  if (extensionOf(name) == ".smv") {
    for (const std::string& part : namesInCase(name)) {
      if (grows(part))
        files.push_back(besideOf(name, part));
    }
  }
  return files;
}

}  // namespace volute
