// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_raster.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tetmesh/tet_raster.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using VF = hn::Vec<DF>;
using Mask = hn::Mask<DF>;
constexpr DF df;
constexpr int kBlock = TetTile::kBlock;
constexpr int kPixels = kBlock * kBlock;

HWY_INLINE VF Constant(float x) {
  return hn::Set(df, x);
}

/// 1 / x but for the last bit or two.
HWY_INLINE VF Reciprocal(VF x) {
  const VF guess = hn::ApproximateReciprocal(x);
  return hn::Mul(guess, hn::NegMulAdd(x, guess, Constant(2)));
}

/// at + x dx + y dy, dx and dy in pixels from the tile's first.
struct Affine {
  float at, x, y;
};

/// A tet over a tile. A pixel's ray is inside while its inverse depth (orthographic: minus its
/// depth) is above the first `lows` bounds and below the others: each is affine over the picture.
struct TetBounds {
  Affine bound[4];
  int lows = 0;
  float lowest, highest;  // of the vertices
  Affine tau;             // extinction at depth `z0`
  Affine slope;           // of the extinction along the depth
  float z0;
};

/// A tile's rays, in double.
struct TileRays {
  Vec3 eye, right, down;  // one pixel
  Vec3 first;             // perspective: direction of the first pixel; else its origin
  Vec3 forward;
  bool orthographic;

  TileRays(const ScreenView& view, const TetTile& tile)
      : eye(view.eye),
        right(view.right / view.perPixel),
        down(view.down / view.perPixel),
        forward(view.forward),
        orthographic(view.orthographic) {
    const double x = tile.x0 + 0.5 - 0.5 * view.width, y = tile.y0 + 0.5 - 0.5 * view.height;
    first = x * right + y * down + (orthographic ? eye : forward);
  }
};

HWY_INLINE double Dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

HWY_INLINE Affine Scaled(double at, double x, double y, double by) {
  return {static_cast<float>(at * by), static_cast<float>(x * by), static_cast<float>(y * by)};
}

/// Both tets at a face find the same bound, bit by bit: what one of them is too long the other is
/// too short.
HWY_INLINE void SetBounds(const TileRays& rays, const SplatMesh& mesh, std::int32_t tet,
                          TetBounds& out) {
  constexpr double kLeast = 1e-12;  // an eye in a face's plane
  Affine bounds[4];
  bool low[4];
  for (int k = 0; k < 4; ++k) {
    const std::int32_t face = mesh.faces[4 * static_cast<std::int64_t>(tet) + k];
    const FacePlane& plane = mesh.planes[face >> 1];
    const double x = Dot(plane.normal, rays.right), y = Dot(plane.normal, rays.down);
    const double first = Dot(plane.normal, rays.first);
    double divisor = rays.orthographic ? Dot(plane.normal, rays.forward)
                                       : plane.offset - Dot(plane.normal, rays.eye);
    low[k] = (divisor > 0) == ((face & 1) == 0);
    if (std::abs(divisor) < kLeast)
      divisor = divisor > 0 ? kLeast : -kLeast;
    bounds[k] = Scaled(rays.orthographic ? first - plane.offset : first, x, y, 1 / divisor);
  }
  int lows = 0, highs = 4;
  for (int k = 0; k < 4; ++k) out.bound[low[k] ? lows++ : --highs] = bounds[k];
  out.lows = lows;
}

HWY_INLINE void SetField(const TileRays& rays, const SplatMesh& mesh, std::int32_t tet,
                         TetBounds& out) {
  const std::int32_t* corners = mesh.tets + 4 * static_cast<std::int64_t>(tet);
  float nearest = mesh.depth[corners[0]], farthest = nearest;
  for (int k = 1; k < 4; ++k) {
    nearest = std::min(nearest, mesh.depth[corners[k]]);
    farthest = std::max(farthest, mesh.depth[corners[k]]);
  }
  constexpr float kAround = 1e-6F;
  if (rays.orthographic) {
    const float around = kAround * std::max(std::abs(nearest), std::abs(farthest));
    out.lowest = -farthest - around;
    out.highest = -nearest + around;
  } else {
    out.lowest = (1 - kAround) / farthest;
    out.highest = nearest > 0 ? (1 + kAround) / nearest : 1e30F;
  }
  const float* g = mesh.gradient + 3 * static_cast<std::int64_t>(tet);
  const Vec3 gradient(g[0], g[1], g[2]);
  const Vec3 corner = mesh.vertices[corners[0]] - rays.eye;
  const double z0 = Dot(corner, rays.forward);
  const double x = Dot(gradient, rays.right), y = Dot(gradient, rays.down);
  const double across = rays.orthographic ? 1 : z0;
  const double tau0 = mesh.extinction[corners[0]] - Dot(gradient, corner);
  out.z0 = static_cast<float>(z0);
  if (rays.orthographic) {
    const double slope = Dot(gradient, rays.forward);
    const double first = Dot(gradient, rays.first) - Dot(gradient, rays.eye);
    out.tau = {static_cast<float>(tau0 + first + z0 * slope), static_cast<float>(across * x),
               static_cast<float>(across * y)};
    out.slope = {static_cast<float>(slope), 0, 0};
  } else {
    const double slope = Dot(gradient, rays.first);
    out.tau = {static_cast<float>(tau0 + z0 * slope), static_cast<float>(across * x),
               static_cast<float>(across * y)};
    out.slope = {static_cast<float>(slope), static_cast<float>(x), static_cast<float>(y)};
  }
}

