// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/volume_info.hpp"

namespace volute {

/// One frame of a volume as bricks of 8^3 voxels, for rendering; empty bricks (all zero) are not
/// stored. Values of a brick: [channel][z][y][x] within the brick, x fastest (channel planes, so
/// that SIMD lanes gather one).
class BrickSlice {
 public:
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;
  static constexpr std::int32_t kEmpty = -1;

  /// An empty slice of the spatial size, channels, bounds and basis of `info`.
  explicit BrickSlice(const VolumeInfo& info);

  /// From dense values, shape (z, y, x, c).
  static BrickSlice fromDense(const VolumeInfo& info, std::span<const float> values);

  int x() const { return size_[0]; }

  int y() const { return size_[1]; }

  int z() const { return size_[2]; }

  int channels() const { return channels_; }

  Basis basis() const { return basis_; }

  /// The same values with another basis.
  void setBasis(Basis basis) { basis_ = basis; }

  const Box3& bounds() const { return bounds_; }  ///< outer voxel faces [m]

  /// The same values with other bounds.
  void setBounds(const Box3& bounds) { bounds_ = bounds; }

  int bricksX() const { return bricks_[0]; }

  int bricksY() const { return bricks_[1]; }

  int bricksZ() const { return bricks_[2]; }

  std::size_t brickCount() const { return index_.size(); }

  std::size_t storedBricks() const { return values_.size() / (kVoxels * channels_); }

  /// Which stored brick is at brick coordinate (bx, by, bz); kEmpty when all its voxels are zero.
  std::int32_t brickAt(int bx, int by, int bz) const {
    return index_[(static_cast<std::size_t>(bz) * bricks_[1] + by) * bricks_[0] + bx];
  }

  std::span<const std::int32_t> index() const { return index_; }

  std::span<const float> values() const { return values_; }

  const float* brick(std::int32_t stored) const {
    return values_.data() + static_cast<std::size_t>(stored) * kVoxels * channels_;
  }

  /// Which voxel of all stored ones, 512 a brick, is (vx, vy, vz), which is in a stored brick.
  std::size_t placeOf(int vx, int vy, int vz) const;

  /// Any voxel; 0 in empty bricks and outside the volume.
  float value(int vx, int vy, int vz, int channel = 0) const;

  /// Appends storage for brick (bx, by, bz), zero-filled, and returns it. Pointers returned before
  /// become invalid.
  float* addBrick(int bx, int by, int bz);

  /// Removes everything but keeps the memory, for the next frame.
  void clear();

  /// Restores the state of a freshly extracted slice from raw parts; used by parallel extraction.
  void assign(std::vector<std::int32_t> index, std::vector<float> values);

 private:
  int size_[3];    // voxels: x, y, z
  int bricks_[3];  // bricks: x, y, z
  int channels_;
  Basis basis_;
  Box3 bounds_;
  std::vector<std::int32_t> index_;
  std::vector<float> values_;
};

}  // namespace volute
