// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sun_shadow.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/fog/sun_sums.hpp"
#include "volute/math/quadrature.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/fog/sun_shadow.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"

#ifndef VOLUTE_FOG_SUN
#define VOLUTE_FOG_SUN

namespace volute {

/// A zone's maps as the kernel wants them; places are in samples, heights in metres above the
/// floor.
struct SunLook {
  const float* values = nullptr;   ///< S of an exponential zone, else I_0
  const float* density = nullptr;  ///< rho
  int columns = 2, rows = 2;
  float alongX = 0, alongY = 0, rise = 1;  ///< towards the sun, for each metre of the way
  float cells = 0;                         ///< that a metre of the way goes across
  float bottom = 0, top = 0, value = 1, decay = 0, reference = 0;
};

namespace {

constexpr double kSteepCells = 3.0;  // over so many cells a zone is integrated by Gauss points
constexpr std::size_t kAtOnce = 64;  // places, a multiple of the widest vector's lanes

}  // namespace
}  // namespace volute
#endif

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

/// Bilinear between samples, and as at the border outside of them.
HWY_INLINE VF Bilinear(const SunLook& look, const float* values, VF x, VF y) {
  const VF zero = hn::Zero(df);
  x = hn::Min(hn::Max(x, zero), Constant(static_cast<float>(look.columns - 1)));
  y = hn::Min(hn::Max(y, zero), Constant(static_cast<float>(look.rows - 1)));
  const VI i = hn::Min(hn::ConvertTo(di, x), hn::Set(di, look.columns - 2));
  const VI j = hn::Min(hn::ConvertTo(di, y), hn::Set(di, look.rows - 2));
  const VF u = hn::Sub(x, hn::ConvertTo(df, i)), v = hn::Sub(y, hn::ConvertTo(df, j));
  const VI at = hn::Add(hn::Mul(j, hn::Set(di, look.columns)), i);
  const auto row = [&](const float* from) {
    const VF left = hn::GatherIndex(df, from, at), right = hn::GatherIndex(df, from + 1, at);
    return MulThenAdd(u, hn::Sub(right, left), left);
  };
  const VF lower = row(values), upper = row(values + look.columns);
  return MulThenAdd(v, hn::Sub(upper, lower), lower);
}

/// The map's value for places that may lie before the fog; see SunShadow::entry().
HWY_INLINE VF Entered(const SunLook& look, VF x, VF y) {
  const auto enter = [](VF at, float along, int samples, VF& near, VF& far) {
    constexpr float kParallel = 1e-20F;
    const VF each = Constant(1 / (std::abs(along) < kParallel ? kParallel : along));
    const VF a = hn::Mul(hn::Neg(at), each);
    const VF b = hn::Mul(hn::Sub(Constant(static_cast<float>(samples - 1)), at), each);
    near = hn::Max(near, hn::Min(a, b));
    far = hn::Min(far, hn::Max(a, b));
  };
  VF near = hn::Zero(df), far = Constant(1e30F);
  enter(x, look.alongX, look.columns, near, far);
  enter(y, look.alongY, look.rows, near, far);
  const VF value = Bilinear(look, look.values, MulThenAdd(near, Constant(look.alongX), x),
                            MulThenAdd(near, Constant(look.alongY), y));
  const VF grown = Exp(hn::Mul(near, Constant(-look.decay * look.rise)));
  return hn::IfThenElseZero(hn::Le(near, far), hn::Mul(value, grown));
}

/// By Gauss points of rho, in one to three parts.
HWY_INLINE VF Steep(const SunLook& look, VF x, VF y, VF begin, VF length, VF cells) {
  const VF parts = hn::Add(hn::Floor(cells), Constant(1));
  const VF each = hn::Div(length, parts);
  VF sum = hn::Zero(df);
  for (int part = 0; part < static_cast<int>(kSteepCells); ++part) {
    const Mask is = hn::Lt(Constant(static_cast<float>(part)), parts);
    if (hn::AllFalse(df, is))
      break;
    for (const auto& [place, weight] : {std::pair(0.11270166537925831F, 5 / 18.0F),
                                        {0.5F, 8 / 18.0F},
                                        {0.88729833462074169F, 5 / 18.0F}}) {
      const VF t = MulThenAdd(each, Constant(static_cast<float>(part) + place), begin);
      const VF u = MulThenAdd(t, Constant(look.alongX), x);
      const VF v = MulThenAdd(t, Constant(look.alongY), y);
      const auto within = [](VF at, int samples) {
        return hn::And(hn::Ge(at, hn::Zero(df)),
                       hn::Le(at, Constant(static_cast<float>(samples - 1))));
      };
      const Mask inside = hn::And(is, hn::And(within(u, look.columns), within(v, look.rows)));
      sum = hn::Add(sum, hn::IfThenElseZero(inside, hn::Mul(Constant(weight),
                                                            Bilinear(look, look.density, u, v))));
    }
  }
  return hn::Mul(sum, each);
}

