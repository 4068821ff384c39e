// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/sequence.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute {

/// The hexadeca-tree with the very node of Ahrenberg et al. 2005, Figure 4: position, two masks,
/// and then as many float coefficients and child offsets as the masks say. What the compact tree is
/// compared with, in bytes and in speed.
class PaperTree {
 public:
  /// The breadth-first array: the root's scaling coefficients (float32, one a channel), then nodes
  /// of
  ///   4 x u16  position: the first voxel of the node's support / 2^(level + 1), as t, z, y, x
  ///   u16      coefficient mask, u16 child mask (bit numbers: haar_node.hpp)
  ///   float32  each kept coefficient (orthonormal), channels together
  ///   u32      each child's byte offset in the array
  std::span<const std::byte> bytes() const { return bytes_; }

  std::size_t nodeCount() const { return nodes_; }

  /// Section 5.1: the sum over all nodes from the root down whose support holds the voxel.
  float value(int t, int z, int y, int x, int channel = 0) const;
  void values(int t, int z, int y, int x, std::span<float> channels) const;

  const VolumeInfo& info() const { return info_; }

 private:
  friend class PaperTransform;
  VolumeInfo info_;
  int levels_ = 1;
  std::size_t nodes_ = 0;
  std::vector<std::byte> bytes_;
};

/// All Haar coefficients of a sequence, from which trees for many thresholds are made. Needs a
/// dense copy in memory.
class PaperTransform {
 public:
  explicit PaperTransform(const Sequence& sequence);

  /// Keeps the orthonormal coefficients (of RGB: the triples) whose magnitude (the largest of the
  /// three) is at least `threshold`, and prunes from the bottom up (section 4.3).
  PaperTree build(double threshold) const;

  /// Bytes of build(threshold), without building it.
  std::size_t bytesAt(double threshold) const;

  /// The relative RMS error that dropping the other coefficients costs.
  double relativeRmsAt(double threshold) const;

  /// The largest threshold with at most this error, or the smallest with at most this many bytes.
  double thresholdForRms(double relativeRms) const;
  double thresholdForBytes(std::size_t bytes) const;

 private:
  struct Level {
    std::array<int, 4> nodes{};       // t, z, y, x
    std::vector<float> coefficients;  // 16 a node and channel, orthonormal
    std::vector<float> magnitudes;    // 16 a node: the largest of the channels; [0] is 0
    std::vector<float> energies;      // 16 a node: the sum of squares over the channels
    std::vector<std::uint16_t> validChildren;
    std::vector<std::array<std::uint32_t, 16>> cells;  // a node's children in the level below
  };
  struct Kept;
  std::vector<Kept> keep(double threshold) const;

  VolumeInfo info_;
  std::vector<Level> levels_;  // [0] is the finest
  std::vector<float> mean_;
  double range_ = 0;
};

/// Equation 13: rotates the view volume's axes to the volume's by `rotation` and moves it to frame
/// t.
Eigen::Matrix<double, 5, 5> paperViewMatrix(const Eigen::Matrix3d& rotation, double t);

/// Figure 6, with n^3 voxels in the view volume: every one is transformed by the view matrix and
/// summed into its pixel by a walk through the tree. `box`: skip voxels outside of it
/// (section 5.2), or null. On all threads, a row a task.
/// @return shape (n, n, channels), row 0 is the top; values are sums times the voxel's edge, as a
/// line integral in units
///         of the volume's longest side.
std::vector<float> renderByTraversal(const PaperTree& tree, const Eigen::Matrix<double, 5, 5>& view,
                                     int n, const VoxelBox* box);

}  // namespace volute
