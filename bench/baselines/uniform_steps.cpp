// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/baselines/uniform_steps.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"
#include "volute/fog/fog_lanes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/baselines/uniform_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/fog/fog_kernel-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

/// Where an axis is at s, in cells.
HWY_INLINE VF PlaceAt(const FogLanes::Axis& axis, std::size_t lane, VF s) {
  const VF ahead =
      hn::Mul(hn::Sub(s, hn::Load(df, axis.first + lane)), hn::Load(df, axis.velocity + lane));
  return hn::Add(hn::Add(ahead, hn::Load(df, axis.exitAt + lane)),
                 hn::ConvertTo(df, hn::Load(di, axis.cell + lane)));
}

void UniformSteps(const FogLevels& levels, const FogLanes& lanes, std::size_t count, int steps,
                  float* sums) {
  const FogLevels::Level& level = lanes.level;
  const float* values = levels.values().data() + level.base;
  const VF maxX = Constant(static_cast<float>(level.cellsX) - 0.001F);
  const VF maxY = Constant(static_cast<float>(level.cellsY) - 0.001F);
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(df)) {
    const VF step =
        hn::Mul(hn::Load(df, lanes.length + lane), Constant(1.0F / static_cast<float>(steps)));
    const VF x0 = PlaceAt(lanes.x, lane, hn::Zero(df)), y0 = PlaceAt(lanes.y, lane, hn::Zero(df));
    const VF dx = hn::Mul(hn::Load(df, lanes.x.velocity + lane), step);
    const VF dy = hn::Mul(hn::Load(df, lanes.y.velocity + lane), step);
    VF sum = hn::Zero(df);
    for (int k = 0; k < steps; ++k) {
      const VF at = Constant(static_cast<float>(k) + 0.5F);
      const VF x = hn::Min(hn::Max(MulThenAdd(dx, at, x0), hn::Zero(df)), maxX);
      const VF y = hn::Min(hn::Max(MulThenAdd(dy, at, y0), hn::Zero(df)), maxY);
      const VI cellX = hn::ConvertTo(di, x), cellY = hn::ConvertTo(di, y);
      const VI index = hn::Add(hn::Mul(cellY, hn::Set(di, level.stride)), cellX);
      const VF u = hn::Sub(x, hn::ConvertTo(df, cellX)), v = hn::Sub(y, hn::ConvertTo(df, cellY));
      const VF f00 = hn::GatherIndex(df, values, index);
      const VF f10 = hn::GatherIndex(df, values + 1, index);
      const VF f01 = hn::GatherIndex(df, values + level.stride, index);
      const VF f11 = hn::GatherIndex(df, values + level.stride + 1, index);
      const VF low = MulThenAdd(u, hn::Sub(f10, f00), f00);
      const VF high = MulThenAdd(u, hn::Sub(f11, f01), f01);
      sum = hn::Add(sum, MulThenAdd(v, hn::Sub(high, low), low));
    }
    hn::Store(hn::Mul(hn::Mul(sum, step), hn::Load(df, lanes.zoneBegin + lane)), df, sums + lane);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(UniformSteps);

}  // namespace

void uniformStepDepths(const FogMedium& fog, int steps, std::span<const Segment> segments,
                       std::span<double> depths) {
  VOLUTE_ASSERT(fog.options().degree == 1 && fog.profile().zones().size() == 1);
  FogRays rays;
  FogLanes lanes;
  alignas(64) float sums[kFogLanes];
  for (std::size_t begin = 0; begin < segments.size(); begin += kFogLanes) {
    const std::size_t count = std::min(kFogLanes, segments.size() - begin);
    const auto out = depths.subspan(begin, count);
    rays.set(fog, segments.subspan(begin, count));
    std::ranges::fill(out, 0.0);
    if (!lanes.set(fog, rays, fog.profile().zones().front(), 0, LevelEnds(fog)))
      continue;
    HWY_DYNAMIC_DISPATCH(UniformSteps)(fog.levels(), lanes, count, steps, sums);
    for (std::size_t lane = 0; lane < count; ++lane) out[lane] = sums[lane];
  }
}

}  // namespace volute
#endif  // HWY_ONCE