/// Adds the optical depths within a zone that is constant or exponential.
/// @param count  a multiple of the widest vector's lanes
void AddZone(const SunLook& look, const float* x, const float* y, const float* height,
             std::size_t count, float* depths) {
  const VF zero = hn::Zero(df), perRise = Constant(1 / look.rise);
  for (std::size_t i = 0; i < count; i += hn::Lanes(df)) {
    const VF h = hn::Load(df, height + i), u = hn::Load(df, x + i), v = hn::Load(df, y + i);
    const VF begin = hn::Max(zero, hn::Mul(hn::Sub(Constant(look.bottom), h), perRise));
    const VF length = hn::Sub(hn::Mul(hn::Sub(Constant(look.top), h), perRise), begin);
    const Mask meets = hn::Gt(length, zero);
    if (hn::AllFalse(df, meets))
      continue;
    const auto entered = [&](VF t) {
      return Entered(look, MulThenAdd(t, Constant(look.alongX), u),
                     MulThenAdd(t, Constant(look.alongY), v));
    };
    VF depth = entered(begin);
    if (look.decay != 0) {
      const VF above = hn::Sub(MulThenAdd(begin, Constant(look.rise), h), Constant(look.reference));
      depth = hn::Mul(depth, Exp(hn::Mul(above, Constant(-look.decay))));
    } else {
      const VF cells = hn::Mul(length, Constant(look.cells));
      const Mask steep = hn::Lt(cells, Constant(static_cast<float>(kSteepCells)));
      depth = hn::Sub(depth, entered(hn::Add(begin, length)));
      if (!hn::AllFalse(df, hn::And(steep, meets)))
        depth = hn::IfThenElse(
            steep, Steep(look, u, v, begin, length, hn::IfThenElseZero(steep, cells)), depth);
    }
    depth = hn::Mul(depth, Constant(look.value));
    hn::Store(hn::Add(hn::Load(df, depths + i), hn::IfThenElseZero(meets, depth)), df, depths + i);
  }
}

/// exp(-depth) in place.
void Pass(std::size_t count, float* depths) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(df)) {
    const VF depth = hn::Max(hn::Load(df, depths + i), hn::Zero(df));
    hn::Store(Exp(hn::Neg(depth)), df, depths + i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(AddZone);
HWY_EXPORT(Pass);

constexpr double kLowest = 1e-3;  // sine of the sun's height

}  // namespace

double SunShadow::Map::at(double x, double y) const {
  x = std::clamp(x, 0.0, columns - 1.0);
  y = std::clamp(y, 0.0, rows - 1.0);
  const int i = std::min(static_cast<int>(x), columns - 2);
  const int j = std::min(static_cast<int>(y), rows - 2);
  const double u = x - i, v = y - j;
  const float* corner = &values[static_cast<std::size_t>(j) * columns + i];
  return (1 - v) * ((1 - u) * corner[0] + u * corner[1]) +
         v * ((1 - u) * corner[columns] + u * corner[columns + 1]);
}

SunShadow::Map SunShadow::sampled(const SunSums& sums) const {
  const CellRect cells = fog_.levels().mapCells();
  const int perCell = static_cast<int>(std::lround(fog_.cell() / step_));
  Map map;
  map.columns = (cells.x1 - cells.x0) * perCell + 1;
  map.rows = (cells.y1 - cells.y0) * perCell + 1;
  map.values.resize(static_cast<std::size_t>(map.columns) * map.rows);
  parallelRanges(map.rows, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec2> places(map.columns);
    std::vector<double> depths(map.columns);
    for (std::size_t j = begin; j < end; ++j) {
      for (int i = 0; i < map.columns; ++i) places[i] = Vec2(i, static_cast<double>(j)) / perCell;
      sums.at(places, depths);
      for (int i = 0; i < map.columns; ++i)
        map.values[j * map.columns + i] = static_cast<float>(depths[i]);
    }
  });
  return map;
}

