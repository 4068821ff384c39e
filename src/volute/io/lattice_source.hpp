// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "volute/io/lattice.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

/// One file of a sequence on a lattice.
struct LatticeFile {
  int number = 0;
  std::filesystem::path path;
  std::optional<double>
      time;  ///< [s]; when not stated the file may state it, else the numbers give it
};

/// A sequence of files, each with a grid on one common lattice of voxels: all must have the same
/// voxel size, and origins that differ by whole voxels. Without bounds the volume is the least box
/// around all files' values.
/// @param loadPlugin  called in the child process that reads the files.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openLatticeSource(
    std::vector<LatticeFile> files, Result<const LatticePlugin*> (*loadPlugin)(),
    const SourceOptions& options);

/// All grids of a .vdb file, read in a child process as well.
[[nodiscard]] Result<std::vector<GridFacts>> listGrids(const std::filesystem::path& file,
                                                       std::uint64_t maxMemory);

/// The files of a collection, read in a child process as well.
[[nodiscard]] Result<std::vector<TimedFile>> readCollection(
    const std::filesystem::path& collection, Result<const LatticePlugin*> (*loadPlugin)());

}  // namespace volute
