// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One ray in each SIMD lane.

#include "volute/media/volume/light_fan_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/media/volume/light_fan_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_records-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

/// Where rays meet the face between two cells on their way, 0..1; 1 where they stay in one.
HWY_INLINE VF CrossingOf(VF from, VF step) {
  const VF first = hn::Floor(from), last = hn::Floor(hn::Add(from, step));
  const VF share = hn::Div(hn::Sub(hn::Max(first, last), from), step);
  const VF within = hn::Min(hn::Max(share, hn::Zero(df)), Constant(1));
  return hn::IfThenElse(hn::Eq(first, last), Constant(1), within);
}

HWY_INLINE VF Between(VF a, VF b, VF share) {
  return MulThenAdd(hn::Sub(b, a), share, a);
}

struct FanLanes {
  VF b, db, c, dc, z;
  Mask active;

  /// The integral over the shares of the way between two cuts, within one cell on each plane.
  HWY_INLINE VF part(const FanPlanes& planes, VF from, VF to) const {
    const VF length = hn::Sub(to, from);
    const Mask counts = hn::And(active, hn::Gt(length, hn::Zero(df)));
    if (hn::AllFalse(df, counts))
      return hn::Zero(df);
    const VF middle = MulThenAdd(length, Constant(0.5F), from);
    const VF cellB = hn::Floor(MulThenAdd(middle, db, b));
    const VF cellC = hn::Floor(MulThenAdd(middle, dc, c));
    const VI row = hn::Add(hn::ConvertTo(di, cellB), hn::Set(di, FanPlanes::kPad));
    const VI column = hn::Add(hn::ConvertTo(di, cellC), hn::Set(di, FanPlanes::kPad));
    const VI place = hn::Add(hn::Mul(row, hn::Set(di, planes.width)), column);
    alignas(64) std::int32_t index[kWidest];
    hn::Store(hn::IfThenElseZero(ForInts(counts), hn::Add(place, place)), di, index);
    VF low[4], high[4];  // before, here, and the same of the next column
    LoadFours(planes.values.data(), index, low);
    LoadFours(planes.values.data() + 2 * planes.width, index, high);
    VF sum = hn::Zero(df);
    for (const float node : {0.21132487F, 0.78867513F}) {
      const VF t = MulThenAdd(length, Constant(node), from);
      const VF u = hn::Sub(MulThenAdd(t, db, b), cellB), v = hn::Sub(MulThenAdd(t, dc, c), cellC);
      const VF before = Between(Between(low[0], low[2], v), Between(high[0], high[2], v), u);
      const VF here = Between(Between(low[1], low[3], v), Between(high[1], high[3], v), u);
      sum = hn::Add(sum, Between(before, here, Between(z, Constant(1), t)));
    }
    return hn::IfThenElseZero(counts, hn::Mul(sum, hn::Mul(length, Constant(0.5F))));
  }
};

void AddRow(const FanPlanes& planes, const FanRow& row, std::size_t count, float scale,
            const float* lengths, float* depths) {
  const auto columns = static_cast<float>(planes.columns);
  const VF faceB = CrossingOf(Constant(row.b), Constant(row.db));
  for (std::size_t j = 0; j < count; j += hn::Lanes(df)) {
    const VF number = hn::Iota(df, static_cast<float>(j));
    FanLanes lanes;
    lanes.b = Constant(row.b), lanes.db = Constant(row.db), lanes.z = Constant(row.z);
    lanes.c = MulThenAdd(number, Constant(row.cStep), Constant(row.c));
    lanes.dc = MulThenAdd(number, Constant(row.dcStep), Constant(row.dc));
    const VF end = hn::Add(lanes.c, lanes.dc);
    lanes.active = hn::And(hn::Ge(hn::Max(lanes.c, end), Constant(-1)),
                           hn::Le(hn::Min(lanes.c, end), Constant(columns)));
    if (hn::AllFalse(df, lanes.active))
      continue;
    const VF faceC = CrossingOf(lanes.c, lanes.dc);
    const VF first = hn::Min(faceB, faceC), second = hn::Max(faceB, faceC);
    const VF mean =
        hn::Add(hn::Add(lanes.part(planes, hn::Zero(df), first), lanes.part(planes, first, second)),
                lanes.part(planes, second, Constant(1)));
    const VF length = hn::Mul(hn::Load(df, lengths + j), Constant(scale));
    hn::Store(MulThenAdd(mean, length, hn::Load(df, depths + j)), df, depths + j);
  }
}

void AddBrick(const FanBrick& brick, const FanTaps& taps, float* ray, std::size_t width) {
  const hn::CappedTag<float, FanBrick::kLanes> d;
  const int first = -taps.maxC;
  const float* from[FanTaps::kMax];
  for (std::size_t t = 0; t < taps.count; ++t) {
    const FanTap& tap = taps.taps[t];
    from[t] = brick.planes.data() + tap.plane * FanBrick::kPlane +
              (FanBrick::kPad - taps.maxB + tap.b) * FanBrick::kWidth + FanBrick::kPad + first +
              tap.c;
  }
  float* out = ray - static_cast<std::ptrdiff_t>(width) * taps.maxB + first;
  const int rows = FanBrick::kSide + taps.maxB - taps.minB;
  for (int row = 0; row < rows; ++row, out += width) {
    for (int c = 0; c < FanBrick::kLanes; c += static_cast<int>(hn::Lanes(d))) {
      auto sum = hn::LoadU(d, out + c);
      for (std::size_t t = 0; t < taps.count; ++t)
        sum = hn::Add(sum, hn::Mul(hn::Set(d, taps.taps[t].share),
                                   hn::LoadU(d, from[t] + row * FanBrick::kWidth + c)));
      hn::StoreU(sum, d, out + c);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(AddRow);
HWY_EXPORT(AddBrick);

}  // namespace

void addFanRow(const FanPlanes& planes, const FanRow& row, std::size_t count, float scale,
               const float* lengths, float* depths) {
  HWY_DYNAMIC_DISPATCH(AddRow)(planes, row, count, scale, lengths, depths);
}

void addFanBrick(const FanBrick& brick, const FanTaps& taps, float* ray, std::size_t width) {
  HWY_DYNAMIC_DISPATCH(AddBrick)(brick, taps, ray, width);
}

}  // namespace volute
#endif  // HWY_ONCE
