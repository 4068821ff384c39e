// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/region.hpp"

namespace volute {

/// What to take out of a .volute file.
struct Extraction {
  std::vector<int> positions;  ///< of the frames, ascending
  Region region;               ///< inside the volume
  int level = 0;               ///< the resolution is divided by 2^level in space
  std::uint64_t maxMemory = std::uint64_t{4} << 30;
};

/// Frames of a region of a .volute file, each block decoded once while the frames are read in
/// order.
///
/// Level L leaves out the finest L levels of each block, which hold what is smaller than 2^L voxels
/// in space and 2^L frames in time, and averages cubes of 2^L voxels. Cubes that reach beyond the
/// region count zeros there, so that integrals are kept; the bounds grow with them. The number of
/// frames stays.
class ExtractSource final : public FrameSource {
 public:
  /// kTooLarge when the selected frames of one row of blocks need more than the memory that is
  /// allowed. `progress` must outlive the source.
  [[nodiscard]] static Result<std::unique_ptr<ExtractSource>> create(
      std::shared_ptr<const VoluteReader> reader, Extraction extraction, Progress& progress);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

  /// Of its frames in the file.
  const std::vector<int>& positions() const { return extraction_.positions; }

 private:
  ExtractSource(std::shared_ptr<const VoluteReader> reader, Extraction extraction,
                Progress& progress);
  Status load(int row);
  Status loadBlock(std::size_t block);
  std::vector<std::size_t> blocksOfRow(int row) const;

  std::size_t frameValues() const { return extraction_.region.voxels() * info_.channels; }

  std::size_t framesInRow(int row) const;

  std::shared_ptr<const VoluteReader> reader_;
  Extraction extraction_;
  Progress& progress_;
  VolumeInfo info_;
  int loadedRow_ = -1;
  std::size_t firstInRow_ = 0;  // index of the first selected frame of the row
  std::vector<float> row_;      // shape (selected frames of the row, z, y, x, c) of the region
};

/// Takes all frames out. The frames of a row of blocks are a unit of work; rank 0 writes all in order.
/// Collective.
/// @param sink  of rank 0; null on others
/// @param maxMemory  [bytes], of which an eighth may wait to be written
[[nodiscard]] Status extractFrames(ExtractSource& source, FrameSink* sink, std::uint64_t maxMemory,
                                   Progress& progress, Team& team);

}  // namespace volute
