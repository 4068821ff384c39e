// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One part of a sight line in each SIMD lane, in double. Lanes step on their own from plane to
// plane, on one axis at a time: where a line meets an edge, steps of no length follow each other.
// Where the plane after the next one is met is looked up ahead, so that no step waits for it. Only
// IEEE operations without fused multiply-add.

#include "volute/fds/fds_march.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "volute/base/assert.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/fds/fds_march.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#ifndef VOLUTE_FDS_MARCH_LANES
#define VOLUTE_FDS_MARCH_LANES

namespace volute {
namespace {

constexpr std::size_t kMaxLanes = 64;  // what a batch holds; a multiple of any vector's lanes

struct PartLanes {
  alignas(64) double from[kMaxLanes];
  alignas(64) double end[kMaxLanes];
  alignas(64) double next[3][kMaxLanes];  ///< where the next plane of each axis is met
  alignas(64) double origin[3][kMaxLanes];
  alignas(64) double direction[3][kMaxLanes];
  alignas(64) double inverse[3][kMaxLanes];      ///< 1 / direction; 0 when parallel
  alignas(64) std::int64_t plane[3][kMaxLanes];  ///< the next one; of a parallel axis the upper one
  alignas(64) std::int64_t step[3][kMaxLanes];   ///< -1, 0, 1
  alignas(64) std::int64_t cell[kMaxLanes];
  alignas(64) std::int64_t cellStep[3][kMaxLanes];
  alignas(64) std::int64_t corner[kMaxLanes];  ///< the value at the cell's least corner
  alignas(64) std::int64_t cornerStep[3][kMaxLanes];
  alignas(64) double depth[kMaxLanes];
  alignas(64) double gas[kMaxLanes];
  alignas(64) double low[kMaxLanes];
  alignas(64) double high[kMaxLanes];
};

}  // namespace
}  // namespace volute
#endif

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using DI = hn::RebindToSigned<D>;
using DF = hn::Rebind<float, D>;
using DN = hn::Rebind<std::int32_t, D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using Mask = hn::Mask<D>;
constexpr D d;
constexpr DI di;

/// Whether each place is one of `size`: sanitizers do not see what vectors gather.
[[maybe_unused]] HWY_INLINE bool AllWithin(VI place, std::size_t size) {
  return hn::AllTrue(di, hn::Gt(place, hn::Set(di, -1))) &&
         hn::AllTrue(di, hn::Lt(place, hn::Set(di, static_cast<std::int64_t>(size))));
}

HWY_INLINE V ValuesAt(const float* values, VI place) {
  constexpr DF df;
  constexpr DN dn;
  constexpr hn::RebindToUnsigned<DN> dw;
  constexpr hn::RebindToUnsigned<DI> du;
  return hn::PromoteTo(
      d, hn::GatherIndex(df, values, hn::BitCast(dn, hn::TruncateTo(dw, hn::BitCast(du, place)))));
}

struct Ends {
  V low, high;
};

HWY_INLINE Ends PairsAt(const std::vector<std::uint64_t>& pairs, VI place) {
  VOLUTE_ASSERT(AllWithin(place, pairs.size()));
  constexpr DF df;
  constexpr hn::Rebind<std::uint32_t, D> dw;
  constexpr hn::RebindToUnsigned<DI> du;
  const auto pair = hn::GatherIndex(du, pairs.data(), place);
  return {hn::PromoteTo(d, hn::BitCast(df, hn::TruncateTo(dw, pair))),
          hn::PromoteTo(d, hn::BitCast(df, hn::TruncateTo(dw, hn::ShiftRight<32>(pair))))};
}

HWY_INLINE VI Choose(Mask mask, VI yes, VI no) {
  return hn::IfThenElse(hn::RebindMask(di, mask), yes, no);
}

/// What a lane knows of the cell that it is in, of a nodal lattice.
struct Cell {
  V lower[3];    ///< its lower planes
  V perCell[3];  ///< 1 / its size
};

