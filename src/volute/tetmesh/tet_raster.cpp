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
using DI = hn::RebindToSigned<DF>;
using Mask = hn::Mask<DF>;
constexpr DF df;
constexpr DI di;
constexpr int kBlock = TetTile::kBlock;
constexpr int kPixels = kBlock * kBlock;
constexpr float kEye = 1e-18F;  // [m]; the depth where rays begin

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

/// Four products at once: a function a . x + b of space over a tile's pixels is (a, b) times one of
/// these matrices, in double.
struct alignas(32) RowMatrix {
  double rows[4][4];
};

/// A tile's rays.
struct TileRays {
  RowMatrix plane;  ///< of a FacePlane: the bound times its divisor at the first pixel, its steps
                    ///< along x and y, the divisor
  RowMatrix smoke;  ///< of a TetSmoke: perspective: slope along the depth, three as above, and the
                    ///< extinction at the eye; orthographic: the extinction at depth 0, three, and
                    ///< the slope

  TileRays(const ScreenView& view, const TetTile& tile) {
    const Vec3 right = view.right / view.perPixel, down = view.down / view.perPixel;
    const double x = tile.x0 + 0.5 - 0.5 * view.width, y = tile.y0 + 0.5 - 0.5 * view.height;
    const Vec3 first = x * right + y * down + (view.orthographic ? view.eye : view.forward);
    for (int k = 0; k < 3; ++k) {
      const double steps[3] = {first[k], right[k], down[k]};
      for (int i = 0; i < 3; ++i) plane.rows[k][i] = smoke.rows[k][i] = steps[i];
      plane.rows[k][3] = view.orthographic ? view.forward[k] : -view.eye[k];
      smoke.rows[k][3] = view.orthographic ? view.forward[k] : view.eye[k];
    }
    for (int i = 0; i < 4; ++i) {
      plane.rows[3][i] = view.orthographic ? -(i == 0) : i == 3;
      smoke.rows[3][i] = view.orthographic ? i == 0 : i == 3;
    }
  }
};

HWY_INLINE void Multiply(const double* by, const RowMatrix& matrix, double* out) {
  constexpr hn::CappedTag<double, 4> dd;
  for (std::size_t i = 0; i < 4; i += hn::Lanes(dd)) {
    auto sum = hn::Mul(hn::Set(dd, by[0]), hn::Load(dd, matrix.rows[0] + i));
    for (int k = 1; k < 4; ++k)
      sum = hn::MulAdd(hn::Set(dd, by[k]), hn::Load(dd, matrix.rows[k] + i), sum);
    hn::Store(sum, dd, out + i);
  }
}

/// Both tets at a face find the same bound, bit by bit: what one of them is too long the other is
/// too short.
HWY_INLINE void SetBounds(const TileRays& rays, const SplatMesh& mesh, std::int32_t tet,
                          TetBounds& out) {
  constexpr double kLeast = 1e-12;  // an eye in a face's plane
  int lows = 0, highs = 4;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t face = mesh.faces[4 * static_cast<std::int64_t>(tet) + k];
    alignas(32) double all[4];
    Multiply(mesh.planes[face >> 1].normal.data(), rays.plane, all);
    const bool before = all[3] > 0;
    const bool low = before == ((face & 1) == 0);
    const double by = 1 / (before ? std::max(all[3], kLeast) : std::min(all[3], -kLeast));
    highs -= !low;
    out.bound[low ? lows : highs] = {static_cast<float>(all[0] * by),
                                     static_cast<float>(all[1] * by),
                                     static_cast<float>(all[2] * by)};
    lows += low;
  }
  out.lows = lows;
}

