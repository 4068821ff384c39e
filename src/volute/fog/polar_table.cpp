// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/polar_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/fog/fog_lanes.hpp"
#include "volute/fog/fog_march.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/fog/polar_table.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/fog/fog_kernel-inl.hpp"

#ifndef VOLUTE_FOG_POLAR
#define VOLUTE_FOG_POLAR

namespace volute {

/// A table as the kernels want it.
struct PolarLook {
  const float* entries = nullptr;
  const float* errors = nullptr;
  int stride = 2, blocks = 1, azimuths = 0, radii = 0, sectors = 1;
  float cosYaw = 1, sinYaw = 0, tangent = 1, perQ = 1;
  float from = 0, to = 0, perMetre = 1, step = 1, cell = 1;
  float height = 0;  ///< of the eye above the map's origin
  std::span<const FogProfile::Zone> zones{};

  explicit PolarLook(const PolarTable& table)
      : entries(table.entries_->data()),
        errors(table.errors_->data()),
        stride(table.stride_),
        blocks(table.blocks_),
        azimuths(table.azimuths_),
        radii(table.radii_),
        sectors(table.sectors_),
        cosYaw(static_cast<float>(std::cos(table.yaw_))),
        sinYaw(static_cast<float>(std::sin(table.yaw_))),
        tangent(static_cast<float>(table.tangent_)),
        perQ(static_cast<float>((table.azimuths_ - 1) / (2 * table.tangent_))),
        from(static_cast<float>(table.from_)),
        to(static_cast<float>(table.from_ + (table.radii_ - 1) * table.step_)),
        perMetre(static_cast<float>(1 / table.step_)),
        step(static_cast<float>(table.step_)),
        cell(static_cast<float>(table.fog_.cell())),
        height(static_cast<float>(table.eye_.z() - table.fog_.domainCorner().z())),
        zones(table.fog_.profile().zones()) {}
};

namespace {

constexpr float kEndless = 3e38F;  // the table wants the sums however large
constexpr int kBlockBits = 3;      // log2 of the radii in a block

/// The radii of a table that is being built.
struct PolarRadii {
  double from = 0, step = 1;
  int count = 0;
  int stride = 2;
};

}  // namespace
}  // namespace volute
#endif

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

/// Writes the entries of the azimuths in the lanes; lane i's begin at out + i * count * stride.
template <int kDegree>
void BuildRows(const FogLevels& levels, FogLanes& lanes, std::size_t count, const PolarRadii& radii,
               float* out) {
  alignas(64) float values[4][kFogLanes];
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(df)) {
    const VF begin = hn::Load(df, lanes.begin + lane);
    // g = r makes the first moment of the linear zone's walk.
    hn::Store(begin, df, lanes.zoneBegin + lane);
    hn::Store(Constant(1), df, lanes.zoneSlope + lane);
    Walk<kDegree, ZoneKind::kConstant> plain(levels, lanes, lane, kEndless);
    Walk<kDegree, ZoneKind::kLinear> moment(levels, lanes, lane, kEndless);
    for (int j = 0; j < radii.count; ++j) {
      const VF r = Constant(static_cast<float>(radii.from + j * radii.step));
      const VF s = hn::Sub(r, begin);
      plain.runTo(s);
      const VF rho = plain.density(s);
      hn::Store(plain.sum(), df, values[0]);
      hn::Store(rho, df, values[1]);
      if (radii.stride == 4) {
        moment.runTo(s);
        hn::Store(moment.sum(), df, values[2]);
        hn::Store(hn::Mul(rho, r), df, values[3]);
      }
      for (std::size_t i = 0; i < hn::Lanes(df) && lane + i < count; ++i) {
        float* entry = out + ((lane + i) * radii.count + j) * radii.stride;
        for (int k = 0; k < radii.stride; ++k) entry[k] = values[k][i];
      }
    }
  }
}

void Build(const FogLevels& levels, FogLanes& lanes, std::size_t count, const PolarRadii& radii,
           float* out) {
  switch (levels.degree()) {
    case 0:
      return BuildRows<0>(levels, lanes, count, radii, out);
    case 1:
      return BuildRows<1>(levels, lanes, count, radii, out);
    case 2:
      return BuildRows<2>(levels, lanes, count, radii, out);
    default:
      return BuildRows<3>(levels, lanes, count, radii, out);
  }
}

