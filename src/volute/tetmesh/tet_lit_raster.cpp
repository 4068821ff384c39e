// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_lit_raster.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tetmesh/tet_lit_raster.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "volute/tetmesh/segment_weights-inl.hpp"
#include "volute/tetmesh/tet_bounds-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

/// A ramp along a row of pixels.
struct RampRow {
  Row value, slope;

  HWY_INLINE RampRow() = default;

  HWY_INLINE RampRow(const TetRamp& ramp, VF dy) : value(ramp.value, dy), slope(ramp.slope, dy) {}
};

/// A tet's extinction and source over a tile, at the depth `z0` and onwards.
struct LitRamps {
  TetRamp tau, source[3];
  float z0;
};

template <bool kOrthographic>
HWY_INLINE LitRamps RampsOf(const TileRays& rays, const LitMesh& mesh, const BinnedTet& tet) {
  LitRamps ramps;
  ramps.z0 = tet.nearest;
  ramps.tau = RampOf<kOrthographic>(rays, mesh.splat.smoke[tet.tet], ramps.z0);
  const TetSource& source = mesh.sources[tet.tet];
  const Vec3& at = mesh.vertices[mesh.tets[tet.tet][0]];
  for (int c = 0; c < 3; ++c) {
    const float* g = source.gradient[c];
    LinearField field{Vec3(g[0], g[1], g[2]), 0};
    field.offset = source.value[c] - (field.gradient[0] * at[0] + field.gradient[1] * at[1] +
                                      field.gradient[2] * at[2]);
    ramps.source[c] = RampOf<kOrthographic>(rays, field, ramps.z0);
  }
  return ramps;
}

/// How far a tet may begin before the end of those added: rounding.
struct Tolerance {
  float scale, plus;
};

/// The segment of each lane's ray that lies in a tet; empty where the ray misses it.
struct RaySegment {
  Mask inside;
  VF low, high, middle, length;  ///< middle from z0 on; length in depth
};

template <bool kOrthographic>
HWY_INLINE RaySegment RaySegmentIn(VF low, VF high, VF z0) {
  const VF width = hn::Sub(high, low), twice = hn::Add(high, low);
  RaySegment segment{hn::Gt(width, hn::Zero(df)), low, high, {}, {}};
  VF length;
  if constexpr (kOrthographic) {
    segment.middle = hn::MulSub(Constant(-0.5F), twice, z0);
    length = width;
  } else {
    const VF per = Reciprocal(hn::Mul(high, low));
    segment.middle = hn::MulSub(Constant(0.5F), hn::Mul(twice, per), z0);
    length = hn::Mul(width, per);
  }
  segment.middle = hn::IfThenElseZero(segment.inside, segment.middle);
  segment.length = hn::IfThenElseZero(segment.inside, length);
  return segment;
}

/// Adds what a vector of pixels sees of a tet.
HWY_INLINE void AddLight(const RaySegment& segment, const RampRow& tau, const RampRow (&source)[3],
                         VF dx, Tolerance tolerance, int at, LitTile& tile) {
  const VF last = hn::Load(df, tile.at(LitTile::kLast, at));
  const Mask wrong = hn::And(
      segment.inside,
      hn::Gt(segment.high, hn::MulAdd(last, Constant(tolerance.scale), Constant(tolerance.plus))));
  if (!hn::AllFalse(df, wrong))
    hn::Store(hn::IfThenElse(wrong, Constant(1), hn::Load(df, tile.at(LitTile::kWrong, at))), df,
              tile.at(LitTile::kWrong, at));
  hn::Store(hn::IfThenElse(segment.inside, segment.low, last), df, tile.at(LitTile::kLast, at));
  const VF length = hn::Mul(segment.length, hn::Load(df, tile.at(LitTile::kScale, at)));
  const VF slope = tau.slope.at(dx);
  const VF mean = hn::MulAdd(segment.middle, slope, tau.value.at(dx));
  const VF whole = hn::Max(hn::Mul(mean, length), hn::Zero(df));
  const VF rise = hn::Mul(hn::Mul(segment.length, Constant(0.5F)), hn::Mul(slope, length));
  VF lean;
  const VF lost = LostAndLean(whole, rise, lean);
  const VF passed = hn::Load(df, tile.at(LitTile::kPassed, at));
  const VF both = hn::Mul(lost, passed);
  const VF along = hn::MulAdd(segment.middle, both, hn::Mul(hn::Mul(segment.length, passed), lean));
  for (int c = 0; c < 3; ++c) {
    float* light = tile.at(LitTile::kLight + c, at);
    const VF sent = hn::MulAdd(along, source[c].slope.at(dx),
                               hn::MulAdd(both, source[c].value.at(dx), hn::Load(df, light)));
    hn::Store(sent, df, light);
  }
  hn::Store(hn::Sub(passed, both), df, tile.at(LitTile::kPassed, at));
}

