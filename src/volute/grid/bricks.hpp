// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/index_box.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

/// The voxels of a brick that are in a set: word z, bit 8 y + x.
using BrickMask = std::array<std::uint64_t, 8>;

/// The voxels of the brick at `origin` that lie in a box.
BrickMask maskInside(const VoxelIndex& origin, const IndexBox& box);

/// Voxels in a box; of one so large that they cannot be counted the greatest number.
std::uint64_t voxelsIn(const IndexBox& box);

/// One frame of a volume as large as what is in it: leaves of 8^3 voxels, constant tiles, and the
/// background everywhere else. Where a voxel is active, where it holds something, and the tiles are
/// the frame's topology. Voxels are those of VolumeInfo: (0, 0, 0) is its first one. Leaves and
/// tiles may reach beyond the volume, and lie where the lattice of their source has them, so that
/// they come back as they were. Where a leaf reaches into a tile, its voxels that are not valued
/// have the tile's value.
///
/// Nothing here is as large as a box.
class Bricks {
 public:
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;

  struct Leaf {
    VoxelIndex origin{};  ///< its first voxel; all leaves of a frame have the same remainder of 8
    BrickMask active{};
    BrickMask valued{};  ///< active, or not equal to the background
  };

  /// A cube of equal voxels.
  struct Tile {
    VoxelIndex origin{};
    std::int64_t side = kSide;  ///< a power of 2, at least kSide
    bool active = false;
    std::array<float, 3> value{};  ///< of each channel

    IndexBox box() const {
      return {origin, {origin[0] + side, origin[1] + side, origin[2] + side}};
    }

    bool operator==(const Tile&) const = default;
  };

  explicit Bricks(int channels = 1, const std::array<float, 3>& background = {})
      : channels_(channels), background_(background) {}

  /// The voxels of a dense frame, shape (z, y, x, c), that are not equal to the background, as
  /// active ones.
  static Bricks fromDense(const VolumeInfo& info, std::span<const float> values,
                          const std::array<float, 3>& background = {});

  /// The same of the layers firstLayer <= z < endLayer of a frame.
  static Bricks fromLayers(const VolumeInfo& info, int firstLayer, int endLayer,
                           std::span<const float> values,
                           const std::array<float, 3>& background = {});

  /// Fills the voxels of `box`, shape (z, y, x, c).
  void toDense(const IndexBox& box, std::span<float> values) const;

  int channels() const { return channels_; }

  const std::array<float, 3>& background() const { return background_; }

  std::span<const Leaf> leaves() const { return leaves_; }

  std::span<const Tile> tiles() const { return tiles_; }

  /// Of leaf `leaf`: [channel][z][y][x], x fastest. Voxels that are not valued are the background,
  /// or the tile's that they lie in.
  std::span<const float> values(std::size_t leaf) const {
    return std::span(values_).subspan(leaf * leafValues(), leafValues());
  }

  std::span<float> values(std::size_t leaf) {
    return std::span(values_).subspan(leaf * leafValues(), leafValues());
  }

  Leaf& leaf(std::size_t leaf) { return leaves_[leaf]; }

  /// Appends a leaf full of background, and returns its values; those returned before become
  /// invalid.
  std::span<float> addLeaf(const Leaf& leaf);

  /// Appends the leaves and tiles of another frame with the same channels.
  void append(const Bricks& other);

  void addTile(const Tile& tile) { tiles_.push_back(tile); }

  void reserve(std::size_t leaves, std::size_t tiles);

  /// Puts leaves and tiles in the order of their origins, z slowest, in which equal frames are
  /// equal and find() works.
  void sort();

  /// The position of the leaf whose first voxel is `origin`, leaves().size() where there is none.
  /// After sort().
  std::size_t find(const VoxelIndex& origin) const;

  /// Gives voxels of leaves that are not valued the value of the tile that they lie in: for leaves
  /// and tiles of different lattices. After sort().
  void fillUnderTiles();

  /// How many inactive voxels hold something in the file that the frame was read from, and are not
  /// here: they lie beyond all active ones, or are no numbers. 0 where that was not counted.
  std::uint64_t leftOut() const { return leftOut_; }

  void setLeftOut(std::uint64_t voxels) { leftOut_ = voxels; }

  /// Active voxels, those of tiles too.
  std::uint64_t activeVoxels() const;

  /// Moves all by so many voxels.
  void shift(const VoxelIndex& by);

  /// Takes away what lies outside of `box`. Tiles across its border stay whole.
  void crop(const IndexBox& box);

  /// All of it as bytes, for another process.
  std::size_t messageBytes() const;
  void toMessage(std::span<std::byte> message) const;

  /// The same the other way. Nothing in a message is trusted: kInvalidData, in words that want a
  /// subject, where it does not describe a frame. What is not valued has what is around it.
  [[nodiscard]] static Result<Bricks> fromMessage(std::span<const std::byte> message);

  /// A digest of all of it.
  std::uint32_t checksum() const;

  std::uint64_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + values_.size() * sizeof(float) +
           tiles_.size() * sizeof(Tile);
  }

 private:
  std::size_t leafValues() const { return static_cast<std::size_t>(kVoxels) * channels_; }

  int channels_ = 1;
  std::array<float, 3> background_{};
  std::vector<Leaf> leaves_;
  std::vector<Tile> tiles_;
  std::vector<float> values_;
  std::uint64_t leftOut_ = 0;
};

}  // namespace volute
