// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>

#include "volute/tetmesh/tet_raster.hpp"

// The inner loop of TetSplat's lit pictures.

namespace volute {

/// What smoke sends to the eye, red, green and blue, in a tet: value at its first vertex + gradient
/// . (x - that vertex).
struct TetSource {
  float gradient[3][3];
  float value[3];
};

struct LitMesh {
  SplatMesh splat;
  const TetSource* sources = nullptr;
  const Vec3* vertices = nullptr;
  const Tet* tets = nullptr;
};

/// A square of pixels, in blocks as TetTile's.
struct LitTile {
  static constexpr int kSide = 32, kBlocks = kSide / TetTile::kBlock;
  static constexpr int kPixels = kSide * kSide;

  int x0 = 0, y0 = 0;
  bool bounded = false;
  alignas(64) float end[kPixels];    ///< as TetTile's
  alignas(64) float scale[kPixels];  ///< metres along the ray for each metre of depth
  alignas(64) float last[kPixels];   ///< inverse depth (orthographic: minus the depth) up to which
                                     ///< tets were added
  alignas(64) float passed[kPixels];
  alignas(64) float light[3][kPixels];
  alignas(64) float wrong[kPixels];  ///< not 0: a tet came after one that is behind it

  static int index(int x, int y) {
    constexpr int kBlock = TetTile::kBlock;
    return (y / kBlock * kBlocks + x / kBlock) * kBlock * kBlock + y % kBlock * kBlock + x % kBlock;
  }
};

/// Adds tets to a tile, front to back. `size` [m]: of the mesh.
void lightTets(const ScreenView& view, const LitMesh& mesh, std::span<const BinnedTet> list,
               float size, LitTile& tile);

}  // namespace volute
