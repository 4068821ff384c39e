// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/volume_source.hpp"

#include <algorithm>

#include "volute/base/file_as_written.hpp"
#include "volute/base/file_name.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/foam_files.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/grid_cache.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/raw_volume.hpp"
#include "volute/io/surface_file.hpp"
#include "volute/io/unread_mesh.hpp"

namespace volute {
namespace {

std::vector<LatticeFile> toLatticeFiles(std::vector<NumberedFile> numbered) {
  std::vector<LatticeFile> files;
  for (auto& file : numbered)
    files.push_back(
        {file.number, std::move(file.path), std::nullopt, file.scale, std::move(file.written)});
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
  VOLUTE_ASSIGN(auto files, pattern.list(SubFrames::kAllowed));
  return toLatticeFiles(std::move(files));
}

/// The files of a .pvd, with their own numbers when those ascend, else their positions.
Result<std::vector<LatticeFile>> listCollection(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto timed, readCollection(path, loadVtkPlugin));
  if (timed.empty())
    return fail(ErrorCode::kInvalidData, "{}: the collection names no files", path.string());
  std::vector<LatticeFile> files;
  FilesAsWritten written;
  bool ascending = true;
  for (const auto& entry : timed) {
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): all have one
    if (!files.empty() && entry.time <= *files.back().time) {
      return fail(ErrorCode::kInvalidData,
                  "{}: the times of a volume's frames must ascend, one file for each; {} s comes "
                  "after {} s",
                  // NOLINTNEXTLINE(bugprone-unchecked-optional-access): all have one
                  path.string(), entry.time, *files.back().time);
    }
    if (extensionOf(entry.path) != ".vti") {
      return fail(ErrorCode::kUnsupported,
                  "{}: names {}; expected a collection of .vti files, or of .vtu or .pvtu files",
                  path.string(), entry.path.string());
    }
    const auto file = written.find(path.parent_path(), entry.path.string());
    const auto number = frameNumberOf(file);
    ascending = ascending && number && (files.empty() || *number > files.back().number);
    files.push_back({number.value_or(0), file, entry.time});
  }
  for (std::size_t i = 0; !ascending && i < files.size(); ++i)
    files[i].number = static_cast<int>(i);
  return files;
}

}  // namespace

Result<std::vector<LatticeFile>> listLatticeFiles(const std::filesystem::path& input) {
  std::error_code error;
  if (std::filesystem::is_directory(input, error)) {
    if (std::filesystem::exists(input / "system" / "controlDict", error)) {
      VOLUTE_TRY(checkFoamMesh(input / ""));
      return fail(
          ErrorCode::kUnsupported,
          "{}: is an OpenFOAM case; give the name of a file in it that ends in .foam, which "
          "may be empty (touch case.foam)",
          input.string());
    }
    VOLUTE_TRY(volumesIn(input));  // both kinds: which one is meant?
    auto files = listNumberedFiles(input, ".vdb");
    if (!files && files.error().code == ErrorCode::kNotFound) {
      return fail(ErrorCode::kNotFound,
                  "{}: no numbered .vdb or .npy files in this folder; name files of another kind "
                  "with a pattern, such as {}",
                  input.string(), (input / "name_%04d.vti").string());
    }
    if (!files)
      return tl::unexpected(std::move(files.error()));
    return toLatticeFiles(std::move(*files));
  }
  // A file whose name happens to look like a pattern is that file.
  if (namesSeriesOfFiles(input))
    return listPattern(input);
  return extensionOf(input) == ".pvd" ? listCollection(input) : singleFile(input);
}

bool isVdbPath(const std::filesystem::path& path) {
  const std::string extension = extensionOf(path);
  return extension == ".vdb" || extension == ".nvdb";
}

Result<std::string> volumesIn(const std::filesystem::path& folder) {
  const auto holds = [&](std::string_view extension) {
    const auto files = listNumberedFiles(folder, extension);
    return files || files.error().code != ErrorCode::kNotFound;
  };
  const bool vdb = holds(".vdb"), npy = holds(".npy");
  if (vdb && npy) {
    return fail(
        ErrorCode::kInvalidArgument,
        "{}: holds numbered .vdb and .npy files; name one sequence with its pattern, such as {}",
        folder.string(), (folder / "name_%04d.vdb").string());
  }
  return npy ? ".npy" : ".vdb";
}

namespace {

Result<std::unique_ptr<FrameSource>> openAny(const std::filesystem::path& input,
                                             const SourceOptions& options) {
  const std::string extension = extensionOf(input);
  std::error_code error;
  if (options.raw) {
    if (!namesSeriesOfFiles(input))
      return openRaw(input, options);
    VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(input));
    VOLUTE_ASSIGN(const auto files, pattern.list(SubFrames::kAllowed));
    return openRawSequence(files, options);
  }
  if (extension == ".npy" || extension == ".npz") {
    if (!namesSeriesOfFiles(input))
      return openNpy(input, options);
    VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(input));
    VOLUTE_ASSIGN(const auto files, pattern.list(SubFrames::kAllowed));
    return openNpySequence(files, options);
  }
  if (const auto array = namedArray(input)) {
    if (namesSeriesOfFiles(array->file)) {
      return fail(ErrorCode::kUnsupported,
                  "{}: a pattern of {} files; expected one file with all frames, or a pattern of "
                  ".vdb, .npy, .npz or .vti files",
                  input.string(), extensionOf(array->file));
    }
    return openArrayFile(*array, options);
  }
  const bool folder = std::filesystem::is_directory(input, error);
  if (folder) {
    VOLUTE_ASSIGN(const auto kind, volumesIn(input));
    if (kind == ".npy") {
      VOLUTE_ASSIGN(const auto files, listNumberedFiles(input, kind));
      return openNpySequence(files, options);
    }
  }
  const bool vdb = isVdbPath(input) || folder;
  const bool vtk = extension == ".vti" || extension == ".pvd";
  if (!vdb && !vtk && isSurfacePath(input)) {
    return fail(ErrorCode::kUnsupported,
                "{}: is geometry, not a volume; expected it in a scene, as its \"geometry\"",
                input.string());
  }
  if (!vdb && !vtk && isUnreadMesh(input)) {
    return fail(ErrorCode::kUnsupported,
                "{}: is a mesh in a format that is not read; expected .vtu, .pvtu, .vtk, .pvd, "
                ".case, .e or .foam, as ParaView saves it (several blocks after Merge Blocks)",
                input.string());
  }
  if (!vdb && !vtk) {
    return fail(ErrorCode::kUnsupported,
                "{}: not a known kind of volume; expected .npy, .npz or .vdb (a file, a pattern or "
                "a folder of them), .nvdb, .vti, .pvd, or an array of .nc, .h5 or .zarr",
                input.string());
  }
  VOLUTE_ASSIGN(auto files, listLatticeFiles(input));
  return openLatticeSource(std::move(files), vdb ? loadVdbPlugin : loadVtkPlugin, options);
}

}  // namespace

Result<std::unique_ptr<FrameSource>> openSource(const std::filesystem::path& input,
                                                const SourceOptions& options) {
  VOLUTE_ASSIGN(auto source, openAny(input, options));
  VOLUTE_TRY(settleOffset(*source, options.offsets));
  return source;
}

}  // namespace volute