HWY_INLINE V Interpolate(const V* origin, const V* direction, const Cell& cell, const V* corners,
                         V s) {
  V share[3];
  for (int axis = 0; axis < 3; ++axis) {
    const V at = hn::Mul(hn::Sub(origin[axis], cell.lower[axis]), cell.perCell[axis]);
    share[axis] = hn::Add(at, hn::Mul(hn::Mul(direction[axis], cell.perCell[axis]), s));
  }
  V plane[2];
  for (int z = 0; z < 2; ++z) {
    V row[2];
    for (int y = 0; y < 2; ++y) {
      const V low = corners[4 * z + 2 * y];
      row[y] = hn::Add(low, hn::Mul(share[0], hn::Sub(corners[4 * z + 2 * y + 1], low)));
    }
    plane[z] = hn::Add(row[0], hn::Mul(share[1], hn::Sub(row[1], row[0])));
  }
  return hn::Add(plane[0], hn::Mul(share[2], hn::Sub(plane[1], plane[0])));
}

/// The integral over from..to: a cubic, for which the Gauss rule with two points is exact.
HWY_INLINE V Integral(const MarchLattice& march, const float* values, const V* origin,
                      const V* direction, const Cell& cell, VI corner, V from, V to) {
  V corners[8];
  const int twin = march.thinAxis < 0 ? 0 : 1 << march.thinAxis;
  for (int i = 0; i < 8; ++i) {
    if ((i & twin) != 0) {
      corners[i] = corners[i ^ twin];
      continue;
    }
    const std::int64_t offset =
        (i & 1) * march.stride[0] + ((i >> 1) & 1) * march.stride[1] + (i >> 2) * march.stride[2];
    corners[i] = ValuesAt(values, hn::Add(corner, hn::Set(di, offset)));
  }
  const V half = hn::Mul(hn::Set(d, 0.5), hn::Sub(to, from));
  const V middle = hn::Mul(hn::Set(d, 0.5), hn::Add(from, to));
  const V away = hn::Mul(hn::Set(d, 0.57735026918962576451), half);  // 1 / sqrt 3
  return hn::Mul(half,
                 hn::Add(Interpolate(origin, direction, cell, corners, hn::Sub(middle, away)),
                         Interpolate(origin, direction, cell, corners, hn::Add(middle, away))));
}

HWY_INLINE V PlanesAt(const MarchLattice& march, VI place) {
  VOLUTE_ASSERT(AllWithin(place, march.planes.size()));
  return hn::GatherIndex(d, march.planes.data(), place);
}

/// The planes round the cells, of a nodal lattice: `next` is the upper one of lanes that go up.
HWY_INLINE void EnterCell(const MarchLattice& march, VI next, VI step, V& lower, V& perCell) {
  const VI up = hn::IfThenElse(hn::Lt(step, hn::Zero(di)), hn::Set(di, 1), hn::Zero(di));
  const VI upper = hn::Add(next, up);
  lower = PlanesAt(march, hn::Sub(upper, hn::Set(di, 1)));
  perCell = hn::Div(hn::Set(d, 1.0), hn::Sub(PlanesAt(march, upper), lower));
}

