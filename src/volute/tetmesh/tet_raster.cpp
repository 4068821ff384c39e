// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_raster.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tetmesh/tet_raster.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "volute/tetmesh/tet_bounds-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

/// Adds a tet's depth to the pixels that it touches.
template <int kLows, bool kOrthographic>
HWY_NOINLINE void AddTet(const TetBounds& tet, const TetRamp& tau, const BinnedTet& blocks,
                         const float* columns, const float* rows, TetTile& tile) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));
  RowSpans spans;
  SetSpans<kLows>(tet, blocks, spans);
  const VF z0 = Constant(blocks.nearest);
  for (int y = blocks.y0; y <= blocks.y1; ++y) {
    for (int part = 0; part < kPixels; part += kLanes) {
      const VF dy = hn::Load(df, rows + y * kPixels + part);
      const BoundRows<kLows> bounds(tet, dy);
      const Row taus(tau.value, dy), slopes(tau.slope, dy);
      for (int x = spans.first[y]; x <= spans.last[y]; ++x) {
        if (!tile.asked.has(x, y))
          continue;
        const VF dx = hn::Load(df, columns + x * kPixels + part);
        VF low, high;
        bounds.at(dx, low, high);
        const int at = (y * TetTile::kBlocks + x) * kPixels + part;
        if (tile.bounded)
          low = hn::Max(low, hn::Load(df, tile.end + at));
        const VF width = hn::Sub(high, low), twice = hn::Add(high, low);
        VF middle, length;
        if constexpr (kOrthographic) {
          middle = hn::MulSub(Constant(-0.5F), twice, z0);
          length = width;
        } else {
          const VF per = Reciprocal(hn::Mul(high, low));
          middle = hn::MulSub(Constant(0.5F), hn::Mul(twice, per), z0);
          length = hn::Mul(width, per);
        }
        const VF mean = hn::MulAdd(middle, slopes.at(dx), taus.at(dx));
        const Mask inside = hn::Gt(width, hn::Zero(df));
        float* sum = tile.sum + at;
        hn::Store(hn::Add(hn::Load(df, sum), hn::IfThenElseZero(inside, hn::Mul(length, mean))), df,
                  sum);
      }
    }
  }
}

/// What the tets after the next need: they lie anywhere in memory.
template <bool kKept>
HWY_INLINE void Prefetch(const SplatMesh& mesh, std::span<const BinnedTet> list, std::size_t i) {
  constexpr std::size_t kSoon = 4, kLater = 8;
  if (i + kLater >= list.size())
    return;
  const auto later = static_cast<std::int64_t>(list[i + kLater].tet);
  hwy::Prefetch(mesh.smoke + later);
  PrefetchPlanes<kKept>(mesh, list[i + kSoon].tet, list[i + kLater].tet);
}

template <bool kOrthographic, bool kKept>
void SplatAll(const TileRays& rays, const SplatMesh& mesh, std::span<const BinnedTet> list,
              TetTile& tile) {
  static const BlockPixels pixels;
  const float *columns = pixels.columns, *rows = pixels.rows;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Prefetch<kKept>(mesh, list, i);
    const BinnedTet& binned = list[i];
    TetBounds tet;
    SetBounds<kOrthographic, kKept>(rays, mesh, binned.tet, tet);
    SetRange<kOrthographic>(binned, tet);
    const TetRamp tau = RampOf<kOrthographic>(rays, mesh.smoke[binned.tet], binned.nearest);
    switch (tet.lows) {
      case 1:
        AddTet<1, kOrthographic>(tet, tau, binned, columns, rows, tile);
        break;
      case 2:
        AddTet<2, kOrthographic>(tet, tau, binned, columns, rows, tile);
        break;
      case 3:
        AddTet<3, kOrthographic>(tet, tau, binned, columns, rows, tile);
        break;
      case 4:
        AddTet<4, kOrthographic>(tet, tau, binned, columns, rows, tile);
        break;
      default:  // no point lies beyond all four faces
        break;
    }
  }
}

void SplatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile) {
  if (list.empty())
    return;
  const TileRays rays(view, tile.x0, tile.y0);
  if (view.orthographic)
    SplatAll<true, false>(rays, mesh, list, tile);
  else if (mesh.eyeTets != nullptr)
    SplatAll<false, true>(rays, mesh, list, tile);
  else
    SplatAll<false, false>(rays, mesh, list, tile);
}

void FindEyeTets(const ScreenView& view, const SplatMesh& mesh, std::size_t first,
                 std::span<EyeTet> eyeTets, std::span<std::uint8_t> lows) {
  const TileRays rays(view, 0, 0);
  for (std::size_t i = 0; i < eyeTets.size(); ++i)
    lows[i] = SetEyeTet(rays, mesh, static_cast<std::int32_t>(first + i), eyeTets[i]);
}