/// Where a ray's azimuth is between the rows of a table.
struct Rows {
  VI lower;  ///< offset of the lower row's first entry
  VI error;  ///< and of its first error
  VF share;  ///< of the upper row
};

/// Where a horizontal distance is between the radii of a table.
struct Radius {
  VI index;
  VF x;  ///< of the way to the next
};

HWY_INLINE Radius PlaceOf(const PolarLook& look, VF r) {
  const VF place =
      hn::Mul(hn::Sub(hn::Min(r, Constant(look.to)), Constant(look.from)), Constant(look.perMetre));
  const VF inside =
      hn::Min(hn::Max(place, hn::Zero(df)), Constant(static_cast<float>(look.radii) - 1.001F));
  const VI index = hn::ConvertTo(di, inside);
  return {index, hn::Sub(inside, hn::ConvertTo(df, index))};
}

/// M_k (k = 0: which = 0, 1: which = 2) at a horizontal distance.
HWY_INLINE VF Look(const PolarLook& look, const Rows& rows, const Radius& at, int which) {
  const VF one = Constant(1), x = at.x;
  const VI entry = hn::Add(rows.lower, hn::Mul(at.index, hn::Set(di, look.stride)));
  const float* low = look.entries + which;
  const float* high = low + static_cast<std::ptrdiff_t>(look.radii) * look.stride;
  const auto mixed = [&](std::ptrdiff_t offset) {
    const VF a = hn::GatherIndex(df, low + offset, entry);
    const VF b = hn::GatherIndex(df, high + offset, entry);
    return MulThenAdd(rows.share, hn::Sub(b, a), a);
  };
  const VF from = mixed(0), to = mixed(look.stride);
  const VF slope0 = hn::Mul(mixed(1), Constant(look.step));
  const VF slope1 = hn::Mul(mixed(look.stride + 1), Constant(look.step));
  // Hermite's cubic.
  const VF rest = hn::Sub(one, x);
  const VF blend = hn::Mul(hn::Mul(x, x), hn::Sub(Constant(3), hn::Add(x, x)));
  const VF bend = hn::Mul(hn::Mul(x, rest), hn::Sub(hn::Mul(slope0, rest), hn::Mul(slope1, x)));
  return hn::Add(MulThenAdd(blend, hn::Sub(to, from), from), bend);
}

/// How far off Look() may be.
HWY_INLINE VF ErrorOf(const PolarLook& look, const Rows& rows, const Radius& at, int which) {
  const VI block = hn::Mul(hn::ShiftRight<kBlockBits>(at.index), hn::Set(di, look.stride / 2));
  return hn::GatherIndex(df, look.errors + which / 2, hn::Add(rows.error, block));
}

/// Which rows a direction lies between; clears `good` where it leaves the sector.
HWY_INLINE Rows Find(const PolarLook& look, VF x, VF y, Mask& good) {
  const VF zero = hn::Zero(df);
  const VF ahead = MulThenAdd(x, Constant(look.cosYaw), hn::Mul(y, Constant(look.sinYaw)));
  const VF left = hn::Sub(hn::Mul(y, Constant(look.cosYaw)), hn::Mul(x, Constant(look.sinYaw)));
  VF major = ahead, minor = left;
  VI sector = hn::Zero(di);
  if (look.sectors == 4) {  // forwards, left, backwards, right; the minor axis is left of the major
    const Mask sideways = hn::Gt(hn::Abs(left), hn::Abs(ahead));
    const VF main = hn::IfThenElse(sideways, left, ahead);
    const VF other = hn::IfThenElse(sideways, hn::Neg(ahead), left);
    const Mask negative = hn::Lt(main, zero);
    major = hn::Abs(main);
    minor = hn::IfThenElse(negative, hn::Neg(other), other);
    sector = hn::Add(hn::IfThenElseZero(ForInts(sideways), hn::Set(di, 1)),
                     hn::IfThenElseZero(ForInts(negative), hn::Set(di, 2)));
  }
  good = hn::And(good, hn::Gt(major, zero));
  const VF q = hn::Div(minor, hn::IfThenElse(good, major, Constant(1)));
  good = hn::And(good, hn::Le(hn::Abs(q), Constant(look.tangent * 1.000001F)));
  const VF place = hn::Mul(hn::Add(q, Constant(look.tangent)), Constant(look.perQ));
  const VF inside =
      hn::Min(hn::Max(place, zero), Constant(static_cast<float>(look.azimuths) - 1.001F));
  const VI row = hn::ConvertTo(di, inside);
  const VI all = hn::Add(hn::Mul(sector, hn::Set(di, look.azimuths)), row);
  return {hn::Mul(all, hn::Set(di, look.radii * look.stride)),
          hn::Mul(all, hn::Set(di, look.blocks * (look.stride / 2))),
          hn::Sub(inside, hn::ConvertTo(df, row))};
}