SunShadow::Map SunShadow::sampledDensity() const {
  Map map;
  map.columns = i0_->columns;
  map.rows = i0_->rows;
  map.values.resize(i0_->values.size());
  const FogMedium fog = fog_.withProfile({});
  parallelRanges(map.rows, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      for (int i = 0; i < map.columns; ++i) {
        const Vec3 point(x0_ + i * step_, y0_ + static_cast<double>(j) * step_,
                         fog_.domainCorner().z());
        map.values[j * map.columns + i] = static_cast<float>(fog.extinction(point));
      }
    }
  });
  return map;
}

Result<SunShadow> SunShadow::make(const FogMedium& fog, const Vec3& towardsSun, int samples) {
  const Vec3 sun = towardsSun.normalized();
  if (!sun.allFinite() || !(sun.z() >= kLowest)) {
    return fail(ErrorCode::kInvalidArgument,
                "the sun over the fog is towards ({}, {}, {}), but must stand above the horizon",
                towardsSun.x(), towardsSun.y(), towardsSun.z());
  }
  if (samples < 1 || samples > 8)
    return fail(ErrorCode::kInvalidArgument, "a sun's shadow has 1 to 8 samples a cell, not {}",
                samples);
  if (fog.hasTop() || !fog.levels().fits())
    return fail(ErrorCode::kUnsupported, "fog with a top cannot shadow itself");
  const FogMedium finest = fog.finest();
  SunShadow shadow(finest);
  shadow.sun_ = sun;
  shadow.step_ = fog.cell() / samples;
  const CellRect cells = fog.levels().mapCells();
  shadow.x0_ = fog.domainCorner().x() + cells.x0 * fog.cell();
  shadow.y0_ = fog.domainCorner().y() + cells.y0 * fog.cell();
  const SunSums plain(finest, sun, samples, SunSums::Weight::kOne);
  shadow.i0_ = std::make_shared<const Map>(shadow.sampled(plain));
  shadow.rho_ = std::make_shared<const Map>(shadow.sampledDensity());
  for (const auto& zone : fog.profile().zones()) {
    if (zone.slope != 0 && !shadow.i1_) {
      const SunSums moments(finest, sun, samples, SunSums::Weight::kWay, 0, &plain);
      shadow.i1_ = std::make_shared<const Map>(shadow.sampled(moments));
    }
    if (zone.decay != 0 && !shadow.s_) {
      shadow.decay_ = zone.decay;
      const SunSums decaying(finest, sun, samples, SunSums::Weight::kDecay, zone.decay);
      shadow.s_ = std::make_shared<const Map>(shadow.sampled(decaying));
    }
  }
  return shadow;
}

double SunShadow::entry(double& u, double& v) const {
  const double lastU = i0_->columns - 1, lastV = i0_->rows - 1;
  if (u >= 0 && v >= 0 && u <= lastU && v <= lastV)
    return 0;
  const Box3 box{Vec3(0, 0, -1), Vec3(lastU, lastV, 1)};
  const Vec3 direction(sun_.x() / step_, sun_.y() / step_, 0);
  const Interval inside = box.intersect(Vec3(u, v, 0), direction);
  if (inside.empty() || !(inside.end > 0))
    return -1;
  const double in = std::max(0.0, inside.begin);
  u += in * direction.x();
  v += in * direction.y();
  return in;
}

SunShadow::Moments SunShadow::momentsAt(double x, double y) const {
  double u = (x - x0_) / step_, v = (y - y0_) / step_;
  const double in = entry(u, v);
  if (in < 0)
    return {};
  Moments out;
  out.i0 = i0_->at(u, v);
  out.i1 = i1_ ? i1_->at(u, v) + in * out.i0 : 0;
  return out;
}

double SunShadow::decayingAt(double x, double y) const {
  double u = (x - x0_) / step_, v = (y - y0_) / step_;
  const double in = entry(u, v);
  if (in < 0)
    return 0;
  return s_->at(u, v) * (in > 0 ? std::exp(-decay_ * sun_.z() * in) : 1);
}