/// Evenly spaced blocks, all gas: no planes to fetch, and one value, both ends of what it may be.
HWY_INLINE void MarchEven(const MarchLattice& march, PartLanes& lanes, std::size_t first) {
  V from = hn::Load(d, lanes.from + first);
  const V end = hn::Load(d, lanes.end + first);
  V next[3], advance[3];
  VI cellStep[3];
  for (int axis = 0; axis < 3; ++axis) {
    next[axis] = hn::Load(d, lanes.next[axis] + first);
    // Nothing for lanes that are parallel: `next` stays infinite.
    advance[axis] =
        hn::Abs(hn::Mul(hn::Set(d, march.spacing[axis]), hn::Load(d, lanes.inverse[axis] + first)));
    cellStep[axis] = hn::Load(di, lanes.cellStep[axis] + first);
  }
  const VI lastCell = hn::Set(di, static_cast<std::int64_t>(march.pairs.size()) - 1);
  VI cell = hn::Load(di, lanes.cell + first);
  V gas = hn::Zero(d), low = hn::Zero(d), high = hn::Zero(d);
  for (Mask live = hn::Lt(from, end); !hn::AllFalse(d, live); live = hn::Lt(from, end)) {
    const V yz = hn::Min(next[1], next[2]);
    const V to = hn::Min(hn::Min(next[0], yz), end);
    // Planes that are counted on may end a rounding before the lattice does: a lane that is beyond
    // them, or has ended, looks at what is there.
    const auto [least, most] = PairsAt(march.pairs, hn::Max(hn::Zero(di), hn::Min(cell, lastCell)));
    const V length = hn::IfThenElseZero(live, hn::Max(hn::Sub(to, from), hn::Zero(d)));
    gas = hn::Add(gas, length);
    low = hn::MulAdd(least, length, low);
    // Infinite ones count for nothing where the step has no length.
    high = hn::Add(high, hn::IfThenElseZero(hn::Gt(length, hn::Zero(d)), hn::Mul(most, length)));
    const Mask onX = hn::Le(next[0], yz);
    const Mask onY = hn::AndNot(onX, hn::Le(next[1], next[2]));
    const Mask on[3] = {onX, onY, hn::Not(hn::Or(onX, onY))};
    for (int axis = 0; axis < 3; ++axis) {
      next[axis] = hn::Add(next[axis], hn::IfThenElseZero(on[axis], advance[axis]));
      cell = hn::Add(cell, hn::IfThenElseZero(hn::RebindMask(di, on[axis]), cellStep[axis]));
    }
    from = hn::Max(from, to);
  }
  hn::Store(low, d, lanes.depth + first);
  hn::Store(gas, d, lanes.gas + first);
  hn::Store(low, d, lanes.low + first);
  hn::Store(high, d, lanes.high + first);
}