/// The optical depth times cos E within one zone; adds how far off it may be.
HWY_INLINE VF ZoneDepth(const PolarLook& look, const FogProfile::Zone& zone, const Rows& rows,
                        VF rise, VF level, VF distance, VF& error) {
  const VF zero = hn::Zero(df);
  const float above = static_cast<float>(zone.top) - look.height;
  const float below = static_cast<float>(zone.bottom) - look.height;
  const Mask flat = hn::Lt(hn::Abs(rise), Constant(1e-12F));
  const VF perRise = hn::Div(Constant(1), hn::IfThenElse(flat, Constant(1e-12F), rise));
  const VF a = hn::Mul(Constant(below), perRise), b = hn::Mul(Constant(above), perRise);
  const VF begin = hn::Max(hn::Min(a, b), zero);
  const VF end = hn::Max(hn::Min(hn::Max(a, b), distance), begin);
  const VF from = hn::Mul(begin, level), to = hn::Mul(end, level);
  const Mask begun = hn::Gt(from, Constant(look.from));
  const bool begins = !hn::AllFalse(df, begun);
  const Radius near = PlaceOf(look, from), far = PlaceOf(look, to);
  const Mask reached = hn::And(hn::Gt(to, Constant(look.from)), hn::Gt(to, from));
  const auto moment = [&](int which, VF factor) {
    VF sum = Look(look, rows, far, which);
    VF off = hn::IfThenElseZero(reached, ErrorOf(look, rows, far, which));
    if (begins) {
      sum = hn::Sub(sum, Look(look, rows, near, which));
      off = hn::Add(off,
                    hn::IfThenElseZero(hn::And(begun, reached), ErrorOf(look, rows, near, which)));
    }
    error = MulThenAdd(off, hn::Abs(factor), error);
    return hn::Mul(sum, factor);
  };
  const double value = zone.slope != 0 ? zone(look.height) : zone.value;
  VF depth = moment(0, Constant(static_cast<float>(value)));
  if (zone.slope != 0) {
    const VF tangent = hn::Div(rise, hn::Max(level, Constant(1e-6F)));
    depth = hn::Add(depth, moment(2, hn::Mul(tangent, Constant(static_cast<float>(zone.slope)))));
  }
  return hn::Max(depth, zero);
}

