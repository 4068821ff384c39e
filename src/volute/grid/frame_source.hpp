// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/grid/volume_info.hpp"

namespace volute {

class Bricks;

/// A sequence of volumes that is read frame by frame, so that ten thousand frames need the memory
/// of one.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const VolumeInfo& info() const = 0;

  /// Other grids of the same files, as far as they are known.
  virtual std::vector<std::string> otherGrids() const { return {}; }

  /// Fills `values`, shape (z, y, x, c), x and c fastest, with frame `index` (a position, not a
  /// frame number). Errors name the file and the frame. May be called again for the same frame, and
  /// from one thread at a time.
  [[nodiscard]] virtual Status readFrame(int index, std::span<float> values) = 0;

  /// Whether readLayers() reads little more than the layers it returns.
  virtual bool readsLayers() const { return false; }

  /// Fills `values` with the layers first <= z < end of a frame, shape (end - first, y, x, c).
  [[nodiscard]] virtual Status readLayers(int index, int first, int end, std::span<float> values) {
    const std::size_t layer = info().frameValues() / static_cast<std::size_t>(info().z);
    if (values.size() == info().frameValues())
      return readFrame(index, values);
    std::vector<float> frame(info().frameValues());
    VOLUTE_TRY(readFrame(index, frame));
    std::copy_n(frame.begin() + static_cast<std::ptrdiff_t>(first * layer), (end - first) * layer,
                values.begin());
    return {};
  }

  /// The voxels of a frame with its topology, in the order of Bricks::sort(). Without topology in
  /// the source, voxels other than 0 are active.
  [[nodiscard]] Status readBricks(int index, Bricks& bricks) {
    return readBricks(index, 0, info().z, bricks);
  }

  /// The same of the layers first <= z < end; bricks across their border are whole.
  [[nodiscard]] virtual Status readBricks(int index, int first, int end, Bricks& bricks);

  /// Whether readBricks() gives the source's own topology, not one derived from values.
  virtual bool hasTopology() const { return false; }

  /// Bytes that the bricks of a frame take, as far as it is known: at most those of all voxels.
  virtual std::uint64_t brickBytes() const { return 4 * std::uint64_t{info().frameValues()}; }
};

/// Writes a sequence, frame by frame, in order.
class FrameSink {
 public:
  virtual ~FrameSink() = default;

  /// `values` as FrameSource::readFrame gives them.
  [[nodiscard]] virtual Status writeFrame(std::span<const float> values) = 0;

  /// Whether frames are to be given by writeBricks().
  virtual bool takesBricks() const { return false; }

  /// A frame with its topology, instead of writeFrame().
  [[nodiscard]] virtual Status writeBricks(const Bricks& bricks);

  /// To be called after the last frame; without it, no file appears.
  [[nodiscard]] virtual Status finish() = 0;
};

}  // namespace volute