/// @tparam kPaired  of cells that are all gas: low and high ends side by side, the low ones as
/// values
template <bool kNodal, bool kBanded, bool kPaired>
HWY_INLINE void MarchVector(const MarchLattice& march, PartLanes& lanes, std::size_t first) {
  V from = hn::Load(d, lanes.from + first);
  const V end = hn::Load(d, lanes.end + first);
  V next[3], after[3], origin[3], direction[3], inverse[3];
  VI plane[3], step[3], cellStep[3], cornerStep[3];
  Cell inside;
  for (int axis = 0; axis < 3; ++axis) {
    next[axis] = hn::Load(d, lanes.next[axis] + first);
    origin[axis] = hn::Load(d, lanes.origin[axis] + first);
    direction[axis] = hn::Load(d, lanes.direction[axis] + first);
    inverse[axis] = hn::Load(d, lanes.inverse[axis] + first);
    plane[axis] = hn::Load(di, lanes.plane[axis] + first);
    step[axis] = hn::Load(di, lanes.step[axis] + first);
    cellStep[axis] = hn::Load(di, lanes.cellStep[axis] + first);
    cornerStep[axis] = hn::Load(di, lanes.cornerStep[axis] + first);
    const V place = PlanesAt(march, hn::Add(plane[axis], step[axis]));
    after[axis] = hn::Mul(hn::Sub(place, origin[axis]), inverse[axis]);
    if constexpr (kNodal)
      EnterCell(march, plane[axis], step[axis], inside.lower[axis], inside.perCell[axis]);
  }
  VI cell = hn::Load(di, lanes.cell + first);
  VI corner = hn::Load(di, lanes.corner + first);
  V depth = hn::Zero(d), gas = hn::Zero(d), low = hn::Zero(d), high = hn::Zero(d);
  for (Mask live = hn::Lt(from, end); !hn::AllFalse(d, live); live = hn::Lt(from, end)) {
    const V to = hn::Min(hn::Min(next[0], next[1]), hn::Min(next[2], end));
    // What stands still looks at the first cell and counts for nothing.
    const VI here = hn::IfThenElseZero(hn::RebindMask(di, live), cell);
    V length = hn::IfThenElseZero(live, hn::Max(hn::Sub(to, from), hn::Zero(d)));
    V value = hn::Zero(d);
    if constexpr (!kPaired) {
      VOLUTE_ASSERT(AllWithin(here, march.own.size()));
      value = ValuesAt(march.own.data(), here);
      length = hn::IfThenElseZero(hn::Ge(value, hn::Zero(d)), length);
    }
    gas = hn::Add(gas, length);
    if constexpr (kPaired) {
      const auto [least, most] = PairsAt(march.pairs, here);
      depth = hn::Add(depth, hn::Mul(least, length));
      // Infinite ones count for nothing where the step has no length.
      high = hn::Add(high, hn::IfThenElseZero(hn::Gt(length, hn::Zero(d)), hn::Mul(most, length)));
    } else if constexpr (kNodal) {
      const VI at = hn::IfThenElseZero(hn::RebindMask(di, live), corner);
      const Mask counts = hn::Gt(length, hn::Zero(d));
      const auto over = [&](const float* values) HWY_ATTR {
        return hn::IfThenElseZero(counts,
                                  Integral(march, values, origin, direction, inside, at, from, to));
      };
      depth = hn::Add(depth, over(march.values));
      if constexpr (kBanded) {
        low = hn::Add(low, over(march.low));
        high = hn::Add(high, over(march.high));
      }
    } else {
      depth = hn::Add(depth, hn::Mul(value, length));
      if constexpr (kBanded) {
        const Mask counts = hn::Gt(length, hn::Zero(d));
        const auto over = [&](const float* values) HWY_ATTR {
          return hn::IfThenElseZero(counts, hn::Mul(ValuesAt(values, here), length));
        };
        low = hn::Add(low, over(march.low));
        high = hn::Add(high, over(march.high));
      }
    }
    // The axis whose plane is next, and one of them where two are.
    const Mask onX = hn::And(live, hn::And(hn::Le(next[0], next[1]), hn::Le(next[0], next[2])));
    const Mask onY = hn::And(hn::AndNot(onX, live), hn::Le(next[1], next[2]));
    const Mask onZ = hn::AndNot(hn::Or(onX, onY), live);
    const Mask on[3] = {onX, onY, onZ};
    const VI stepped = Choose(onX, step[0], Choose(onY, step[1], step[2]));
    const VI moved = hn::Add(Choose(onX, plane[0], Choose(onY, plane[1], plane[2])), stepped);
    // Dead lanes may have left the planes.
    const VI beyond = hn::IfThenElseZero(hn::RebindMask(di, live), hn::Add(moved, stepped));
    const V place = PlanesAt(march, beyond);
    for (int axis = 0; axis < 3; ++axis) {
      const V crossing = hn::Mul(hn::Sub(place, origin[axis]), inverse[axis]);
      next[axis] = hn::IfThenElse(on[axis], after[axis], next[axis]);
      after[axis] = hn::IfThenElse(on[axis], crossing, after[axis]);
      plane[axis] = Choose(on[axis], moved, plane[axis]);
      const hn::Mask<DI> mask = hn::RebindMask(di, on[axis]);
      cell = hn::Add(cell, hn::IfThenElseZero(mask, cellStep[axis]));
      if constexpr (kNodal)
        corner = hn::Add(corner, hn::IfThenElseZero(mask, cornerStep[axis]));
    }
    if constexpr (kNodal) {
      // Dead lanes look at the first planes, which EnterCell() needs two of.
      const VI safe = hn::IfThenElse(hn::RebindMask(di, live), moved, hn::Set(di, 1));
      V lower, perCell;
      EnterCell(march, safe, stepped, lower, perCell);
      for (int axis = 0; axis < 3; ++axis) {
        inside.lower[axis] = hn::IfThenElse(on[axis], lower, inside.lower[axis]);
        inside.perCell[axis] = hn::IfThenElse(on[axis], perCell, inside.perCell[axis]);
      }
    }
    from = hn::IfThenElse(live, hn::Max(from, to), from);
  }
  hn::Store(depth, d, lanes.depth + first);
  hn::Store(gas, d, lanes.gas + first);
  if constexpr (kPaired) {
    hn::Store(depth, d, lanes.low + first);
    hn::Store(high, d, lanes.high + first);
  } else if constexpr (kBanded) {
    hn::Store(low, d, lanes.low + first);
    hn::Store(high, d, lanes.high + first);
  }
}

