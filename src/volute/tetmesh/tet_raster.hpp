// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>

#include "volute/math/vec.hpp"
#include "volute/tetmesh/screen.hpp"

// The inner loop of TetSplat.

namespace volute {

/// The plane of a face: normal . x = offset, the normal of length 1, away from the face's first
/// tet.
struct FacePlane {
  Vec3 normal;
  double offset = 0;
};

/// The mesh and its smoke as the splat sees them.
struct SplatMesh {
  const Vec3* vertices = nullptr;
  const std::int32_t* tets = nullptr;   ///< four vertices each
  const std::int32_t* faces = nullptr;  ///< four each: 2 * plane, + 1 where the tet is its second
  const FacePlane* planes = nullptr;
  const float* extinction = nullptr;  ///< of each vertex
  const float* gradient = nullptr;    ///< of the extinction, three for each tet
  const float* depth = nullptr;       ///< along the view, of each vertex
};

/// A tet that may touch a tile, and the tile's blocks where it may.
struct BinnedTet {
  std::int32_t tet;
  std::uint8_t x0, y0, x1, y1;
};

/// One square of pixels. They lie in blocks as wide as SIMD likes them; index() finds them.
struct TetTile {
  static constexpr int kSide = 64, kBlock = 4, kBlocks = kSide / kBlock;

  int x0 = 0, y0 = 0;
  bool bounded = false;                  ///< `end` counts
  alignas(64) float end[kSide * kSide];  ///< inverse depth (orthographic: minus the depth) where
                                         ///< the ray ends
  alignas(64) float sum[kSide * kSide];

  static int index(int x, int y) {
    return (y / kBlock * kBlocks + x / kBlock) * kBlock * kBlock + y % kBlock * kBlock + x % kBlock;
  }
};

/// Adds tets to a tile: optical depth for each metre of the rays' scale.
void splatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile);

}  // namespace volute