/// An affine function along a row of pixels.
struct Row {
  VF flat, slope;

  HWY_INLINE Row() = default;

  HWY_INLINE Row(const Affine& plane, VF dy)
      : flat(hn::MulAdd(dy, Constant(plane.y), Constant(plane.at))), slope(Constant(plane.x)) {}

  HWY_INLINE VF at(VF dx) const { return hn::MulAdd(dx, slope, flat); }
};

template <int kLows, bool kOrthographic>
HWY_INLINE void AddTet(const TetBounds& tet, const BinnedTet& blocks, const float* columns,
                       const float* rows, TetTile& tile) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));
  const VF lowest = Constant(tet.lowest), highest = Constant(tet.highest), z0 = Constant(tet.z0);
  for (int part = 0; part < kPixels; part += kLanes) {
    for (int y = blocks.y0; y <= blocks.y1; ++y) {
      const VF dy = hn::Load(df, rows + y * kPixels + part);
      const Row b0(tet.bound[0], dy), b1(tet.bound[1], dy), b2(tet.bound[2], dy),
          b3(tet.bound[3], dy);
      const Row taus(tet.tau, dy), slopes(tet.slope, dy);
      for (int x = blocks.x0; x <= blocks.x1; ++x) {
        const VF dx = hn::Load(df, columns + x * kPixels + part);
        VF low = hn::Max(lowest, b0.at(dx)), high = highest;
        if constexpr (kLows > 1)
          low = hn::Max(low, b1.at(dx));
        else
          high = hn::Min(high, b1.at(dx));
        if constexpr (kLows > 2)
          low = hn::Max(low, b2.at(dx));
        else
          high = hn::Min(high, b2.at(dx));
        if constexpr (kLows > 3)
          low = hn::Max(low, b3.at(dx));
        else
          high = hn::Min(high, b3.at(dx));
        const int at = (y * TetTile::kBlocks + x) * kPixels + part;
        if (tile.bounded)
          low = hn::Max(low, hn::Load(df, tile.end + at));
        const Mask inside = hn::Gt(high, low);
        if (hn::AllFalse(df, inside))
          continue;
        const VF begin = kOrthographic ? hn::Neg(high) : Reciprocal(high);
        const VF end = kOrthographic ? hn::Neg(low) : Reciprocal(low);
        const VF middle = hn::MulSub(Constant(0.5F), hn::Add(begin, end), z0);
        const VF mean = hn::MulAdd(middle, slopes.at(dx), taus.at(dx));
        const VF depth = hn::Mul(hn::Sub(end, begin), mean);
        float* sum = tile.sum + at;
        hn::Store(hn::Add(hn::Load(df, sum), hn::IfThenElseZero(inside, depth)), df, sum);
      }
    }
  }
}

/// What the tets after the next need: they lie anywhere in memory.
HWY_INLINE void Prefetch(const SplatMesh& mesh, std::span<const BinnedTet> list, std::size_t i) {
  constexpr std::size_t kSoon = 4, kLater = 8;
  if (i + kLater >= list.size())
    return;
  const auto later = static_cast<std::int64_t>(list[i + kLater].tet);
  hwy::Prefetch(mesh.tets + 4 * later);
  hwy::Prefetch(mesh.faces + 4 * later);
  hwy::Prefetch(mesh.gradient + 3 * later);
  const auto soon = static_cast<std::int64_t>(list[i + kSoon].tet);
  for (int k = 0; k < 4; ++k) {
    hwy::Prefetch(&mesh.planes[mesh.faces[4 * soon + k] >> 1]);
    hwy::Prefetch(&mesh.depth[mesh.tets[4 * soon + k]]);
  }
  hwy::Prefetch(&mesh.vertices[mesh.tets[4 * soon]]);
  hwy::Prefetch(&mesh.extinction[mesh.tets[4 * soon]]);
}

template <bool kOrthographic>
void SplatAll(const TileRays& rays, const SplatMesh& mesh, std::span<const BinnedTet> list,
              TetTile& tile) {
  alignas(64) float columns[TetTile::kBlocks * kPixels], rows[TetTile::kBlocks * kPixels];
  for (int i = 0; i < TetTile::kBlocks * kPixels; ++i) {
    columns[i] = static_cast<float>(i / kPixels * kBlock + i % kBlock);
    rows[i] = static_cast<float>(i / kPixels * kBlock + i % kPixels / kBlock);
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    Prefetch(mesh, list, i);
    const BinnedTet& binned = list[i];
    TetBounds tet;
    SetBounds(rays, mesh, binned.tet, tet);
    SetField(rays, mesh, binned.tet, tet);
    switch (tet.lows) {
      case 1:
        AddTet<1, kOrthographic>(tet, binned, columns, rows, tile);
        break;
      case 2:
        AddTet<2, kOrthographic>(tet, binned, columns, rows, tile);
        break;
      case 3:
        AddTet<3, kOrthographic>(tet, binned, columns, rows, tile);
        break;
      case 4:
        AddTet<4, kOrthographic>(tet, binned, columns, rows, tile);
        break;
      default:  // no point lies beyond all four faces
        break;
    }
  }
}

void SplatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile) {
  const TileRays rays(view, tile);
  if (view.orthographic)
    SplatAll<true>(rays, mesh, list, tile);
  else
    SplatAll<false>(rays, mesh, list, tile);
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(SplatTets);

}  // namespace

void splatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile) {
  HWY_DYNAMIC_DISPATCH(SplatTets)(view, mesh, list, tile);
}

}  // namespace volute
#endif  // HWY_ONCE