void March(const MarchLattice& march, PartLanes& lanes, std::size_t count) {
  for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
    const bool banded = march.low != nullptr;
    if (march.even)
      MarchEven(march, lanes, first);
    else if (!march.pairs.empty())
      MarchVector<false, true, true>(march, lanes, first);
    else if (march.nodal && banded)
      MarchVector<true, true, false>(march, lanes, first);
    else if (march.nodal)
      MarchVector<true, false, false>(march, lanes, first);
    else if (banded)
      MarchVector<false, true, false>(march, lanes, first);
    else
      MarchVector<false, false, false>(march, lanes, first);
  }
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(March);

/// How far evenly spaced planes may be from their places [spacings]: sums of so many steps, of
/// blocks that are bounds and no more, do not see it.
constexpr double kEven = 1e-9;

/// cellBetween() for a place inside the planes but for rounding, from where evenly spaced ones
/// would have it: searches from start to end are mispredicted branches.
std::int64_t cellNear(const std::vector<double>& planes, double perPlane, double place) {
  const auto last = static_cast<std::int64_t>(planes.size()) - 2;
  const double guess =
      std::clamp((place - planes.front()) * perPlane, 0.0, static_cast<double>(last));
  auto cell = static_cast<std::int64_t>(guess);
  const double* at = planes.data();
  while (cell < last && at[cell + 1] <= place) ++cell;
  while (cell > 0 && at[cell] > place) --cell;
  return cell;
}

void setLane(PartLanes& lanes, std::size_t lane, const FdsLattice& lattice,
             const MarchLattice& march, const Segment& segment, const MarchPart& part) {
  lanes.from[lane] = part.begin;
  double end = part.end;
  std::int64_t place = 0, corner = 0, stride = 1;
  for (int a = 0; a < 3; ++a) {
    const auto& planes = lattice.planes[a];
    const double direction = segment.direction[a];
    const double origin = segment.origin[a];
    const double at = direction == 0 ? origin : origin + part.begin * direction;
    const int step = direction > 0 ? 1 : direction < 0 ? -1 : 0;
    std::int64_t cell = cellNear(planes, march.perPlane[a], at);
    if (step < 0 && cell > 0 && at == planes[static_cast<std::size_t>(cell)])
      --cell;
    const double inverse = direction == 0 ? 0 : 1 / direction;
    lanes.origin[a][lane] = origin;
    lanes.direction[a][lane] = direction;
    lanes.inverse[a][lane] = inverse;
    lanes.step[a][lane] = step;
    lanes.cellStep[a][lane] = step * stride;
    lanes.cornerStep[a][lane] = step * march.stride[a];
    const std::int64_t next = cell + (step < 0 ? 0 : 1);
    lanes.plane[a][lane] = march.first[a] + next;
    lanes.next[a][lane] = step == 0 ? std::numeric_limits<double>::infinity()
                                    : (planes[static_cast<std::size_t>(next)] - origin) * inverse;
    if (step != 0) {
      const double exit = step > 0 ? planes.back() : planes.front();
      end = std::min(end, (exit - origin) * inverse);
    }
    place += cell * stride;
    corner += cell * march.stride[a];
    stride *= march.cells[a];
  }
  lanes.end[lane] = end;
  lanes.cell[lane] = place;
  lanes.corner[lane] = corner;
}

/// A lane that has nothing to do.
void setIdle(PartLanes& lanes, std::size_t lane, const MarchLattice& march) {
  lanes.from[lane] = lanes.end[lane] = 0;
  lanes.cell[lane] = lanes.corner[lane] = 0;
  for (int a = 0; a < 3; ++a) {
    lanes.next[a][lane] = std::numeric_limits<double>::infinity();
    lanes.origin[a][lane] = lanes.direction[a][lane] = lanes.inverse[a][lane] = 0;
    lanes.plane[a][lane] = march.first[a] + 1;
    lanes.step[a][lane] = lanes.cellStep[a][lane] = lanes.cornerStep[a][lane] = 0;
  }
}

}  // namespace

