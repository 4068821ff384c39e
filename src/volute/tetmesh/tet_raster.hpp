// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "volute/math/vec.hpp"
#include "volute/tetmesh/face_planes.hpp"
#include "volute/tetmesh/screen.hpp"

// The inner loop of TetSplat.

namespace volute {

/// A field in a tet: gradient . x + offset.
struct LinearField {
  Vec3 gradient;
  double offset = 0;
};

/// What a perspective picture needs of the planes of a tet's faces, however it turns: the normals'
/// x, y and z, each over what its plane's function (offset - normal . x) is at the eye. Lower
/// bounds come first.
struct alignas(32) EyeTet {
  double planes[3][4];
};

/// The mesh and its smoke as the splat sees them.
struct SplatMesh {
  const std::int32_t* faces = nullptr;  ///< FacePlanes::sides
  const FacePlane* planes = nullptr;
  const LinearField* smoke = nullptr;  ///< of each tet, the extinction [1/m]
  const EyeTet* eyeTets = nullptr;     ///< of each tet, or null: found for each tile
  const std::uint8_t* lows = nullptr;  ///< of each of `eyeTets`: how many bounds are lower ones
};

/// A vertex as boxes of tets want it: the largest of four of these, number by number, is what a tet
/// spans. Its picture is at x, y [pixels from the view's origin], its depth is z [m].
struct alignas(32) SplatVertex {
  float x, y, minusX, minusY;
  float z, minusZ;
  float behind;  ///< 1: behind the eye or all but, x and y mean nothing; else 0
  float unused;
};

/// What a tet spans on the picture, ends included, and along the view.
struct alignas(32) TetSpan {
  std::int32_t x1, y1, minusX0, minusY0;
  float farthest, minusNearest, behind, unused;
};

/// A tet that may touch a tile, and the tile's blocks where it may.
struct BinnedTet {
  std::int32_t tet;
  std::uint8_t x0, y0, x1, y1;
  float nearest, farthest;  ///< of its vertices, along the view [m]
};

/// Which blocks of a tile have pixels that are asked for.
struct AskedBlocks {
  static constexpr std::uint16_t kWhole = 0xffff;
  static constexpr std::ptrdiff_t kRows = 16;

  std::array<std::uint16_t, kRows> rows{};  ///< of each row of blocks a bit for each

  bool none() const { return std::ranges::count(rows, 0) == kRows; }

  bool all() const { return std::ranges::count(rows, kWhole) == kRows; }

  bool meet(const BinnedTet& tet) const {
    const unsigned columns = (2U << tet.x1) - (1U << tet.x0);
    unsigned met = 0;
    for (int y = tet.y0; y <= tet.y1; ++y) met |= rows[static_cast<std::size_t>(y)];
    return (met & columns) != 0;
  }

  bool has(int x, int y) const { return (rows[static_cast<std::size_t>(y)] >> x & 1U) != 0; }
};

/// One square of pixels. They lie in blocks as wide as SIMD likes them; index() finds them.
struct TetTile {
  static constexpr int kSide = 64, kBlock = 4, kBlocks = kSide / kBlock;

  int x0 = 0, y0 = 0;
  AskedBlocks asked;
  bool bounded = false;                  ///< `end` counts
  alignas(64) float end[kSide * kSide];  ///< inverse depth (orthographic: minus the depth) where
                                         ///< the ray ends
  alignas(64) float sum[kSide * kSide];

  static int index(int x, int y) {
    return (y / kBlock * kBlocks + x / kBlock) * kBlock * kBlock + y % kBlock * kBlock + x % kBlock;
  }
};

/// Where tets are seen; those partly `behind` the eye by other means. Spans outside of the picture
/// are empty.
void spanTets(const ScreenView& view, const SplatVertex* vertices, std::span<const Tet> tets,
              TetSpan* spans);

/// Finds `eyeTets` and `lows` of the tets from `first` on, for the eye of a perspective view. With
/// them pictures are the same, bit by bit.
void findEyeTets(const ScreenView& view, const SplatMesh& mesh, std::size_t first,
                 std::span<EyeTet> eyeTets, std::span<std::uint8_t> lows);

/// The optical depths of a tile's blocks that are asked for, times the rays' scales, into a picture
/// as wide as the view.
void readTile(const ScreenView& view, const TetTile& tile, float* picture);

/// Adds tets to a tile: optical depth for each metre of the rays' scale.
void splatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile);

}  // namespace volute
