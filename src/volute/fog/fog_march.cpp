// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One stretch of a ray in each SIMD lane: one level of detail, one zone of the profile. Lanes step
// from cell to cell on their own; neighbours in an image take the same cells, so that few idle.
// Only IEEE operations without fused multiply-add: every target gives the same bits.

#include "volute/fog/fog_march.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "volute/fog/fog_medium.hpp"

// SSSE3 and AVX3_DL bring nothing over their neighbours here; scalable vectors cannot be members of
// a class.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
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
                float* sums) {
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(df)) {
    Walk<kDegree, kKind> walk(levels, lanes, lane);
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
                 ZoneKind kind, float* sums) {
  switch (kind) {
    case ZoneKind::kConstant:
      return MarchLanes<kDegree, ZoneKind::kConstant>(levels, lanes, count, skip, sums);
    case ZoneKind::kLinear:
      return MarchLanes<kDegree, ZoneKind::kLinear>(levels, lanes, count, skip, sums);
    case ZoneKind::kExponential:
      return MarchLanes<kDegree, ZoneKind::kExponential>(levels, lanes, count, skip, sums);
  }
}

void March(const FogLevels& levels, const FogLanes& lanes, std::size_t count, bool skip,
           ZoneKind kind, float* sums) {
  switch (levels.degree()) {
    case 0:
      return MarchDegree<0>(levels, lanes, count, skip, kind, sums);
    case 1:
      return MarchDegree<1>(levels, lanes, count, skip, kind, sums);
    case 2:
      return MarchDegree<2>(levels, lanes, count, skip, kind, sums);
    default:
      return MarchDegree<3>(levels, lanes, count, skip, kind, sums);
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

constexpr float kNever = 3e38F;    // stands for infinity, which times 0 would be NaN
constexpr double kFarAway = 1e30;  // [m] planes beyond are never met
constexpr double kSkipFrom = 0.3;  // share of empty blocks from which on looking for them pays

/// A stretch of one of the rays.
struct Job {
  int ray = 0;
  FogMedium::Stretch part;
};

ZoneKind kindOf(const FogProfile::Zone& zone) {
  return zone.slope != 0   ? ZoneKind::kLinear
         : zone.decay != 0 ? ZoneKind::kExponential
                           : ZoneKind::kConstant;
}

void setAxis(FogLanes::Axis& axis, std::size_t lane, const PlaneAxis& from, double begin) {
  const double first = from.crossing - begin;
  const bool meets = from.d != 0 && first < kFarAway;
  axis.cell[lane] = from.cell;
  axis.step[lane] = meets ? (from.d > 0 ? 1 : -1) : 0;
  axis.first[lane] = meets ? static_cast<float>(first) : kNever;
  axis.delta[lane] = meets ? static_cast<float>(std::min(1 / std::abs(from.d), kFarAway)) : 0;
  axis.velocity[lane] = meets ? static_cast<float>(from.d) : 0;
  axis.exitAt[lane] =
      meets ? (from.d > 0 ? 1.0F : 0.0F) : static_cast<float>(from.at(begin) - from.cell);
}

/// False when the stretch misses what is not empty.
bool setLane(FogLanes& lanes, std::size_t lane, const FogMedium& fog, const Segment& segment,
             const FogMedium::Stretch& part) {
  const FogLevels::Level& level = fog.levels().level(part.level);
  const CellRect& rect = level.occupied;
  const PlaneRay ray = fog.planeRay(segment, part.level);
  PlaneAxis x{ray.ox, ray.dx, rect.x0, rect.x1}, y{ray.oy, ray.dy, rect.y0, rect.y1};
  double begin = part.begin, end = part.end;
  if (rect.empty() || !x.clip(begin, end) || !y.clip(begin, end))
    return false;
  x.enter(begin);
  y.enter(begin);
  setAxis(lanes.x, lane, x, begin);
  setAxis(lanes.y, lane, y, begin);
  lanes.length[lane] = static_cast<float>(end - begin);
  const FogProfile::Zone& zone = *part.zone;
  const double rise = segment.direction.z();
  const double height = segment.origin.z() + begin * rise - fog.domainCorner().z();
  if (zone.decay != 0) {
    lanes.zoneBegin[lane] = static_cast<float>(zone.decay * (height - zone.reference));
    lanes.zoneSlope[lane] = static_cast<float>(zone.decay * rise);
  } else {
    lanes.zoneBegin[lane] = static_cast<float>(zone(height));
    lanes.zoneSlope[lane] = static_cast<float>(zone.slope * rise);
  }
  return true;
}

/// A lane without a ray: it has no length, and stands in the first cell.
void setIdle(FogLanes& lanes, std::size_t lane) {
  for (FogLanes::Axis* axis : {&lanes.x, &lanes.y}) {
    axis->cell[lane] = axis->step[lane] = 0;
    axis->first[lane] = kNever;
    axis->delta[lane] = axis->velocity[lane] = axis->exitAt[lane] = 0;
  }
  lanes.length[lane] = lanes.zoneBegin[lane] = lanes.zoneSlope[lane] = 0;
}

/// Adds the depths of stretches in one level and one zone.
void marchJobs(const FogMedium& fog, std::span<const Segment> segments, std::span<const Job> jobs,
               std::span<double> depths) {
  FogLanes lanes;
  alignas(64) float sums[kFogLanes];
  std::size_t rayOf[kFogLanes];
  const FogMedium::Stretch& first = jobs.front().part;
  lanes.level = fog.levels().level(first.level);
  const bool skip = lanes.level.emptyShare > kSkipFrom;
  for (std::size_t j = 0; j < jobs.size();) {
    std::size_t count = 0;
    for (; j < jobs.size() && count < kFogLanes; ++j) {
      rayOf[count] = jobs[j].ray;
      count += setLane(lanes, count, fog, segments[jobs[j].ray], jobs[j].part);
    }
    for (std::size_t lane = count; lane % kWidestFogVector != 0; ++lane) setIdle(lanes, lane);
    HWY_DYNAMIC_DISPATCH(March)
    (fog.levels(), lanes, count, skip, kindOf(*first.zone), sums);
    for (std::size_t lane = 0; lane < count; ++lane) depths[rayOf[lane]] += sums[lane];
  }
}

}  // namespace

void marchDepths(const FogMedium& fog, std::span<const Segment> segments,
                 std::span<double> depths) {
  constexpr std::size_t kBatch = 1024;  // rays whose stretches are sorted together
  std::vector<FogMedium::Stretch> parts;
  std::vector<Job> jobs;
  const auto key = [](const Job& job) { return std::pair(job.part.zone, job.part.level); };
  for (std::size_t begin = 0; begin < segments.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, segments.size() - begin);
    const auto batch = segments.subspan(begin, count);
    jobs.clear();
    for (std::size_t i = 0; i < count; ++i) {
      depths[begin + i] = 0;
      fog.stretches(batch[i], parts);
      for (const auto& part : parts) jobs.push_back({static_cast<int>(i), part});
    }
    std::ranges::stable_sort(jobs, {}, key);
    for (std::size_t j = 0; j < jobs.size();) {
      std::size_t next = j;
      while (next < jobs.size() && key(jobs[next]) == key(jobs[j])) ++next;
      marchJobs(fog, batch, std::span(jobs).subspan(j, next - j), depths.subspan(begin, count));
      j = next;
    }
  }
}

}  // namespace volute
#endif  // HWY_ONCE
