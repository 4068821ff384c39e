// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "volute/grid/grid_description.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

/// A grid of a cache.
struct CacheGrid {
  std::string name;
  GridDescription description;
  bool empty = false;     ///< in all frames
  std::string problem{};  ///< why it is no volume, "of type int32", and has no description; else ""
  std::string type{};     ///< of a value
  std::uint64_t mostBytes = 0;  ///< of what is no volume, in the file of any frame
  std::size_t mostBytesIn = 0;  ///< the position of that file
  std::vector<int> places{};    ///< of each file: which of its grids this is; -1: none
};

/// The .vdb files of a simulation, with all their grids. Frames need not have the same grids.
class GridCache {
 public:
  /// @param input  a .vdb file, pattern or folder
  /// @param options  of how to read its grids; `grid` is not used
  [[nodiscard]] static Result<GridCache> open(const std::filesystem::path& input,
                                              const SourceOptions& options);

  const std::filesystem::path& file(std::size_t position) const { return files_[position].path; }

  /// In the order of the first file that has them.
  const std::vector<CacheGrid>& grids() const { return grids_; }

  /// Their numbers and times, of one voxel.
  VolumeInfo frames() const;

  /// Metadata of the files, apart from those of grids.
  const FrameMetadata& fileMetadata() const { return fileMetadata_; }

  /// The frames of a volume that is not empty, over all that it takes in any of them.
  [[nodiscard]] Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const;

  /// Any grid of a file as its bytes, good until the next call; null where the file has none.
  [[nodiscard]] Result<std::unique_ptr<KeptBytes>> keep(std::size_t grid, std::size_t file) const;

 private:
  GridCache() = default;
  Status collect(const std::vector<LatticeCache>& files);

  std::vector<LatticeFile> files_;
  SourceOptions options_;
  std::vector<CacheGrid> grids_;
  std::vector<KnownGrid> known_;              ///< of each grid
  mutable std::unique_ptr<KeptReader> kept_;  ///< made when first used
  FrameMetadata fileMetadata_;
  char up_ = 0;
};

/// The files that `input` means: a file, a pattern, a folder or a collection.
[[nodiscard]] Result<std::vector<LatticeFile>> listLatticeFiles(const std::filesystem::path& input);

}  // namespace volute
