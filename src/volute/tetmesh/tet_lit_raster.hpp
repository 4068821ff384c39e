// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
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

/// A square of pixels, in blocks as TetTile's. All numbers of a block lie together: in arrays of
/// their own they would be 4096 bytes apart, where a CPU takes a store for the next load's.
struct LitTile {
  static constexpr int kSide = 32, kBlocks = kSide / TetTile::kBlock;
  static constexpr int kPixels = kSide * kSide;
  static constexpr int kBlockPixels = TetTile::kBlock * TetTile::kBlock;

  enum Field {
    kEnd,     ///< as TetTile's
    kScale,   ///< metres along the ray for each metre of depth
    kLast,    ///< inverse depth (orthographic: minus the depth) up to which tets were added
    kPassed,  ///< transmittance so far
    kLight,   ///< red; green and blue follow
    kWrong = kLight + 3,  ///< not 0: a tet came after one that is behind it
    kFields
  };

  int x0 = 0, y0 = 0;
  AskedBlocks asked;
  bool bounded = false;  ///< kEnd counts
  alignas(64) float numbers[kFields * kPixels];

  /// Where a pixel's numbers begin; those of its block are kBlockPixels apart.
  static int index(int x, int y) {
    constexpr int kBlock = TetTile::kBlock;
    return kFields * kBlockPixels * (y / kBlock * kBlocks + x / kBlock) + y % kBlock * kBlock +
           x % kBlock;
  }

  float* at(int field, int pixel) { return numbers + field * kBlockPixels + pixel; }

  /// All numbers of a block as before the first tet, but for kEnd and kScale.
  void clear(int blockX, int blockY) {
    const int block = kFields * kBlockPixels * (blockY * kBlocks + blockX);
    std::fill_n(at(0, block), kFields * kBlockPixels, 0.0F);
    std::fill_n(at(kLast, block), kBlockPixels, 1e37F);
    std::fill_n(at(kPassed, block), kBlockPixels, 1.0F);
  }
};

/// Adds tets to a tile, front to back. `size` [m]: of the mesh.
void lightTets(const ScreenView& view, const LitMesh& mesh, std::span<const BinnedTet> list,
               float size, LitTile& tile);

/// What pieces of smoke do to light, by their mean depths d = (d0 + d1) / 2 and half what they rise
/// along the ray, c = (d1 - d0) / 2: the share that is lost, w0 + w1, and (w1 - w0) / 2, with the
/// weights of Staubli et al. 2005, equations 6 to 9. For tests.
void pieceLosses(std::span<const float> d, std::span<const float> c, std::span<float> lost,
                 std::span<float> lean);

}  // namespace volute