double SunShadow::zoneDepth(const FogProfile::Zone& zone, const Vec3& point) const {
  const double height = point.z() - fog_.domainCorner().z();
  const double begin = std::max(0.0, (zone.bottom - height) / sun_.z());
  const double end = (zone.top - height) / sun_.z();
  if (!(begin < end))
    return 0;
  const auto placeAt = [&](double t) -> Vec3 { return point + t * sun_; };
  const auto momentsAfter = [&](double t) { return momentsAt(placeAt(t).x(), placeAt(t).y()); };
  if (zone.decay != 0) {
    const Vec3 from = placeAt(begin);
    return zone(height + begin * sun_.z()) * decayingAt(from.x(), from.y());
  }

  const double cells = (end - begin) * std::hypot(sun_.x(), sun_.y()) / fog_.cell();
  if (cells < kSteepCells) {
    double depth = 0;
    const int parts = static_cast<int>(cells) + 1;
    for (int k = 0; k < parts; ++k) {
      const double from = begin + (end - begin) * k / parts;
      depth += gaussIntegral(3, from, from + (end - begin) / parts, [&](double t) {
        const double x = (placeAt(t).x() - x0_) / step_, y = (placeAt(t).y() - y0_) / step_;
        const bool inside = x >= 0 && y >= 0 && x <= rho_->columns - 1 && y <= rho_->rows - 1;
        return inside ? zone(height + t * sun_.z()) * rho_->at(x, y) : 0.0;
      });
    }
    return depth;
  }
  const Moments from = momentsAfter(begin), to = momentsAfter(end);
  double depth = zone(height) * (from.i0 - to.i0);
  if (zone.slope != 0)
    depth += zone.slope * sun_.z() * (from.i1 + begin * from.i0 - (to.i1 + end * to.i0));
  return depth;
}

SunShadow::Maps SunShadow::maps() const {
  Maps out{i0_->columns, i0_->rows, x0_, y0_, step_, decay_, {}};
  for (std::size_t i = 0; i < i0_->values.size(); ++i) {
    for (const Map* map : {rho_.get(), i0_.get(), i1_.get(), s_.get()})
      out.texels.push_back(map ? map->values[i] : 0);
  }
  return out;
}

double SunShadow::opticalDepth(const Vec3& point) const {
  double depth = 0;
  for (const auto& zone : fog_.profile().zones()) depth += zoneDepth(zone, point);
  return std::max(0.0, depth);
}

void SunShadow::shares(std::span<const Vec3> points, std::span<double> shares) const {
  VOLUTE_ASSERT(points.size() == shares.size());
  const double floor = fog_.domainCorner().z();
  SunLook look{.density = rho_->values.data(),
               .columns = i0_->columns,
               .rows = i0_->rows,
               .alongX = static_cast<float>(sun_.x() / step_),
               .alongY = static_cast<float>(sun_.y() / step_),
               .rise = static_cast<float>(sun_.z()),
               .cells = static_cast<float>(std::hypot(sun_.x(), sun_.y()) / fog_.cell())};
  alignas(64) float x[kAtOnce], y[kAtOnce], height[kAtOnce], depths[kAtOnce];
  for (std::size_t first = 0; first < points.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, points.size() - first);
    const std::size_t padded = (count + 15) / 16 * 16;
    for (std::size_t i = 0; i < padded; ++i) {
      const Vec3& point = points[first + std::min(i, count - 1)];
      x[i] = static_cast<float>((point.x() - x0_) / step_);
      y[i] = static_cast<float>((point.y() - y0_) / step_);
      height[i] = static_cast<float>(point.z() - floor);
      depths[i] = 0;
    }
    for (const FogProfile::Zone& zone : fog_.profile().zones()) {
      if (zone.slope != 0) {  // a difference of large moments
        for (std::size_t i = 0; i < count; ++i)
          depths[i] += static_cast<float>(zoneDepth(zone, points[first + i]));
        continue;
      }
      look.values = (zone.decay != 0 ? *s_ : *i0_).values.data();
      look.bottom = static_cast<float>(zone.bottom);
      look.top = static_cast<float>(zone.top);
      look.value = static_cast<float>(zone.value);
      look.decay = static_cast<float>(zone.decay);
      look.reference = static_cast<float>(zone.reference);
      HWY_DYNAMIC_DISPATCH(AddZone)(look, x, y, height, padded, depths);
    }
    HWY_DYNAMIC_DISPATCH(Pass)(padded, depths);
    for (std::size_t i = 0; i < count; ++i) shares[first + i] = depths[i];
  }
}

}  // namespace volute
#endif
