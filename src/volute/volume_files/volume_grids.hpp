// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/grid_description.hpp"
#include "volute/grid/kept_bytes.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// A grid of files with several.
struct VolumeGrid {
  std::string name;
  std::optional<GridDescription> description{};
  bool empty = false;  ///< in all frames
  std::string type{};  ///< of a value, where there is no description
  /// Why it is no volume and is kept as bytes, "of type int32"; empty: it is one.
  std::string kept{};
  std::uint64_t keptBytes = 0;  ///< that it takes in `keptIn`, the most of all frames; 0: unknown
  std::string keptIn{};         ///< a file
};

/// All grids of a cache: .vdb files or a .volute.
class VolumeGrids {
 public:
  virtual ~VolumeGrids() = default;

  /// Whether `path` is of a kind that may have several grids.
  static bool mayBe(const std::string& path);

  /// @param reading  is told, while the grids are read, which frames lack one; it outlives them
  [[nodiscard]] static Result<std::unique_ptr<VolumeGrids>> open(const std::string& path,
                                                                 const InputOptions& options,
                                                                 Reading& reading);

  const std::vector<VolumeGrid>& grids() const { return grids_; }

  /// Metadata of the files, apart from those of grids.
  const FrameMetadata& fileMetadata() const { return fileMetadata_; }

  /// Their numbers and times, of one voxel.
  const VolumeInfo& frames() const { return frames_; }

  /// The frames of a volume that is not empty.
  [[nodiscard]] virtual Result<std::unique_ptr<FrameSource>> source(std::size_t grid) const = 0;

  /// Of a grid of a .volute; that of another file is its original.
  [[nodiscard]] virtual Result<OwnError> ownError(std::size_t grid) const {
    (void)grid;
    return OwnError{};
  }

  /// A grid of a frame as its bytes, good until the next call; null where the frame has none. Of a
  /// .volute only those that it keeps so.
  /// @param frame  its position
  [[nodiscard]] virtual Result<std::unique_ptr<KeptBytes>> keep(std::size_t grid, int frame) const {
    (void)frame;
    return fail(ErrorCode::kUnsupported, "grid '{}' is not there as bytes", grids_[grid].name);
  }

  /// Positions of the grids in a list "density,flame"; all of them where it is empty. A wrong name
  /// is an error that names those that there are.
  [[nodiscard]] Result<std::vector<std::size_t>> choose(const std::string& list,
                                                        const std::string& path) const;

 protected:
  std::vector<VolumeGrid> grids_;
  FrameMetadata fileMetadata_;
  VolumeInfo frames_;
};

/// The names in "density,flame".
std::vector<std::string> gridNames(const std::string& list);

}  // namespace volute
