// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/scene/volume_input.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

/// Where a volume stands in a scene: every point is scaled along the axes, then turned about the
/// origin, then moved.
struct Placement {
  Vec3 scale = Vec3::Ones();  ///< > 0
  Vec3 offset = Vec3::Zero();
  Mat3 turn = Mat3::Identity();  ///< orthogonal; may mirror

  bool turns() const { return turn != Mat3::Identity(); }
};

/// A volume's own time: offset + rate * the scene's time [s].
struct Clock {
  double offset = 0;
  double rate = 1;    ///< > 0
  bool loop = false;  ///< begins again after its last frame, which lasts as long as the one before
};

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

/// A volume file that is shown: gives the medium of any of its frames.
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
  const Box3& fileBounds() const { return input_.source->info().bounds; }

  /// What it takes in the scene [m].
  Box3 boundsInScene() const;

  /// It looks otherwise from now on, or is elsewhere, or at another time: nothing is read again for
  /// that. A frame that is held is made again only where the scale is another; else bounds stay
  /// what they are, and placement() moves.
  void setAppearance(const Appearance& appearance);

  /// What a tree gave, over this layer's basis and at its place in the scene.
  BrickSlice asItLooks(BrickSlice slice) const;

  /// The frame at a position as bricks. The last one is kept.
  [[nodiscard]] Result<std::shared_ptr<const BrickSlice>> sliceAt(int position);

  /// The hexadeca-tree that holds the frame at a position, and others of its blocks. The last one
  /// is kept. kInvalidArgument for what is no .volute.
  [[nodiscard]] Result<std::shared_ptr<const Tree4d>> treeAt(int position);

  /// `extinctionFactor` multiplies the appearance's extinction.
  [[nodiscard]] Result<VoxelMedium> mediumAt(int position, double extinctionFactor = 1);

  /// What is to be done to points within info().bounds: turn and offset, no scale. Nothing for a
  /// volume that is not turned, and was not moved since it was opened: its bounds say where it is.
  const Placement& placement() const { return placement_; }

  /// A medium of this layer as it stands in the scene.
  AnyMedium placed(const VoxelMedium& medium) const;

  /// What was read of trees so far; zeros for inputs without one.
  const TreeCounts& treeCounts() const { return counts_; }

  /// The position of the frame that is shown at a time of the scene [s].
  int positionAt(double time) const;

  /// When a frame begins in the scene's time [s].
  double timeOf(int position) const;

  /// Who hears of later reads, instead of the reading that it was opened in.
  void setProgress(Progress& progress) { progress_ = &progress; }

  const Appearance& appearance() const { return appearance_; }

  /// Null unless it is a .volute file.
  const VoluteReader* reader() const { return input_.reader.get(); }

 private:
  VolumeLayer(VolumeInput input, const Appearance& appearance);

  [[nodiscard]] Result<BrickSlice> sliceFromTree(int position);
  [[nodiscard]] Result<BrickSlice> sliceFromFrame(int position);

  /// A tree holds one row of blocks: a still reads no more, and a film of any length needs its
  /// memory.
  static constexpr int kTreeFrames = BlockGrid::kSide;

  std::string path_;
  VolumeInput input_;
  Appearance appearance_;
  Placement placement_;  ///< what info_.bounds leave to do
  VolumeInfo info_;
  std::vector<float> frame_;
  std::shared_ptr<const Tree4d> tree_;
  int treeBegin_ = 0;
  TreeCounts counts_;
  Progress* progress_ = nullptr;
  int position_ = -1;
  std::shared_ptr<const BrickSlice> slice_;
};

}  // namespace volute
