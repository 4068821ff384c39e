// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/placement.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

/// How a volume looks, and where and when.
struct Appearance {
  double emission = 1;         ///< radiance per metre per unit
  double extinction = 0;       ///< 1/m per unit
  std::optional<Basis> basis;  ///< instead of the file's
  Placement placement;
  Clock clock;
};

/// How much of the hexadeca-tree a rendering has looked at.
struct TreeCounts {
  std::uint64_t nodes = 0;         ///< of the largest tree that was in memory at a time
  std::uint64_t treeBytes = 0;     ///< of that tree
  std::uint64_t nodesVisited = 0;  ///< summed over all frames
};

/// What a tree gave, over the basis and at the place that `info` says.
BrickSlice asItLooks(BrickSlice slice, const VolumeInfo& info);

/// A volume file that is shown: gives any of its frames. Copies share what was read.
class VolumeLayer {
 public:
  [[nodiscard]] static Result<VolumeLayer> open(const std::string& path,
                                                const InputOptions& options,
                                                const Appearance& appearance, Reading& reading);

  /// Its bounds are those in the scene, but for what placement() does besides.
  const VolumeInfo& info() const { return info_; }

  /// As the file was named when it was opened.
  const std::string& path() const { return path_; }

  /// The file's, before the appearance's placement [m].
  const Box3& fileBounds() const { return input_->source->info().bounds; }

  /// What it takes in the scene [m].
  Box3 boundsInScene() const;

  /// It looks otherwise from now on, or is elsewhere, or at another time: nothing is read again for
  /// that. A frame that is held is made again only where the scale is another; else bounds stay
  /// what they are, and placement() moves.
  void setAppearance(const Appearance& appearance);

  /// The frame at a position as bricks. The last one is kept.
  /// @param tree  from the hexadeca-tree, which rounds once more, not from the file's own values
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> sliceAt(int position, bool tree = false);

  /// The hexadeca-tree that holds the frame at a position, and others of its blocks. The last one
  /// is kept. kInvalidArgument for what is no .volute.
  [[nodiscard]] Result<std::shared_ptr<const Tree4d>> treeAt(int position);

  /// What is to be done to points within info().bounds: turn and offset, no scale. Nothing for a
  /// volume that is not turned, and was not moved since it was opened: its bounds say where it is.
  const Placement& placement() const { return placement_; }

  /// What was read of trees so far; zeros for inputs without one.
  const TreeCounts& treeCounts() const { return counts_; }

  /// The position of the frame that is shown at a time of the scene [s].
  int positionAt(double time) const;

  /// What the file calls a frame.
  int numberOf(int position) const { return info_.frameNumbers[position]; }

  /// When a frame begins in the scene's time [s].
  double timeOf(int position) const;

  /// Who hears of later reads, instead of the reading that it was opened in.
  void setProgress(Progress& progress) { progress_ = &progress; }

  const Appearance& appearance() const { return appearance_; }

  /// Null unless it is a .volute file.
  const VoluteReader* reader() const { return input_->reader.get(); }

  /// How it was opened.
  const InputOptions& options() const { return options_; }

 private:
  VolumeLayer(VolumeInput input, const Appearance& appearance);

  [[nodiscard]] Result<BrickSlice> sliceFromTree(int position);
  [[nodiscard]] Result<BrickSlice> sliceFromFrame(int position);

  /// A tree holds one row of blocks: a still reads no more, and a film of any length needs its
  /// memory.
  static constexpr int kTreeFrames = BlockGrid::kSide;

  std::string path_;
  InputOptions options_;
  std::shared_ptr<VolumeInput> input_;  ///< shared by copies: one thread uses them all
  Appearance appearance_;
  Placement placement_;  ///< what info_.bounds leave to do
  VolumeInfo info_;
  std::shared_ptr<const Tree4d> tree_;
  int treeBegin_ = 0;
  TreeCounts counts_;
  Progress* progress_ = nullptr;
  int position_ = -1;
  bool fromTree_ = false;  ///< slice_ is
  std::shared_ptr<const BrickSlice> slice_;
};

}  // namespace volute
