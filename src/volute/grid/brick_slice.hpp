// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/brick_table.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

class Bricks;

/// One frame of a volume as bricks of 8^3 voxels, for rendering; empty bricks (all zero) are not
/// stored, and nothing is as large as the volume. Bricks of one value that are inside the volume
/// share their storage. Values of a brick: [channel][z][y][x] within the brick, x fastest (channel
/// planes, so that SIMD lanes gather one).
class BrickSlice {
 public:
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;
  static constexpr std::int32_t kEmpty = BrickTable::kEmpty;

  struct Entry {
    BrickPlace place{};
    std::int32_t stored = 0;  ///< of the stored bricks
  };

  /// An empty slice of the spatial size, channels, bounds and basis of `info`.
  explicit BrickSlice(const VolumeInfo& info);

  /// From dense values, shape (z, y, x, c).
  static BrickSlice fromDense(const VolumeInfo& info, std::span<const float> values);

  /// Fills `values` with the layers first <= z < end of a frame.
  using ReadLayers = std::function<Status(int first, int end, std::span<float> values)>;

  /// The same of values that are read some layers after the other, so that beside the bricks no
  /// more than those are in memory; all of them at once where not `byLayers`.
  [[nodiscard]] static Result<BrickSlice> fromLayers(const VolumeInfo& info, bool byLayers,
                                                     const ReadLayers& read);

  /// What of a frame lies in the volume and is not 0; its background is taken as 0.
  static BrickSlice fromBricks(const VolumeInfo& info, const Bricks& bricks);

  /// At most so many entries are made of the tiles of a frame.
  static std::uint64_t entriesOfTiles(const VolumeInfo& info, const Bricks& bricks);

  /// Zeros in the bricks at `places`, which are in the order of isBefore().
  BrickSlice(const VolumeInfo& info, std::span<const BrickPlace> places);

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

  int bricksX() const { return table_.count()[0]; }

  int bricksY() const { return table_.count()[1]; }

  int bricksZ() const { return table_.count()[2]; }

  std::size_t storedBricks() const {
    return values_.size() / (static_cast<std::size_t>(kVoxels) * channels_);
  }

  /// All bricks that are not empty, in the order of isBefore().
  std::span<const Entry> entries() const { return entries_; }

  /// Stored bricks from this index on have one constant value each and may occur at many places.
  std::int32_t firstUniform() const { return firstUniform_; }

  /// The index of the stored brick at brick coordinates (bx, by, bz), from -1 to one beyond the
  /// last on each axis; kEmpty if all its voxels are zero.
  std::int32_t brickAt(int bx, int by, int bz) const { return table_.at(bx, by, bz); }

  std::span<const float> values() const { return values_; }

  const float* brick(std::int32_t stored) const {
    return values_.data() + static_cast<std::size_t>(stored) * kVoxels * channels_;
  }

  float* brick(std::int32_t stored) {
    return values_.data() + static_cast<std::size_t>(stored) * kVoxels * channels_;
  }

  /// The index of voxel (vx, vy, vz), which must be in a stored brick, among all stored voxels, 512
  /// per brick.
  std::size_t placeOf(int vx, int vy, int vz) const;

  /// Any voxel; 0 in empty bricks and outside the volume.
  float value(int vx, int vy, int vz, int channel = 0) const;

  /// The same with a brick of its own in each place.
  BrickSlice unshared() const;

  /// A channel on voxels of twice the edges, of which each is the mean of eight. They lie as the
  /// first ones do; where those are of an odd number the last reach beyond them.
  BrickSlice halved(int channel) const;

  /// The bricks of cells between voxel centres that a stored brick contributes to: its own place
  /// and the next ones along each axis. In the order of isBefore(); `table` numbers them.
  std::vector<BrickPlace> reached(const BrickPlace& count, BrickTable& table) const;

  /// Takes bricks away in which all is zero.
  void dropEmpty();

  /// Walks from brick to brick: BrickTable::walk().
  const BrickTable& table() const { return table_; }

  std::uint64_t bytes() const {
    return values_.size() * sizeof(float) + entries_.size() * sizeof(Entry) + table_.bytes();
  }

 private:
  /// Makes the table for all bricks of the volume, and says how many they are.
  std::size_t expectAll();

  /// Appends the bricks of dense layers, from a brick's first one on, which follow what is there.
  void addLayers(int first, std::span<const float> values);

  int size_[3];  // voxels: x, y, z
  int channels_;
  Basis basis_;
  Box3 bounds_;
  std::vector<Entry> entries_;
  std::int32_t firstUniform_ = 0;
  BrickTable table_;
  std::vector<float> values_;
};

}  // namespace volute