void SpanTets(const ScreenView& view, const SplatVertex* vertices, std::span<const Tet> tets,
              TetSpan* spans) {
  constexpr hn::CappedTag<float, 4> d4;
  constexpr hn::RebindToSigned<decltype(d4)> i4;
  constexpr float kMargin = 2e-3F;  // [pixels]; rounding of the projection
  const auto cx = static_cast<float>(0.5 * view.width - 0.5),
             cy = static_cast<float>(0.5 * view.height - 0.5);
  const auto width = static_cast<float>(view.width), height = static_cast<float>(view.height);
  alignas(16) const float shift[4] = {cx + kMargin, cy + kMargin, kMargin - cx, kMargin - cy};
  alignas(16) const float least[4] = {-1, -1, -width, -height};
  alignas(16) const float most[4] = {width - 1, height - 1, 0, 0};
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const float* v[4];
    for (int k = 0; k < 4; ++k) v[k] = &vertices[tets[t][k]].x;
    const auto largest = [&](std::size_t i) {
      return hn::Max(hn::Max(hn::Load(d4, v[0] + i), hn::Load(d4, v[1] + i)),
                     hn::Max(hn::Load(d4, v[2] + i), hn::Load(d4, v[3] + i)));
    };
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d4)) {
      const auto seen = hn::Add(largest(i), hn::Load(d4, shift + i));
      const auto inside = hn::Min(hn::Max(seen, hn::Load(d4, least + i)), hn::Load(d4, most + i));
      hn::Store(hn::ConvertTo(i4, hn::Floor(inside)), i4, &spans[t].x1 + i);
      hn::Store(largest(4 + i), d4, &spans[t].farthest + i);
    }
  }
}

void ReadTile(const ScreenView& view, const TetTile& tile, float* picture) {
  constexpr hn::CappedTag<float, kBlock> d4;
  alignas(16) float depths[kBlock];
  const int width = std::min(TetTile::kSide, view.width - tile.x0);
  const int height = std::min(TetTile::kSide, view.height - tile.y0);
  const double per = view.orthographic ? 0 : 1 / (view.perPixel * view.perPixel);
  for (int y = 0; y < height; ++y) {
    const double py = tile.y0 + y + 0.5 - 0.5 * view.height;
    const auto flat = hn::Set(d4, static_cast<float>(1 + py * py * per));
    const auto across = hn::Set(d4, static_cast<float>(per));
    float* row = picture + static_cast<std::size_t>(tile.y0 + y) * view.width + tile.x0;
    for (int x = 0; x < width; x += kBlock) {
      if (!tile.asked.has(x / kBlock, y / kBlock))
        continue;
      const float* sums = tile.sum + TetTile::index(x, y);
      const auto first = static_cast<float>(tile.x0 + x + 0.5 - 0.5 * view.width);
      for (int i = 0; i < kBlock; i += static_cast<int>(hn::Lanes(d4))) {
        const auto px = hn::Iota(d4, first + static_cast<float>(i));
        const auto scale = hn::Sqrt(hn::MulAdd(hn::Mul(px, px), across, flat));
        const auto depth = hn::Mul(hn::Load(d4, sums + i), scale);
        hn::Store(hn::Max(depth, hn::Zero(d4)), d4, depths + i);
      }
      std::copy_n(depths, std::min(kBlock, width - x), row + x);
    }
  }
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(FindEyeTets);
HWY_EXPORT(ReadTile);
HWY_EXPORT(SpanTets);
HWY_EXPORT(SplatTets);

}  // namespace

void findEyeTets(const ScreenView& view, const SplatMesh& mesh, std::size_t first,
                 std::span<EyeTet> eyeTets, std::span<std::uint8_t> lows) {
  HWY_DYNAMIC_DISPATCH(FindEyeTets)(view, mesh, first, eyeTets, lows);
}

void spanTets(const ScreenView& view, const SplatVertex* vertices, std::span<const Tet> tets,
              TetSpan* spans) {
  HWY_DYNAMIC_DISPATCH(SpanTets)(view, vertices, tets, spans);
}

void readTile(const ScreenView& view, const TetTile& tile, float* picture) {
  HWY_DYNAMIC_DISPATCH(ReadTile)(view, tile, picture);
}

void splatTets(const ScreenView& view, const SplatMesh& mesh, std::span<const BinnedTet> list,
               TetTile& tile) {
  HWY_DYNAMIC_DISPATCH(SplatTets)(view, mesh, list, tile);
}

}  // namespace volute
#endif  // HWY_ONCE