/// exp(-depth), or -1 for rays that are not for the table.
void Transmit(const PolarLook& look, const float* x, const float* y, const float* z,
              const float* distance, std::size_t count, float* out) {
  const std::size_t lanes = hn::Lanes(df);
  for (std::size_t i = 0; i < count; i += lanes) {
    const VF dx = hn::LoadU(df, x + i), dy = hn::LoadU(df, y + i), rise = hn::LoadU(df, z + i);
    const VF length = hn::LoadU(df, distance + i);
    const VF level = hn::Sqrt(MulThenAdd(dx, dx, hn::Mul(dy, dy)));
    Mask good = hn::And(hn::Gt(level, Constant(0.15F)),
                        hn::Gt(hn::Mul(length, level), Constant(look.cell)));
    const Rows rows = Find(look, dx, dy, good);
    VF depth = hn::Zero(df), error = hn::Zero(df);
    for (const FogProfile::Zone& zone : look.zones)
      depth = hn::Add(depth, ZoneDepth(look, zone, rows, rise, level, length, error));
    const VF perLevel = hn::Div(Constant(1), hn::Max(level, Constant(0.15F)));
    const VF off = hn::Mul(error, perLevel);
    const VF passed = Exp(hn::Neg(hn::Mul(depth, perLevel)));
    // At most exp(-(depth - off)) is passed.
    const VF largest = hn::Min(hn::Mul(passed, Exp(hn::Min(off, Constant(20)))), Constant(1));
    good = hn::And(good, hn::Le(hn::Mul(largest, off), Constant(static_cast<float>(kPolarError))));
    hn::StoreU(hn::IfThenElse(good, passed, Constant(-1)), df, out + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(Build);
HWY_EXPORT(Transmit);

/// The least and the largest horizontal distance from the eye to what is not empty.
Interval distances(const FogMedium& fog, const Vec3& eye) {
  const CellRect& rect = fog.levels().level(0).occupied;
  if (rect.empty())
    return {0, fog.cell()};
  const Vec3 corner = fog.domainCorner();
  Interval out{0, 0};
  double near = 0, far = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const double low = corner[axis] + (axis == 0 ? rect.x0 : rect.y0) * fog.cell() - eye[axis];
    const double high = corner[axis] + (axis == 0 ? rect.x1 : rect.y1) * fog.cell() - eye[axis];
    const double nearest = low > 0 ? low : high < 0 ? -high : 0;
    near += nearest * nearest;
    far += std::pow(std::max(std::abs(low), std::abs(high)), 2);
  }
  out.begin = std::sqrt(near);
  out.end = std::sqrt(far);
  return out;
}

/// The unit direction of an azimuth.
Vec3 azimuthDirection(double yaw, int sector, double q) {
  const double turn = yaw + sector * std::numbers::pi / 2;
  return Vec3(std::cos(turn) - q * std::sin(turn), std::sin(turn) + q * std::cos(turn), 0)
      .normalized();
}

Status checkServed(const FogMedium& fog, const Vec3& eye, const PolarOptions& options) {
  if (fog.hasTop() || !fog.options().detail.finestOnly() || !fog.levels().fits()) {
    return fail(ErrorCode::kUnsupported,
                "a polar table serves fog without a top and without dropped details only");
  }
  for (const auto& zone : fog.profile().zones()) {
    if (zone.decay != 0)
      return fail(ErrorCode::kUnsupported, "a polar table cannot serve an exponential profile");
  }
  if (!eye.allFinite() || options.azimuths < 0 || options.azimuths == 1 || options.radii < 0 ||
      options.radii == 1) {
    return fail(
        ErrorCode::kInvalidArgument,
        "a polar table needs a finite eye and at least two azimuths and radii, not {} and {}",
        options.azimuths, options.radii);
  }
  if (options.sector && !(options.sector->tangent > 0 && options.sector->tangent < 1e3)) {
    return fail(ErrorCode::kInvalidArgument, "a polar table's sector has the tangent {}",
                options.sector->tangent);
  }
  return {};
}

}  // namespace

std::array<double, 2> largestBends(const SplineGrid& map) {
  const auto value = [&](int i, int j) {
    return i >= 0 && j >= 0 && i < map.columns && j < map.rows ? map.at(i, j) : 0;
  };
  std::array<double, 2> bends{};
  for (int j = -1; j <= map.rows; ++j) {
    for (int i = -1; i <= map.columns; ++i) {
      const double twice = 2 * value(i, j);
      bends[0] = std::max(bends[0], std::abs(value(i - 1, j) - twice + value(i + 1, j)));
      bends[1] = std::max(bends[1], std::abs(value(i, j - 1) - twice + value(i, j + 1)));
    }
  }
  return bends;
}

std::optional<PolarSector> PolarSector::of(const EyeRays& rays) {
  double ahead[2] = {0, 0};
  for (std::size_t i = 0; i < rays.x.size(); ++i) {
    const double length = std::hypot(rays.x[i], rays.y[i]);
    if (length > 0)
      ahead[0] += rays.x[i] / length, ahead[1] += rays.y[i] / length;
  }
  PolarSector sector{std::atan2(ahead[1], ahead[0]), 0};
  const double c = std::cos(sector.yaw), s = std::sin(sector.yaw);
  constexpr double kWidest = 3;  // beyond, four sectors sample better
  for (std::size_t i = 0; i < rays.x.size(); ++i) {
    const double forwards = rays.x[i] * c + rays.y[i] * s;
    const double left = std::abs(rays.y[i] * c - rays.x[i] * s);
    if (!(left <= kWidest * forwards))
      return std::nullopt;
    sector.tangent = std::max(sector.tangent, left / forwards);
  }
  sector.tangent = sector.tangent * 1.00001 + 1e-6;
  return sector;
}

namespace {

/// What an eye beside the map sees of it; nullopt: most of the horizon.
std::optional<PolarSector> mapSector(const FogMedium& fog, const Vec3& eye) {
  const CellRect& rect = fog.levels().level(0).occupied;
  if (rect.empty())
    return std::nullopt;
  const Vec3 from = fog.domainCorner() - eye;
  std::vector<float> x, y;
  for (const int column : {rect.x0, rect.x1}) {
    for (const int row : {rect.y0, rect.y1}) {
      const Vec3 way = (from + fog.cell() * Vec3(column, row, 0)).normalized();
      x.push_back(static_cast<float>(way.x())), y.push_back(static_cast<float>(way.y()));
    }
  }
  return PolarSector::of({eye, x, y, {}, {}});
}

/// The azimuths in both.
PolarSector common(const PolarSector& a, const PolarSector& b) {
  const double turn = std::remainder(b.yaw - a.yaw, 2 * std::numbers::pi);
  const double halfA = std::atan(a.tangent), halfB = std::atan(b.tangent);
  const double right = std::max(-halfA, turn - halfB), left = std::min(halfA, turn + halfB);
  if (!(left > right))  // none: no ray leads to the map
    return {a.yaw, 1e-6};
  return {a.yaw + 0.5 * (left + right), std::tan(0.5 * (left - right)) * 1.00001 + 1e-6};
}

}  // namespace

Result<PolarLayout> PolarLayout::of(const FogMedium& fog, const Vec3& eye,
                                    const PolarOptions& options) {
  VOLUTE_TRY(checkServed(fog, eye, options));
  const int cells = std::max(fog.levels().columns(), fog.levels().rows());
  PolarLayout layout;
  const Interval reach = distances(fog, eye);
  std::optional<PolarSector> sector = options.sector;
  if (const auto seen = reach.begin > 0 ? mapSector(fog, eye) : std::nullopt)
    sector = sector ? common(*sector, *seen) : *seen;
  layout.sectors = sector ? 1 : 4;
  layout.yaw = sector ? sector->yaw : 0;
  layout.tangent = sector ? sector->tangent : 1;
  // Linear between azimuths, whose step at the map's farthest corner is what the error comes from;
  // cubic between radii. Measured so that few rays of painted maps are further off than
  // kPolarError; of large ones no more than a texture is wide.
  constexpr double kMinAzimuths = 2560, kAzimuthsACell = 7.5;
  constexpr int kMin = 64;
  const int most = layout.sectors == 1 ? 8192 : 4096;
  const double diagonal = std::hypot(fog.levels().columns(), fog.levels().rows()) * fog.cell();
  const double usual = std::max(kMinAzimuths, kAzimuthsACell * cells) * layout.tangent *
                       std::max(1.0, reach.end / diagonal);
  layout.azimuths = options.azimuths > 0
                        ? options.azimuths
                        : static_cast<int>(std::clamp<double>(std::ceil(usual), kMin, most));
  layout.radii = options.radii > 0 ? options.radii : std::max(384, cells);
  layout.from = reach.begin;
  layout.step = (reach.end - reach.begin) / (layout.radii - 1);
  return layout;
}

namespace {

/// A sum that a table holds, along an azimuth and the next: how far off it is between them.
class PolarRowPair {
 public:
  /// @param which  0: M_0, 2: M_1
  PolarRowPair(const std::vector<float>& entries, const PolarLayout& layout, int stride, int which,
               int row, double cell, const std::array<double, 2>& bends)
      : stride_(stride),
        weighted_(which != 0),
        radii_(layout.radii),
        from_(static_cast<float>(layout.from)),
        step_(static_cast<float>(layout.step)) {
    constexpr double kAngle = 4e-7, kPlace = 1.2e-7;
    const int first = row / layout.azimuths * layout.azimuths, count = layout.azimuths;
    for (int i = 0; i < 6; ++i) {  // at a sector's borders those within
      const int near = std::clamp(row - 2 + i, first, first + count - 1);
      rows_[i] = entries.data() + static_cast<std::size_t>(near) * layout.radii * stride + which;
    }
    inner_ = row >= first + 2 && row + 3 < first + count;
    places_ = static_cast<float>(kAngle * (count - 1) / (2 * layout.tangent) + kPlace * count);
    const double q = (2 * (row - first + 0.5) / (count - 1) - 1) * layout.tangent;
    const Vec3 along = azimuthDirection(layout.yaw, row / count, q);
    const double x = std::abs(along.x()), y = std::abs(along.y());
    cellsApart_ = static_cast<float>(2 * layout.tangent / ((count - 1) * cell));
    aslant_ = static_cast<float>(std::min(x, y) / std::max(x, y));
    bend_ = static_cast<float>((x < y ? bends[0] : bends[1]) * cell / 4);
  }

  /// Of all look-ups between the two in a block of radii.
  float error(int block) const {
    const int first = block << kBlockBits;
    const int last = std::min(first + (1 << kBlockBits), radii_ - 1);
    float across = 0, along = 0;
    for (int radius = first; radius <= last; ++radius)
      across = std::max(across, acrossAzimuths(radius) + hidden(radius));
    for (int radius = first; radius < last; ++radius)
      along = std::max({along, alongRadius(2, radius), alongRadius(3, radius)});
    return across + along;
  }

 private:
  float sum(int row, int radius) const { return rows_[row][radius * stride_]; }

  float density(int row, int radius) const { return rows_[row][radius * stride_ + 1]; }

  float bend(int row, int radius) const {
    return sum(row - 1, radius) - 2 * sum(row, radius) + sum(row + 1, radius);
  }

  float distance(int radius) const { return from_ + static_cast<float>(radius) * step_; }

  /// Of the linear interpolation: an eighth of the second difference where that is continuous, up
  /// to a half where there is a kink between the rows. And what comes from rounding: of an azimuth,
  /// which cannot be told more exactly than in floats, and of a distance.
  float acrossAzimuths(int radius) const {
    constexpr float kDistance = 4e-7F, kSum = 4e-7F;
    const float rise = std::abs(sum(3, radius) - sum(2, radius));
    const float beside = std::max(std::abs(sum(2, radius) - sum(1, radius)),
                                  std::abs(sum(4, radius) - sum(3, radius)));
    const float rounding =
        std::max(rise, beside) * places_ +
        kDistance * distance(radius) * std::max(density(2, radius), density(3, radius)) +
        kSum * std::max(sum(2, radius), sum(3, radius));
    if (!inner_)
      return 0.5F * std::max(rise, beside) + rounding;
    const float a = bend(2, radius), b = bend(3, radius);
    const float jumps = std::abs(a - bend(1, radius)) + std::abs(b - bend(4, radius));
    return std::max(std::abs(a), std::abs(b)) / 8 + jumps * 3 / 16 + rounding;
  }

  /// Rays that lead almost along an axis of the map see the pixels of a column change at once, in
  /// less than an azimuth step: no row shows it.
  float hidden(int radius) const {
    const float cells = distance(radius) * cellsApart_;
    return aslant_ > 0.7F * cells
               ? 0
               : std::min(cells, 1.0F) * bend_ * (weighted_ ? distance(radius) : 1);
  }

  /// Of Hermite's cubic: a twelfth of the cubic's part where the density has a kink, less where it
  /// has none.
  float alongRadius(int row, int radius) const {
    const float chord = sum(row, radius + 1) - sum(row, radius);
    return std::abs(step_ * (density(row, radius) + density(row, radius + 1)) - 2 * chord) / 12;
  }

  std::array<const float*, 6> rows_{};  ///< the pair are 2 and 3
  int stride_;
  bool weighted_, inner_ = true;
  int radii_;
  float from_, step_;     ///< [m]
  float places_ = 0;      ///< rows, to which an azimuth is rounded
  float cellsApart_ = 0;  ///< rows, in cells a metre of distance
  float aslant_ = 0;      ///< tangent to the nearest axis of the map
  float bend_ = 0;        ///< of the map across that axis
};

std::vector<float> errorsOf(const FogMedium& fog, const std::vector<float>& entries,
                            const PolarLayout& layout, int stride, int blocks) {
  const auto bends = largestBends(fog.levels().map());
  const int sums = stride / 2;
  const std::size_t rows = static_cast<std::size_t>(layout.sectors) * layout.azimuths;
  std::vector<float> errors(rows * blocks * sums);
  parallelRanges(rows, kFogLanes, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      if (static_cast<int>(row % layout.azimuths) == layout.azimuths - 1)
        continue;  // no next one in its sector
      for (int sum = 0; sum < sums; ++sum) {
        const PolarRowPair pair(entries, layout, stride, 2 * sum, static_cast<int>(row), fog.cell(),
                                bends);
        for (int block = 0; block < blocks; ++block)
          errors[(row * blocks + block) * sums + sum] = pair.error(block);
      }
    }
  });
  return errors;
}

}  // namespace

