// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/codec/block_grid.hpp"

namespace volute {

/// Extents (t, z, y, x) and channels of one block.
struct BlockShape {
  BlockGrid::Index4 extents{};
  int channels = 1;

  std::size_t voxels() const {
    return static_cast<std::size_t>(extents[0]) * extents[1] * extents[2] * extents[3];
  }

  std::size_t values() const { return voxels() * channels; }

  /// Levels of the wavelet transform; as BlockGrid::levels.
  int levels() const;
};

/// Frames first <= t < end of a block.
struct FrameSpan {
  int first = 0, end = BlockGrid::kSide;
};

/// Sets all voxels of some frames to a value of each channel.
void fillFrames(std::span<float> values, const BlockShape& shape, FrameSpan wanted,
                std::span<const float> ofChannels);

/// The state of a voxel of a block.
enum class VoxelState : std::uint8_t {
  kEmpty,   ///< the background, or in a tile
  kActive,  ///< as the source says
  kValued,  ///< not active, and not equal to the background
};

/// Of all voxels of a block, shape (t, z, y, x).
using BlockStates = std::vector<VoxelState>;

/// What a file says of its values beside the parameters of its codec.
struct StreamInfo {
  int channels = 1;
  float valueMin = 0, valueMax = 0;  ///< of the original; decoded values are clamped to it
};

/// The bytes of a block, one string for each tier.
using Tiers = std::span<const std::vector<std::byte>>;

/// Reads the blocks of one stream. Thread-safe; each block is decoded for itself. A new codec is
/// one such class with a number of its own.
class BlockDecoder {
 public:
  virtual ~BlockDecoder() = default;

  /// How many frames a block has, but perhaps the last ones.
  virtual int blockFrames() const = 0;

  /// Whether the index has the mean of each block, and what such a mean is.
  virtual bool hasMeans() const = 0;
  virtual float mean(std::int64_t quantised) const = 0;

  /// How many levels each tier holds, coarse to fine; 5 in all.
  virtual std::span<const int> tierLevels() const = 0;

  /// No tier of such a block takes more bytes: what a reader may allocate.
  virtual std::uint64_t maxSegmentBytes(const BlockShape& shape, std::size_t tier) const = 0;

  /// Fills `values` from the first tiers of a block; tiers that are not given, and levels from
  /// `levels` on, count as zero, and the values may then leave the range of the original. Safe on
  /// any bytes: kInvalidData, in a message that wants a subject, or finite values.
  /// @param states  filled with what the voxels are, where it is not null; of a codec without
  /// topology all are active, but for those of a block without bytes
  /// @param wanted  what other frames of `values` hold is not said
  /// @param means   of the block, of each channel, where they are known: for coarse levels
  [[nodiscard]] virtual Status decode(Tiers tiers, int levels, const BlockShape& shape,
                                      std::span<float> values, BlockStates* states = nullptr,
                                      FrameSpan wanted = {},
                                      std::span<const float> means = {}) const = 0;

  /// Whether blocks store the states of their voxels.
  virtual bool hasTopology() const = 0;

  /// The offset of all values, also of tiles: stored values are differences from it.
  virtual double offset() const = 0;

  /// The value of voxels that no block stores.
  virtual std::array<float, 3> background() const = 0;

  /// How the block is coded, in a few words: "empty", "shaped cdf53, 4 time levels".
  [[nodiscard]] virtual Result<std::string> describe(Tiers tiers,
                                                     const BlockShape& shape) const = 0;
};

// Numbers of codecs in files; 1 was never released.
inline constexpr std::uint32_t kWaveletCodec = 2;
inline constexpr std::uint32_t kSparseCodec = 3;  ///< the same with topology

/// Wavelets on a support and context modelling (docs/format.md, section 8).
/// @param parameters  as the file keeps them; impossible ones are kInvalidData.
[[nodiscard]] Result<std::shared_ptr<const BlockDecoder>> openWaveletDecoder(
    std::uint32_t codec, std::span<const std::byte> parameters, const StreamInfo& stream);

}  // namespace volute