template <int kLows, bool kOrthographic>
HWY_NOINLINE void LightTet(const TetBounds& tet, const LitRamps& ramps, const BinnedTet& blocks,
                           const BlockPixels& pixels, Tolerance tolerance, LitTile& tile) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));
  RowSpans spans;
  SetSpans<kLows>(tet, blocks, spans);
  const VF z0 = Constant(ramps.z0);
  for (int y = blocks.y0; y <= blocks.y1; ++y) {
    for (int part = 0; part < kPixels; part += kLanes) {
      const VF dy = hn::Load(df, pixels.rows + y * kPixels + part);
      const BoundRows<kLows> bounds(tet, dy);
      const RampRow tau(ramps.tau, dy);
      const RampRow source[3] = {
          {ramps.source[0], dy}, {ramps.source[1], dy}, {ramps.source[2], dy}};
      for (int x = spans.first[y]; x <= spans.last[y]; ++x) {
        if (!tile.asked.has(x, y))
          continue;
        const VF dx = hn::Load(df, pixels.columns + x * kPixels + part);
        const int at = LitTile::kFields * kPixels * (y * LitTile::kBlocks + x) + part;
        VF low, high;
        bounds.at(dx, low, high);
        if (tile.bounded)
          low = hn::Max(low, hn::Load(df, tile.at(LitTile::kEnd, at)));
        const RaySegment segment = RaySegmentIn<kOrthographic>(low, high, z0);
        if (!hn::AllFalse(df, segment.inside))
          AddLight(segment, tau, source, dx, tolerance, at, tile);
      }
    }
  }
}

/// What the tets after the next need: they lie anywhere in memory.
template <bool kKept>
HWY_INLINE void PrefetchLit(const LitMesh& mesh, std::span<const BinnedTet> list, std::size_t i) {
  constexpr std::size_t kSoon = 4, kLater = 8;
  if (i + kLater >= list.size())
    return;
  const auto later = static_cast<std::size_t>(list[i + kLater].tet);
  hwy::Prefetch(mesh.splat.smoke + later);
  hwy::Prefetch(mesh.sources + later);
  hwy::Prefetch(mesh.tets + later);
  PrefetchPlanes<kKept>(mesh.splat, list[i + kSoon].tet, list[i + kLater].tet);
  hwy::Prefetch(&mesh.vertices[mesh.tets[list[i + kSoon].tet][0]]);
}

template <bool kOrthographic, bool kKept>
void LightAll(const TileRays& rays, const LitMesh& mesh, std::span<const BinnedTet> list,
              Tolerance tolerance, LitTile& tile) {
  static const BlockPixels pixels;
  for (std::size_t i = 0; i < list.size(); ++i) {
    PrefetchLit<kKept>(mesh, list, i);
    TetBounds tet;
    SetBounds<kOrthographic, kKept>(rays, mesh.splat, list[i].tet, tet);
    SetRange<kOrthographic>(list[i], tet);
    const LitRamps ramps = RampsOf<kOrthographic>(rays, mesh, list[i]);
    switch (tet.lows) {
      case 1:
        LightTet<1, kOrthographic>(tet, ramps, list[i], pixels, tolerance, tile);
        break;
      case 2:
        LightTet<2, kOrthographic>(tet, ramps, list[i], pixels, tolerance, tile);
        break;
      case 3:
        LightTet<3, kOrthographic>(tet, ramps, list[i], pixels, tolerance, tile);
        break;
      case 4:
        LightTet<4, kOrthographic>(tet, ramps, list[i], pixels, tolerance, tile);
        break;
      default:  // no point lies beyond all four faces
        break;
    }
  }
}

void LightTets(const ScreenView& view, const LitMesh& mesh, std::span<const BinnedTet> list,
               float size, LitTile& tile) {
  constexpr float kRounding = 3e-5F;
  const TileRays rays(view, tile.x0, tile.y0);
  if (view.orthographic)
    LightAll<true, false>(rays, mesh, list, {1, kRounding * size}, tile);
  else if (mesh.splat.eyeTets != nullptr)
    LightAll<false, true>(rays, mesh, list, {1 + kRounding, 0}, tile);
  else
    LightAll<false, false>(rays, mesh, list, {1 + kRounding, 0}, tile);
}

/// Of kWidest pieces.
void PieceLosses(const float* d, const float* c, float* lost, float* lean) {
  for (std::size_t i = 0; i < kWidest; i += hn::Lanes(df)) {
    VF more;
    hn::StoreU(LostAndLean(hn::LoadU(df, d + i), hn::LoadU(df, c + i), more), df, lost + i);
    hn::StoreU(more, df, lean + i);
  }
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(LightTets);
HWY_EXPORT(PieceLosses);

constexpr std::size_t kMaxLanes = 16;

}  // namespace

void lightTets(const ScreenView& view, const LitMesh& mesh, std::span<const BinnedTet> list,
               float size, LitTile& tile) {
  if (!list.empty())
    HWY_DYNAMIC_DISPATCH(LightTets)(view, mesh, list, size, tile);
}

void pieceLosses(std::span<const float> d, std::span<const float> c, std::span<float> lost,
                 std::span<float> lean) {
  for (std::size_t i = 0; i < d.size(); i += kMaxLanes) {
    float in[2][kMaxLanes] = {}, out[2][kMaxLanes];
    const std::size_t count = std::min(kMaxLanes, d.size() - i);
    std::copy_n(&d[i], count, in[0]);
    std::copy_n(&c[i], count, in[1]);
    HWY_DYNAMIC_DISPATCH(PieceLosses)(in[0], in[1], out[0], out[1]);
    std::copy_n(out[0], count, &lost[i]);
    std::copy_n(out[1], count, &lean[i]);
  }
}

}  // namespace volute
#endif  // HWY_ONCE