Result<PolarTable> PolarTable::make(const FogMedium& fog, const Vec3& eye,
                                    const PolarOptions& options) {
  VOLUTE_ASSIGN(const PolarLayout layout, PolarLayout::of(fog, eye, options));
  PolarTable table(fog);
  table.eye_ = eye;
  table.azimuths_ = layout.azimuths, table.radii_ = layout.radii;
  table.sectors_ = layout.sectors;
  table.yaw_ = layout.yaw, table.tangent_ = layout.tangent;
  table.from_ = layout.from, table.step_ = layout.step;
  const double farthest = distances(fog, eye).end;
  for (const auto& zone : fog.profile().zones())
    table.stride_ = zone.slope != 0 ? 4 : table.stride_;

  const std::size_t rows = static_cast<std::size_t>(table.sectors_) * table.azimuths_;
  const std::size_t rowSize = static_cast<std::size_t>(table.radii_) * table.stride_;
  auto entries = std::make_shared<std::vector<float>>(rows * rowSize);
  const PolarRadii radii{table.from_, table.step_, table.radii_, table.stride_};
  static const FogProfile everywhere;
  parallelRanges(rows, kFogLanes, [&](std::size_t begin, std::size_t end) {
    FogRays rays;
    FogLanes lanes;
    std::vector<Segment> segments;
    for (std::size_t row = begin; row < end; row += kFogLanes) {
      segments.clear();
      for (std::size_t i = row; i < std::min(end, row + kFogLanes); ++i) {
        const double place = double(i % table.azimuths_) / (table.azimuths_ - 1);
        const Vec3 direction = azimuthDirection(table.yaw_, static_cast<int>(i / table.azimuths_),
                                                (2 * place - 1) * table.tangent_);
        segments.push_back({eye, direction, 0, farthest});
      }
      rays.set(fog, segments);
      std::ranges::fill(rays.origin[2], 0.0);  // the map alone, whatever the eye's height
      if (lanes.set(fog, rays, everywhere.zones().front(), 0, LevelEnds(fog))) {
        HWY_DYNAMIC_DISPATCH(Build)
        (fog.levels(), lanes, segments.size(), radii, entries->data() + row * rowSize);
      }
    }
  });
  table.blocks_ = ((table.radii_ - 2) >> kBlockBits) + 1;
  table.errors_ = std::make_shared<const std::vector<float>>(
      errorsOf(fog, *entries, layout, table.stride_, table.blocks_));
  table.entries_ = std::move(entries);
  return table;
}

