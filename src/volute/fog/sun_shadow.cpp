// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sun_shadow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/fog/fog_march.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

constexpr double kLowest = 1e-3;     // sine of the sun's height
constexpr double kSteepCells = 3.0;  // over so many cells a zone is integrated by Gauss points

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

SunShadow::Map SunShadow::sampled(const FogProfile& profile, double factor) const {
  const FogMedium fog = fog_.withProfile(profile);
  const CellRect cells = fog_.levels().mapCells();
  const int perCell = static_cast<int>(std::lround(fog_.cell() / step_));
  Map map;
  map.columns = (cells.x1 - cells.x0) * perCell + 1;
  map.rows = (cells.y1 - cells.y0) * perCell + 1;
  map.values.resize(static_cast<std::size_t>(map.columns) * map.rows);
  parallelRanges(map.rows, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<Segment> segments(map.columns);
    std::vector<double> depths(map.columns);
    for (std::size_t j = begin; j < end; ++j) {
      for (int i = 0; i < map.columns; ++i) {
        const Vec3 from(x0_ + i * step_, y0_ + static_cast<double>(j) * step_,
                        fog_.domainCorner().z());
        segments[i] = {from, sun_, 0, std::numeric_limits<double>::infinity()};
      }
      marchDepths(fog, segments, depths, std::numeric_limits<float>::max());
      for (int i = 0; i < map.columns; ++i)
        map.values[j * map.columns + i] = static_cast<float>(factor * depths[i]);
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
  shadow.i0_ = std::make_shared<const Map>(shadow.sampled({}, 1));
  shadow.rho_ = std::make_shared<const Map>(shadow.sampledDensity());
  for (const auto& zone : fog.profile().zones()) {
    if (zone.slope != 0 && !shadow.i1_) {
      // g = z / highest, and z = s_z t.
      const double highest = FogProfile::kFarthest;
      const FogProfile::Knot knots[] = {{0, 0}, {highest, 1}};
      shadow.i1_ = std::make_shared<const Map>(
          shadow.sampled(*FogProfile::linear(knots), highest / sun.z()));
    }
    if (zone.decay != 0 && !shadow.s_) {
      shadow.decay_ = zone.decay;
      shadow.s_ = std::make_shared<const Map>(
          shadow.sampled(*FogProfile::exponential(0, 1 / zone.decay), 1));
    }
  }
  return shadow;
}

SunShadow::Moments SunShadow::momentsAt(double x, double y) const {
  double u = (x - x0_) / step_, v = (y - y0_) / step_, in = 0;
  const double lastU = i0_->columns - 1, lastV = i0_->rows - 1;
  if (!(u >= 0 && v >= 0 && u <= lastU && v <= lastV)) {
    // A place before the fog: as from where the ray enters, `in` later.
    const Box3 box{Vec3(0, 0, -1), Vec3(lastU, lastV, 1)};
    const Vec3 direction(sun_.x() / step_, sun_.y() / step_, 0);
    const Interval inside = box.intersect(Vec3(u, v, 0), direction);
    if (inside.empty() || !(inside.end > 0))
      return {};
    in = std::max(0.0, inside.begin);
    u += in * direction.x();
    v += in * direction.y();
  }
  Moments out;
  out.i0 = i0_->at(u, v);
  out.i1 = i1_ ? i1_->at(u, v) + in * out.i0 : 0;
  out.s = s_ ? s_->at(u, v) * (in > 0 ? std::exp(-decay_ * sun_.z() * in) : 1) : 0;
  return out;
}

double SunShadow::zoneDepth(const FogProfile::Zone& zone, const Vec3& point) const {
  const double height = point.z() - fog_.domainCorner().z();
  const double begin = std::max(0.0, (zone.bottom - height) / sun_.z());
  const double end = (zone.top - height) / sun_.z();
  if (!(begin < end))
    return 0;
  const auto placeAt = [&](double t) -> Vec3 { return point + t * sun_; };
  const auto momentsAfter = [&](double t) { return momentsAt(placeAt(t).x(), placeAt(t).y()); };
  if (zone.decay != 0)
    return zone(height + begin * sun_.z()) * momentsAfter(begin).s;

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

}  // namespace volute