MarchLattice::MarchLattice(const FdsLattice& lattice, std::span<const float> values,
                           std::span<const std::uint8_t> gas, std::span<const float> low,
                           std::span<const float> high)
    : nodal(lattice.nodal),
      thinAxis(lattice.nodal ? lattice.thinAxis : -1),
      values(values.data()),
      low(low.empty() ? nullptr : low.data()),
      high(low.empty() ? nullptr : high.data()) {
  planes.assign(2, 0.0);
  std::int64_t step = 1;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = static_cast<std::int64_t>(planes.size());
    planes.insert(planes.end(), lattice.planes[axis].begin(), lattice.planes[axis].end());
    cells[axis] = lattice.cells(axis);
    perPlane[axis] = static_cast<double>(cells[axis]) /
                     (lattice.planes[axis].back() - lattice.planes[axis].front());
    stride[axis] = step;
    step *= cells[axis] + (nodal ? 1 : 0);
  }
  planes.insert(planes.end(), 3, 0.0);
  own.resize(gas.size());
  for (std::size_t i = 0; i < gas.size(); ++i) own[i] = gas[i] == 0 ? -1 : nodal ? 1 : values[i];
}

MarchLattice::MarchLattice(const FdsLattice& lattice, std::span<const float> least,
                           std::span<const float> most)
    : MarchLattice(lattice, least, {}, least, most) {
  VOLUTE_ASSERT(!lattice.nodal && least.size() == most.size());
  even = true;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& places = lattice.planes[axis];
    spacing[axis] = places[1] - places[0];
    for (std::size_t i = 2; i + 1 < places.size(); ++i)  // the last cell may be short
      even &= std::abs(places[i] - (places[0] + static_cast<double>(i) * spacing[axis])) <=
              kEven * spacing[axis];
    even &= places.back() <= places[places.size() - 2] + (1 + kEven) * spacing[axis];
  }
  pairs.resize(least.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i] = std::uint64_t{std::bit_cast<std::uint32_t>(most[i])} << 32 |
               std::bit_cast<std::uint32_t>(least[i]);
  }
}

void marchParts(const FdsLattice& lattice, const MarchLattice& march,
                std::span<const Segment> segments, std::span<const MarchPart> parts,
                std::span<MarchSum> sums) {
  constexpr std::size_t kWidest = 8;
  PartLanes lanes;
  std::array<std::uint32_t, kMaxLanes> order;
  for (std::size_t begin = 0; begin < parts.size(); begin += kMaxLanes) {
    const std::size_t count = std::min(kMaxLanes, parts.size() - begin);
    // Parts of like length side by side: the lanes of a vector wait for the longest of them.
    std::iota(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), 0U);
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
              [&](std::uint32_t a, std::uint32_t b) {
                const MarchPart &first = parts[begin + a], &second = parts[begin + b];
                return first.end - first.begin < second.end - second.begin;
              });
    for (std::size_t i = 0; i < count; ++i) {
      const MarchPart& part = parts[begin + order[i]];
      setLane(lanes, i, lattice, march, segments[part.segment], part);
    }
    for (std::size_t i = count; i % kWidest != 0; ++i) setIdle(lanes, i, march);
    HWY_DYNAMIC_DISPATCH(March)(march, lanes, count);
    for (std::size_t i = 0; i < count; ++i) {
      MarchSum& sum = sums[begin + order[i]];
      sum = {lanes.depth[i], lanes.gas[i], lanes.depth[i], lanes.depth[i]};
      if (march.low != nullptr) {
        sum.low = lanes.low[i];
        // An infinite corner makes the sum infinite, or no number.
        sum.high =
            std::isfinite(lanes.high[i]) ? lanes.high[i] : std::numeric_limits<double>::infinity();
      }
    }
  }
}

}  // namespace volute
#endif  // HWY_ONCE