void PolarTable::lookUp(const EyeRays& rays, std::span<float> out) const {
  VOLUTE_ASSERT(rays.eye == eye_ && rays.x.size() == out.size());
  const PolarLook look(*this);
  const std::size_t whole = out.size() / kFogLanes * kFogLanes;
  HWY_DYNAMIC_DISPATCH(Transmit)
  (look, rays.x.data(), rays.y.data(), rays.z.data(), rays.distance.data(), whole, out.data());
  if (const std::size_t rest = out.size() - whole; rest > 0) {
    float in[4][kFogLanes] = {}, last[kFogLanes];
    const std::span<const float> from[] = {rays.x, rays.y, rays.z, rays.distance};
    for (int k = 0; k < 4; ++k) std::ranges::copy(from[k].subspan(whole), in[k]);
    HWY_DYNAMIC_DISPATCH(Transmit)(look, in[0], in[1], in[2], in[3], kFogLanes, last);
    std::copy_n(last, rest, out.data() + whole);
  }
}

void PolarTable::transmittance(const EyeRays& rays, std::span<float> out) const {
  lookUp(rays, out);
  std::vector<Segment> walked;
  std::vector<std::size_t> where;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i] >= 0)
      continue;
    where.push_back(i);
    walked.push_back({eye_, Vec3(rays.x[i], rays.y[i], rays.z[i]), 0, rays.distance[i]});
  }
  std::vector<double> depths(walked.size());
  marchDepths(fog_, walked, depths);
  for (std::size_t i = 0; i < where.size(); ++i)
    out[where[i]] = static_cast<float>(std::exp(-depths[i]));
}

}  // namespace volute
#endif  // HWY_ONCE
