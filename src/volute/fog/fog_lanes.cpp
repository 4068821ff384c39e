// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_lanes.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/fog/fog_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef VOLUTE_FOG_PLACE
#define VOLUTE_FOG_PLACE

namespace volute {
namespace {

constexpr std::size_t kWidest = 16;  // lanes of the widest vector of floats

/// What is common to a batch that enters a zone and a level.
struct Place {
  double perCell = 1;     ///< [1/m]
  double from[2], to[2];  ///< the cells that are not empty
  double bottom = 0, top = 0;
  bool topBelongs = false;                  ///< to the zone, for level rays
  double fromDistance = 0, toDistance = 0;  ///< of the level, in units of |OP|
  double fromMetres = 0, toMetres = 0;      ///< and besides
  double zoneBegin = 0, zoneSlope = 0;      ///< at height 0, and per metre of height
};

}  // namespace
}  // namespace volute
#endif

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using DD = hn::CappedTag<double, 8>;
using DF = hn::Rebind<float, DD>;
using DI = hn::Rebind<std::int32_t, DD>;
using VD = hn::Vec<DD>;
constexpr DD dd;
constexpr DF df;
constexpr DI di;

constexpr double kNever = 3e38;      // stands for infinity, which times 0 would be NaN
constexpr double kParallel = 1e-30;  // [1/m]; such a ray meets no plane

HWY_INLINE VD Constant(double value) {
  return hn::Set(dd, value);
}

HWY_INLINE VD MulThenAdd(VD a, VD b, VD c) {
  return hn::Add(hn::Mul(a, b), c);
}

/// One axis of a ray in cells.
struct EnterAxis {
  VD o, d, inverse;
  hn::Mask<DD> parallel;

  HWY_INLINE EnterAxis(VD origin, VD direction, VD perCell)
      : o(hn::Mul(origin, perCell)), d(hn::Mul(direction, perCell)) {
    parallel = hn::Lt(hn::Abs(d), Constant(kParallel));
    inverse = hn::Div(Constant(1), hn::IfThenElse(parallel, Constant(1), d));
  }

  /// Cuts begin and end to where the ray is between from and to.
  HWY_INLINE void clip(VD from, VD to, hn::Mask<DD> within, VD& begin, VD& end) const {
    const VD a = hn::Mul(hn::Sub(from, o), inverse), b = hn::Mul(hn::Sub(to, o), inverse);
    const VD all = Constant(kNever);
    const VD near = hn::IfThenElse(within, hn::Neg(all), all);
    begin = hn::Max(begin, hn::IfThenElse(parallel, near, hn::Min(a, b)));
    end = hn::Min(end, hn::IfThenElse(parallel, all, hn::Max(a, b)));
  }

  HWY_INLINE void clipCells(VD from, VD to, VD& begin, VD& end) const {
    clip(from, to, hn::And(hn::Ge(o, from), hn::Le(o, to)), begin, end);
  }

  /// A ray that is not there stands in the first cell.
  HWY_INLINE void store(FogLanes::Axis& axis, std::size_t lane, VD from, VD to, VD begin,
                        hn::Mask<DD> there) const {
    const VD zero = hn::Zero(dd), one = Constant(1);
    const auto forwards = hn::Gt(d, zero);
    const auto moves = hn::AndNot(parallel, there);
    const VD at = hn::IfThenElse(moves, MulThenAdd(d, begin, o), hn::IfThenElse(there, o, from));
    const VD index =
        hn::IfThenElse(hn::AndNot(forwards, moves), hn::Sub(hn::Ceil(at), one), hn::Floor(at));
    const VD cell = hn::Min(hn::Max(index, from), hn::Sub(to, one));
    const VD ahead = hn::IfThenElse(forwards, one, zero);
    const VD crossing = hn::Mul(hn::Sub(hn::Add(cell, ahead), o), inverse);
    put(axis.first + lane, hn::IfThenElse(moves, hn::Sub(crossing, begin), Constant(kNever)));
    put(axis.delta + lane, hn::IfThenElseZero(moves, hn::Abs(inverse)));
    put(axis.velocity + lane, hn::IfThenElseZero(moves, d));
    put(axis.exitAt + lane, hn::IfThenElse(moves, ahead, hn::Sub(at, cell)));
    const VD step = hn::IfThenElse(forwards, one, Constant(-1));
    hn::Store(hn::DemoteTo(di, cell), di, axis.cell + lane);
    hn::Store(hn::DemoteTo(di, hn::IfThenElseZero(moves, step)), di, axis.step + lane);
  }

  static HWY_INLINE void put(float* to, VD value) { hn::Store(hn::DemoteTo(df, value), df, to); }
};

