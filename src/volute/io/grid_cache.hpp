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
  bool empty = false;  ///< in all frames
};

/// The .vdb files of a simulation, with all their grids. Frames need not have the same grids.
class GridCache {
 public:
  /// @param input  a .vdb file, pattern or folder
  /// @param options  of how to read its grids; `grid` is not used
  [[nodiscard]] static Result<GridCache> open(const std::filesystem::path& input,
                                              const SourceOptions& options);

  /// Those that can be kept, in the order of the first file that has them.
  const std::vector<CacheGrid>& grids() const { return grids_; }

  /// The others: "'ids' (of type int32)".
  const std::vector<std::string>& leftOut() const { return leftOut_; }

  /// What the files say of themselves.
  const FrameMetadata& fileMetadata() const { return fileMetadata_; }

  /// The frames of a grid that is not empty, over all that it takes in any of them.
  [[nodiscard]] Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const;

 private:
  GridCache() = default;
  Status collect(const std::vector<LatticeCache>& files);

  std::vector<LatticeFile> files_;
  SourceOptions options_;
  std::vector<CacheGrid> grids_;
  std::vector<KnownGrid> known_;  ///< of each grid
  std::vector<std::string> leftOut_;
  FrameMetadata fileMetadata_;
};

/// The files that `input` means: a file, a pattern, a folder or a collection.
[[nodiscard]] Result<std::vector<LatticeFile>> listLatticeFiles(const std::filesystem::path& input);

}  // namespace volute
