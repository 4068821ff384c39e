// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/grid/frame_source.hpp"

namespace volute {

struct PuffOptions {
  int size = 512;  ///< voxels on a side, 16..4096 and a multiple of 8
  int frames = 16;
  std::uint32_t seed = 1;
};

/// Twelve puffs of fractal noise that drift upwards through a cube of 2 m, of which they fill about
/// one per cent: density [1/m]. Bricks are made where they are; the same options give the same
/// bytes on every machine. Frames may be read in any order.
class PuffSource final : public FrameSource {
 public:
  explicit PuffSource(const PuffOptions& options);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;
  [[nodiscard]] Status readBricks(int index, int first, int end, Bricks& bricks) override;

  using FrameSource::readBricks;

  bool hasTopology() const override { return true; }

  std::uint64_t brickBytes() const override;

 private:
  VolumeInfo info_;
  std::uint32_t seed_;
};

}  // namespace volute