template <bool kOrthographic>
HWY_INLINE void SetField(const TileRays& rays, const SplatMesh& mesh, const BinnedTet& tet,
                         TetBounds& out) {
  constexpr float kAround = 1e-6F, kNear = 1e-6F;
  const double z0 = tet.nearest;
  alignas(32) double all[4];
  Multiply(mesh.smoke[tet.tet].gradient.data(), rays.smoke, all);
  out.z0 = tet.nearest;
  if constexpr (kOrthographic) {
    const float around = kAround * std::max(std::abs(tet.nearest), std::abs(tet.farthest));
    out.lowest = -tet.farthest - around;
    out.highest = -tet.nearest + around;
    out.tau = {static_cast<float>(all[0] + z0 * all[3]), static_cast<float>(all[1]),
               static_cast<float>(all[2])};
    out.slope = {static_cast<float>(all[3]), 0, 0};
  } else {
    out.lowest = (1 - kAround) / std::max(tet.farthest, kNear);
    out.highest = (1 + kAround) / std::max(tet.nearest, kEye);
    out.tau = {static_cast<float>(all[3] + z0 * all[0]), static_cast<float>(z0 * all[1]),
               static_cast<float>(z0 * all[2])};
    out.slope = {static_cast<float>(all[0]), static_cast<float>(all[1]),
                 static_cast<float>(all[2])};
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

/// Which blocks of each row of blocks a tet may touch, from `first` to `last`.
struct RowSpans {
  alignas(64) std::int32_t first[TetTile::kBlocks];
  alignas(64) std::int32_t last[TetTile::kBlocks];
};

/// From the tet's silhouette: a pixel is inside where each upper bound is above each lower one,
/// which is a side of a line.
template <int kLows>
HWY_INLINE void SetSpans(const TetBounds& tet, const BinnedTet& blocks, RowSpans& spans) {
  constexpr int kLines = kLows * (4 - kLows);
  constexpr float kFar = 1e6F, kLeast = 1e-30F, kMargin = 1e-6F, kFlat = 1e-3F;
  constexpr float kReach = kBlock - 1;
  Affine begins[kLines + 1], ends[kLines + 1];  // in blocks, `y` for a row of them
  for (int line = 0; line < kLines; ++line) {
    const Affine& low = tet.bound[line / (4 - kLows)];
    const Affine& high = tet.bound[kLows + line % (4 - kLows)];
    const float x = high.x - low.x, y = high.y - low.y;
    const float rounding = kMargin * (std::abs(high.at) + std::abs(low.at) +
                                      TetTile::kSide * (std::abs(high.x) + std::abs(low.x) +
                                                        std::abs(high.y) + std::abs(low.y)));
    const float at = high.at - low.at + std::max(0.0F, kReach * y) + rounding;
    const bool begin = x > 0;
    const float least = kFlat * rounding + kLeast;
    const float by = -1 / (begin ? std::max(x, least) : std::min(x, -least));
    const float from = at * by / kBlock, step = y * by;
    begins[line] = {begin ? from - kReach / kBlock : -kFar, 0, begin ? step : 0};
    ends[line] = {begin ? kFar : from, 0, begin ? 0 : step};
  }
  for (int row = 0; row < TetTile::kBlocks; row += static_cast<int>(hn::Lanes(df))) {
    const VF y = hn::ConvertTo(df, hn::Iota(di, row));
    VF first = Constant(blocks.x0), last = Constant(blocks.x1);
    for (int line = 0; line < kLines; ++line) {
      first = hn::Max(first, hn::MulAdd(y, Constant(begins[line].y), Constant(begins[line].at)));
      last = hn::Min(last, hn::MulAdd(y, Constant(ends[line].y), Constant(ends[line].at)));
    }
    first = hn::Min(first, Constant(kFar)), last = hn::Max(last, Constant(-1));
    hn::Store(hn::ConvertTo(di, hn::Ceil(first)), di, spans.first + row);
    hn::Store(hn::ConvertTo(di, last), di, spans.last + row);
  }
}

/// Adds a tet to the pixels of a block, or to the first of them.
template <int kLows, bool kOrthographic>
HWY_INLINE void AddTet(const TetBounds& tet, const BinnedTet& blocks, const float* columns,
                       const float* rows, TetTile& tile) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));
  RowSpans spans;
  SetSpans<kLows>(tet, blocks, spans);
  const VF lowest = Constant(tet.lowest), highest = Constant(tet.highest), z0 = Constant(tet.z0);
  for (int y = blocks.y0; y <= blocks.y1; ++y) {
    for (int part = 0; part < kPixels; part += kLanes) {
      const VF dy = hn::Load(df, rows + y * kPixels + part);
      const Row b0(tet.bound[0], dy), b1(tet.bound[1], dy), b2(tet.bound[2], dy),
          b3(tet.bound[3], dy);
      const Row taus(tet.tau, dy), slopes(tet.slope, dy);
      for (int x = spans.first[y]; x <= spans.last[y]; ++x) {
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
HWY_INLINE void Prefetch(const SplatMesh& mesh, std::span<const BinnedTet> list, std::size_t i) {
  constexpr std::size_t kSoon = 4, kLater = 8;
  if (i + kLater >= list.size())
    return;
  const auto later = static_cast<std::int64_t>(list[i + kLater].tet);
  hwy::Prefetch(mesh.faces + 4 * later);
  hwy::Prefetch(mesh.smoke + later);
  const auto soon = static_cast<std::int64_t>(list[i + kSoon].tet);
  for (int k = 0; k < 4; ++k) hwy::Prefetch(&mesh.planes[mesh.faces[4 * soon + k] >> 1]);
}

/// Where the pixels of a row and of a column of blocks are in the tile.
struct BlockPixels {
  alignas(64) float columns[TetTile::kBlocks * kPixels];
  alignas(64) float rows[TetTile::kBlocks * kPixels];

  BlockPixels() {
    for (int i = 0; i < TetTile::kBlocks * kPixels; ++i) {
      columns[i] = static_cast<float>(i / kPixels * kBlock + i % kBlock);
      rows[i] = static_cast<float>(i / kPixels * kBlock + i % kPixels / kBlock);
    }
  }
};

template <bool kOrthographic>
void SplatAll(const TileRays& rays, const SplatMesh& mesh, std::span<const BinnedTet> list,
              TetTile& tile) {
  static const BlockPixels pixels;
  const float *columns = pixels.columns, *rows = pixels.rows;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Prefetch(mesh, list, i);
    const BinnedTet& binned = list[i];
    TetBounds tet;
    SetBounds(rays, mesh, binned.tet, tet);
    SetField<kOrthographic>(rays, mesh, binned, tet);
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
  if (list.empty())
    return;
  const TileRays rays(view, tile);
  if (view.orthographic)
    SplatAll<true>(rays, mesh, list, tile);
  else
    SplatAll<false>(rays, mesh, list, tile);
}

void SpanTets(const ScreenView& view, const SplatVertex* vertices, std::span<const Tet> tets,
              TetSpan* spans) {
  constexpr hn::CappedTag<float, 4> d4;
  constexpr hn::RebindToSigned<decltype(d4)> i4;
  constexpr float kMargin = 2e-3F;  // [pixels]; rounding of the projection
  const auto cx = static_cast<float>(view.originX - 0.5),
             cy = static_cast<float>(view.originY - 0.5);
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

HWY_EXPORT(ReadTile);
HWY_EXPORT(SpanTets);
HWY_EXPORT(SplatTets);

}  // namespace

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
