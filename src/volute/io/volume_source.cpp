// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/volume_source.hpp"

#include <algorithm>

#include "volute/io/frame_pattern.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/plugin.hpp"

namespace volute {
namespace {

std::vector<LatticeFile> toLatticeFiles(std::vector<NumberedFile> numbered) {
  std::vector<LatticeFile> files;
  for (auto& file : numbered) files.push_back({file.number, std::move(file.path), std::nullopt});
  return files;
}

Result<std::vector<LatticeFile>> singleFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return fail(ErrorCode::kNotFound, "{}: there is no such file", path.string());
  }
  return std::vector<LatticeFile>{{frameNumberOf(path).value_or(0), path, std::nullopt}};
}

Result<std::vector<LatticeFile>> listPattern(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(path));
  VOLUTE_ASSIGN(auto files, pattern.list());
  return toLatticeFiles(std::move(files));
}

/// The files of a .pvd, with their own numbers when those ascend, else their positions.
Result<std::vector<LatticeFile>> listCollection(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto timed, readCollection(path, loadVtkPlugin));
  if (timed.empty())
    return fail(ErrorCode::kInvalidData, "{}: the collection names no files", path.string());
  std::vector<LatticeFile> files;
  bool ascending = true;
  for (const auto& entry : timed) {
    if (!files.empty() && entry.time <= *files.back().time) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the times of a volume's frames must ascend, one file for each; {} s comes "
                  "after {} s",
                  path.string(), entry.time, *files.back().time);
    }
    if (entry.path.extension() != ".vti") {
      return fail(ErrorCode::kUnsupported, "{}: names {}; expected a collection of .vti files, or of .vtu or .pvtu files",
                  path.string(), entry.path.string());
    }
    const auto number = frameNumberOf(entry.path);
    ascending = ascending && number && (files.empty() || *number > files.back().number);
    files.push_back({number.value_or(0), path.parent_path() / entry.path, entry.time});
  }
  for (std::size_t i = 0; !ascending && i < files.size(); ++i)
    files[i].number = static_cast<int>(i);
  return files;
}

Result<std::vector<LatticeFile>> listFiles(const std::filesystem::path& input) {
  std::error_code error;
  if (std::filesystem::is_directory(input, error)) {
    VOLUTE_ASSIGN(auto files, listNumberedFiles(input, ".vdb"));
    return toLatticeFiles(std::move(files));
  }
  // A file whose name happens to look like a pattern is that file.
  if (FramePattern::isPattern(input) && !std::filesystem::exists(input, error))
    return listPattern(input);
  return input.extension() == ".pvd" ? listCollection(input) : singleFile(input);
}

}  // namespace

Result<std::unique_ptr<FrameSource>> openSource(const std::filesystem::path& input,
                                                const SourceOptions& options) {
  const std::string extension = input.extension().string();
  if (extension == ".npy")
    return openNpy(input, options);
  std::error_code error;
  const bool vdb = extension == ".vdb" || std::filesystem::is_directory(input, error);
  const bool vtk = extension == ".vti" || extension == ".pvd";
  if (!vdb && !vtk) {
    return fail(ErrorCode::kUnsupported,
                "{}: not a known kind of volume; expected .npy, .vdb (a file, a pattern or a "
                "folder of them), .vti or .pvd",
                input.string());
  }
  VOLUTE_ASSIGN(auto files, listFiles(input));
  return openLatticeSource(std::move(files), vdb ? loadVdbPlugin : loadVtkPlugin, options);
}

}  // namespace volute
