// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
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

  /// As BlockGrid::levels.
  int levels() const;
};

/// What holds for all blocks of a stream and is known to its reader.
struct StreamParameters {
  double step = 1;                   ///< quantisation step; the only knob of the rate control
  float valueMin = 0, valueMax = 0;  ///< of the original; decoded values are clamped to it
};

/// Predicts the error of a quantisation step from one look at the data: how much weight there is in
/// coefficients of each size. Sizes are counted in sixteenths of an octave.
class ErrorHistogram {
 public:
  ErrorHistogram();

  /// A coefficient, orthonormal; `weight` is what a unit of its squared error adds to that of the
  /// voxels (1 except at the border).
  void add(double coefficient, double weight);
  void add(const ErrorHistogram& other);

  /// The sum of squared errors to expect of dead-zone quantisation with rounding offset 0.4.
  double squaredError(double step) const;
  /// How many coefficients it leaves.
  double survivors(double step) const;

 private:
  struct Bin {
    double count = 0, weight = 0, energy = 0;
  };

  std::vector<Bin> bins_;
};

/// A bit stream for blocks. Stateless and thread-safe; a block is encoded and decoded for itself. A
/// new codec is one class with a number of its own, listed in findCodec().
class BlockCodec {
 public:
  virtual ~BlockCodec() = default;

  virtual std::uint32_t id() const = 0;

  /// How many levels each tier holds, coarse to fine; 5 in all.
  virtual std::span<const int> tierLevels() const = 0;

  /// Parameters as the file keeps them, and back: kInvalidData for impossible ones. The range of
  /// the values is kept elsewhere.
  virtual std::vector<std::byte> writeParameters(const StreamParameters& parameters) const = 0;
  [[nodiscard]] virtual Status readParameters(std::span<const std::byte> bytes,
                                              StreamParameters& parameters) const = 0;

  /// Adds the coefficients of a block, `values` of shape extents x channels, to `histogram`.
  virtual void analyse(std::span<const float> values, const BlockShape& shape,
                       ErrorHistogram& histogram) const = 0;

  /// One byte string for each tier; empty when all its coefficients are zero.
  virtual std::vector<std::vector<std::byte>> encode(std::span<const float> values,
                                                     const BlockShape& shape,
                                                     const StreamParameters& parameters) const = 0;

  /// No tier of such a block takes more bytes: what a reader may allocate.
  virtual std::uint64_t maxSegmentBytes(const BlockShape& shape, std::size_t tier) const = 0;

  /// Fills `values` from the first tiers of a block; tiers that are not given, and levels from
  /// `levels` on, count as zero. Safe on any bytes: kInvalidData, in a message that wants a
  /// subject, or finite values.
  [[nodiscard]] virtual Status decode(std::span<const std::vector<std::byte>> tiers, int levels,
                                      const BlockShape& shape, const StreamParameters& parameters,
                                      std::span<float> values) const = 0;
};

/// The Haar codec, number 1 (docs/format.md, section 7).
const BlockCodec& haarCodec();

/// Null when this build does not know the number.
const BlockCodec* findCodec(std::uint32_t id);

}  // namespace volute