bool Enter(const FogRays& rays, const Place& place, FogLanes& lanes) {
  bool any = false;
  const VD perCell = Constant(place.perCell), one = Constant(1);
  const VD fromX = Constant(place.from[0]), toX = Constant(place.to[0]);
  const VD fromY = Constant(place.from[1]), toY = Constant(place.to[1]);
  const VD bottom = Constant(place.bottom), top = Constant(place.top);
  // All lanes of the widest vector of floats: the walk reads them.
  const std::size_t count = (rays.count + kWidest - 1) / kWidest * kWidest;
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(dd)) {
    const auto load = [&](const double* from) { return hn::Load(dd, from + lane); };
    const EnterAxis x(load(rays.origin[0]), load(rays.direction[0]), perCell);
    const EnterAxis y(load(rays.origin[1]), load(rays.direction[1]), perCell);
    const EnterAxis z(load(rays.origin[2]), load(rays.direction[2]), one);
    const VD distance = load(rays.distance);
    VD begin = hn::Max(load(rays.begin), MulThenAdd(distance, Constant(place.fromDistance),
                                                    Constant(place.fromMetres)));
    VD end = hn::Min(load(rays.end),
                     MulThenAdd(distance, Constant(place.toDistance), Constant(place.toMetres)));
    const auto below = place.topBelongs ? hn::Le(z.o, top) : hn::Lt(z.o, top);
    z.clip(bottom, top, hn::And(hn::Ge(z.o, bottom), below), begin, end);
    x.clipCells(fromX, toX, begin, end);
    y.clipCells(fromY, toY, begin, end);
    const auto there = hn::Lt(begin, end);
    any = any || !hn::AllFalse(dd, there);
    begin = hn::IfThenElseZero(there, begin);
    x.store(lanes.x, lane, fromX, toX, begin, there);
    y.store(lanes.y, lane, fromY, toY, begin, there);
    EnterAxis::put(lanes.begin + lane, begin);
    EnterAxis::put(lanes.length + lane, hn::IfThenElseZero(there, hn::Sub(end, begin)));
    const VD height = MulThenAdd(z.d, begin, z.o);
    const VD zone = MulThenAdd(height, Constant(place.zoneSlope), Constant(place.zoneBegin));
    EnterAxis::put(lanes.zoneBegin + lane, hn::IfThenElseZero(there, zone));
    EnterAxis::put(lanes.zoneSlope + lane,
                   hn::IfThenElseZero(there, hn::Mul(z.d, Constant(place.zoneSlope))));
  }
  return any;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(Enter);

constexpr double kFar = 1e300;  // stands for infinite distances

/// Where a level begins and ends. Distances are a share of |OP| with mu, metres otherwise.
void setDistances(const FogDetail& detail, const LevelEnds& ends, int level, Place& place) {
  place.fromMetres = -kFar, place.toMetres = kFar;
  if (detail.finestOnly())
    return;
  const bool metres = detail.cellAngle > 0;
  if (level > 0) {
    place.fromMetres = metres ? ends.ends[level - 1] : 0;
    place.fromDistance = metres ? 0 : ends.ends[level - 1];
  }
  if (std::isfinite(ends.ends[level])) {
    place.toMetres = metres ? ends.ends[level] : 0;
    place.toDistance = metres ? 0 : ends.ends[level];
  }
}

}  // namespace

ZoneKind kindOf(const FogProfile::Zone& zone) {
  return zone.slope != 0   ? ZoneKind::kLinear
         : zone.decay != 0 ? ZoneKind::kExponential
                           : ZoneKind::kConstant;
}

LevelEnds::LevelEnds(const FogMedium& fog)
    : ends(fog.options().detail.ends(fog.levels().count() - 1, fog.cell(), 1)),
      count(fog.options().detail.finestOnly() ? 1 : fog.levels().count()) {}

void FogRays::set(const FogMedium& fog, std::span<const Segment> segments) {
  const Vec3 corner = fog.domainCorner();
  count = segments.size();
  behind = false;
  for (std::size_t i = 0; i < count; ++i) {
    const Segment& segment = segments[i];
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][i] = segment.origin[axis] - corner[axis];
      direction[axis][i] = segment.direction[axis];
    }
    begin[i] = std::clamp(segment.begin, -kFar, kFar);
    end[i] = std::clamp(segment.end, -kFar, kFar);
    distance[i] = end[i];
    behind = behind || segment.begin < 0;
  }
  for (std::size_t i = count; i % kWidest != 0; ++i) {
    for (int axis = 0; axis < 3; ++axis) origin[axis][i] = direction[axis][i] = 0;
    begin[i] = end[i] = distance[i] = 0;
  }
  const FogDetail& detail = fog.options().detail;
  if (detail.finestOnly() || detail.cellAngle > 0)
    return;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isinf(segments[i].end)) {
      const Interval inside = fog.bounds().intersect(segments[i].origin, segments[i].direction);
      distance[i] = std::max(0.0, inside.end);
    }
  }
}

bool FogLanes::set(const FogMedium& fog, const FogRays& rays, const FogProfile::Zone& zone,
                   int levelIndex, const LevelEnds& ends) {
  const bool somewhere = ends.ends[levelIndex] > (levelIndex > 0 ? ends.ends[levelIndex - 1] : 0);
  if (!somewhere && !(rays.behind && levelIndex == 0))
    return false;
  level = fog.levels().level(levelIndex);
  const CellRect& rect = level.occupied;
  if (rect.empty())
    return false;
  Place place;
  place.perCell = std::ldexp(1 / fog.cell(), -levelIndex);
  place.from[0] = rect.x0, place.from[1] = rect.y0;
  place.to[0] = rect.x1, place.to[1] = rect.y1;
  place.bottom = zone.bottom, place.top = zone.top;
  place.topBelongs = &zone == &fog.profile().zones().back();
  setDistances(fog.options().detail, ends, levelIndex, place);
  place.zoneSlope = zone.decay != 0 ? zone.decay : zone.slope;
  place.zoneBegin = (zone.decay != 0 ? 0 : zone.value) - place.zoneSlope * zone.reference;
  return HWY_DYNAMIC_DISPATCH(Enter)(rays, place, *this);
}

}  // namespace volute
#endif  // HWY_ONCE
