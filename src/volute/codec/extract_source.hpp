// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
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
  bool bricks = false;  ///< frames are read by readBricks() alone, so that none needs its box
};

/// Frames of a region of a .volute file, each block decoded once while the frames are read in
/// order.
///
/// Level L leaves out the finest L levels of each block, which hold what is smaller than 2^L voxels
/// in space and 2^L frames in time, and averages cubes of 2^L voxels. Cubes that reach beyond the
/// region count the background there, so that integrals are kept; the bounds grow with them. The
/// number of frames stays.
class ExtractSource final : public FrameSource {
 public:
  /// Holds the selected frames of one row of blocks, or as many of them as the memory that is
  /// allowed has room for: then blocks are decoded more than once. kTooLarge where that is none.
  /// `progress` must outlive the source.
  [[nodiscard]] static Result<std::unique_ptr<ExtractSource>> create(
      std::shared_ptr<const VoluteReader> reader, Extraction extraction, Progress& progress);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

  /// With the file's topology at level 0.
  [[nodiscard]] Status readBricks(int index, int first, int end, Bricks& bricks) override;

  /// Positions in the file of the extracted frames.
  const std::vector<int>& positions() const { return extraction_.positions; }

 private:
  ExtractSource(std::shared_ptr<const VoluteReader> reader, Extraction extraction,
                Progress& progress);
  bool keepsTopology() const;
  Status load(std::size_t index);
  Status loadBlock(std::size_t block);
  Status loadBricks(std::size_t index);
  std::vector<std::size_t> blocksOfRow(int row) const;

  std::size_t frameValues() const { return extraction_.region.voxels() * info_.channels; }

  std::shared_ptr<const VoluteReader> reader_;
  Extraction extraction_;
  Progress& progress_;
  VolumeInfo info_;
  std::vector<Bricks> bricks_;  // of the file's frames from firstBricks_ on
  int firstBricks_ = 0;         // its position in the file
  std::size_t framesAtOnce_ = 1;
  std::size_t firstLoaded_ = 0, loaded_ = 0;  // which of the selected frames are in row_
  std::vector<float> row_;                    // shape (t, z, y, x, c) of the region
};

/// A part of the volume of at most `maxVoxels` voxels: all that the frames at `positions` hold, by
/// whole blocks, or the middle of that.
Region fittingRegion(const VoluteReader& reader, std::span<const int> positions,
                     std::uint64_t maxVoxels);

/// `source`, whose values are those of `reader`; a level set in a file that keeps no topology gets
/// the one that its values suggest.
std::unique_ptr<FrameSource> withLevelSet(const VoluteReader& reader,
                                          std::unique_ptr<FrameSource> source);

}  // namespace volute
