// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/tree4d/tree_data.hpp"

namespace volute {

/// Voxels [begin, end) on the axes z, y, x; empty when nothing is inside.
struct VoxelBox {
  std::array<int, 3> begin{};
  std::array<int, 3> end{};

  bool empty() const { return begin[0] >= end[0] || begin[1] >= end[1] || begin[2] >= end[2]; }
};

/// The hexadeca-tree of Ahrenberg et al. 2005 (sections 4.3, 4.4 and 5.1) in the compact layout of
/// TreeData: a 4D volume as pruned, quantised Haar coefficients that are read in place. Immutable;
/// all reads are thread-safe.
class Tree4d {
 public:
  struct BuildOptions {
    double relativeRms = 3e-3;  ///< never exceeded, and met within about 3 %
    double step = 0;  ///< instead: the quantisation step of the orthonormal coefficients; 0 = from
                      ///< relativeRms
  };

  /// Reads the source several times (once for statistics, then for each trial of the step), with 16
  /// frames in memory at a time. NaN and infinities are refused.
  [[nodiscard]] static Result<Tree4d> build(FrameSource& source, const BuildOptions& options,
                                            Progress& progress);

  struct LoadOptions {
    int levels = 99;         ///< of each block, the coarsest first; fewer are a preview
    int firstFrame = 0;      ///< positions [firstFrame, endFrame), widened to whole rows of blocks:
    int endFrame = 1 << 30;  ///< frames outside are not read from the file and hold zeros
  };

  /// From a file, block by block, requantised with a quarter of the file's error, which increases
  /// the error by 3 %.
  [[nodiscard]] static Result<Tree4d> load(const VoluteReader& reader, const LoadOptions& options,
                                           Progress& progress);

  const VolumeInfo& info() const { return info_; }

  const TreeData& data() const { return data_; }

  /// The value at a voxel: t is a frame's position, channel 0 or (RGB) 0 to 2. Coordinates must be
  /// inside.
  float value(int t, int z, int y, int x, int channel = 0) const;

  /// The same for many voxels (t, z, y, x) at once; `values` has one (scalar) or three (RGB) a
  /// voxel.
  void values(std::span<const std::array<int, 4>> voxels, std::span<float> values) const;

  /// The same voxel by the paper's walk from the root (section 5.1, Figure 5), in double: the
  /// reference.
  double valueFromRoot(int t, int z, int y, int x, int channel = 0) const;

  /// Frame t, dense: shape (z, y, x, c). On all threads.
  void extractFrame(int t, std::span<float> values) const;

  /// Frame t as bricks; empty ones are neither computed nor stored. On all threads.
  /// `nodesVisited`, if given, is increased by the number of nodes read.
  BrickSlice extractSlice(int t, std::uint64_t* nodesVisited = nullptr) const;

  /// The smallest box around all non-zero voxels of frame t (section 5.2 of the paper).
  const VoxelBox& occupiedBox(int t) const { return boxes_[t]; }

  /// Only the first `nodes` nodes of the breadth-first array: a coarse picture of everything.
  Tree4d prefix(std::size_t nodes) const;

  /// Number of nodes of the pruned tree, and the bytes of all its arrays in memory.
  std::size_t nodeCount() const;
  std::size_t memoryBytes() const;

 private:
  friend class TreeBuilder;

  Tree4d(VolumeInfo info, TreeData data) : info_(std::move(info)), data_(std::move(data)) {}

  VolumeInfo info_;
  TreeData data_;
  std::vector<VoxelBox> boxes_;
};

}  // namespace volute
