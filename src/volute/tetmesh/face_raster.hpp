// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/tetmesh/screen.hpp"

// The inner loop of FaceSplat.

namespace volute {

/// A face, and how it bends the extinction.
struct LiveFace {
  std::int32_t vertices[3];
  /// 1/2 J / |n| with n the cross product of two edges; times the sum of the edges' functions, half
  /// the bend of the slope along a ray. 0: leaves the extinction as it is. On the boundary: 1 where
  /// there is smoke.
  float bend = 0;
  std::int32_t boundary = -1;  ///< index into boundary slopes
};

/// What a boundary face brings in.
struct BoundaryLine {
  float slopeX = 0, slopeY = 0,
        slope = 0;  ///< along a ray: slopeX px + slopeY py + slope [1/m per m of depth]
  float sign = 1;   ///< times that of the edges' functions: +1 enters
};

/// One square of pixels. Pixels lie in blocks as wide as SIMD likes them; index() finds them.
struct SplatTile {
  static constexpr int kSide = 32;

  int x0 = 0, y0 = 0;
  bool bounded = false;                    ///< some pixels have a limit
  alignas(64) float end[kSide * kSide];    ///< the depth at which the ramps are evaluated
  alignas(64) float limit[kSide * kSide];  ///< faces count up to here: `end`, or infinite
  alignas(64) float sum[kSide * kSide];
  alignas(64) float doubt[kSide * kSide];  ///< > 0: a ray met an edge

  /// Blocks of 4 x 4 pixels.
  static int index(int x, int y) {
    return ((y / 4) * (kSide / 4) + x / 4) * 16 + y % 4 * 4 + x % 4;
  }
};

/// Adds faces to a tile: depth per metre of depth, to be multiplied by the rays' scale.
void splatFaces(const ScreenView& view, const ScreenVertex* vertices, const PixelPlace* places,
                std::span<const LiveFace> faces, std::span<const BoundaryLine> lines,
                std::span<const std::int32_t> list, SplatTile& tile);

}  // namespace volute
