// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One stretch of a ray in each SIMD lane: one level of detail, one zone of the profile. Lanes step
// from cell to cell on their own; neighbours in an image take the same cells, so that few idle.
// Only IEEE operations without fused multiply-add: every target gives the same bits.

#include "volute/fog/fog_march.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "volute/fog/fog_medium.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/fog/fog_march.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/fog/fog_kernel-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

template <int kDegree, ZoneKind kKind>
void MarchLanes(const FogLevels& levels, const FogLanes& lanes, std::size_t count, bool skip,
                float opaque, float* sums) {
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(df)) {
    Walk<kDegree, kKind> walk(levels, lanes, lane, opaque);
    if (skip) {
      walk.runOverEmpty();
    } else {
      walk.run();
    }
    walk.store(sums + lane);
  }
}

template <int kDegree>
void MarchDegree(const FogLevels& levels, const FogLanes& lanes, std::size_t count, bool skip,
                 ZoneKind kind, float opaque, float* sums) {
  switch (kind) {
    case ZoneKind::kConstant:
      return MarchLanes<kDegree, ZoneKind::kConstant>(levels, lanes, count, skip, opaque, sums);
    case ZoneKind::kLinear:
      return MarchLanes<kDegree, ZoneKind::kLinear>(levels, lanes, count, skip, opaque, sums);
    case ZoneKind::kExponential:
      return MarchLanes<kDegree, ZoneKind::kExponential>(levels, lanes, count, skip, opaque, sums);
  }
}

void March(const FogLevels& levels, const FogLanes& lanes, std::size_t count, bool skip,
           ZoneKind kind, float opaque, float* sums) {
  switch (levels.degree()) {
    case 0:
      return MarchDegree<0>(levels, lanes, count, skip, kind, opaque, sums);
    case 1:
      return MarchDegree<1>(levels, lanes, count, skip, kind, opaque, sums);
    case 2:
      return MarchDegree<2>(levels, lanes, count, skip, kind, opaque, sums);
    default:
      return MarchDegree<3>(levels, lanes, count, skip, kind, opaque, sums);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(March);

constexpr double kSkipFrom = 0.3;  // share of empty blocks from which on looking for them pays

/// On large maps a ray is walked in parts: places count from where a part begins, and a float tells
/// them apart less well the further they are.
class Parts {
 public:
  Parts(const FogMedium& fog, std::span<const Segment> segments, FogRays& rays) : rays_(rays) {
    const FogLevels::Level& level = fog.levels().level(0);
    if (std::max(level.cellsX, level.cellsY) <= kWholeCells)
      return;
    const Box3 bounds = fog.bounds();
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Interval inside = bounds.intersect(segments[i].origin, segments[i].direction)
                                  .intersect({segments[i].begin, segments[i].end});
      const double speed = segments[i].direction.head<2>().norm() / fog.cell();
      length_[i] = speed > 0 ? kPartCells / speed : std::numeric_limits<double>::infinity();
      last_[i] = inside.end;
      rays_.begin[i] = inside.empty() ? last_[i] : inside.begin;
      rays_.end[i] = std::min(rays_.begin[i] + length_[i], last_[i]);
    }
    parted_ = true;
  }

  /// False when all rays are through, or opaque.
  bool next(std::span<const double> depths, double opaque) {
    bool more = false;
    for (std::size_t i = 0; parted_ && i < depths.size(); ++i) {
      rays_.begin[i] = depths[i] < opaque ? rays_.end[i] : last_[i];
      rays_.end[i] = std::min(rays_.begin[i] + length_[i], last_[i]);
      more = more || rays_.begin[i] < rays_.end[i];
    }
    return more;
  }

 private:
  static constexpr int kWholeCells = 600;
  static constexpr double kPartCells = 256;

  FogRays& rays_;
  bool parted_ = false;
  double length_[kFogLanes], last_[kFogLanes];
};

/// Adds what one batch meets in every zone and level.
void marchBatch(const FogMedium& fog, const FogRays& rays, const LevelEnds& ends, float opaque,
                std::span<double> depths) {
  FogLanes lanes;
  alignas(64) float sums[kFogLanes];
  for (const FogProfile::Zone& zone : fog.profile().zones()) {
    for (int level = 0; level < ends.count; ++level) {
      if (!lanes.set(fog, rays, zone, level, ends))
        continue;
      const bool skip = lanes.level.emptyShare > kSkipFrom;
      HWY_DYNAMIC_DISPATCH(March)
      (fog.levels(), lanes, depths.size(), skip, kindOf(zone), opaque, sums);
      for (std::size_t lane = 0; lane < depths.size(); ++lane) depths[lane] += sums[lane];
    }
  }
}

}  // namespace

void marchDepths(const FogMedium& fog, std::span<const Segment> segments, std::span<double> depths,
                 float opaque) {
  FogRays rays;
  const LevelEnds ends(fog);
  for (std::size_t begin = 0; begin < segments.size(); begin += kFogLanes) {
    const std::size_t count = std::min(kFogLanes, segments.size() - begin);
    const auto batch = segments.subspan(begin, count);
    const auto out = depths.subspan(begin, count);
    std::ranges::fill(out, 0.0);
    rays.set(fog, batch);
    Parts parts(fog, batch, rays);
    do {
      marchBatch(fog, rays, ends, opaque, out);
    } while (parts.next(out, opaque));
  }
}

}  // namespace volute
#endif  // HWY_ONCE
