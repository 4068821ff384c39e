// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/occluded_sight.hpp"

#include <limits>

namespace volute {
namespace {

constexpr double kShort = 1e-9;  ///< a target on a surface is seen

}  // namespace

std::vector<std::uint8_t> OccludedSight::occluded(std::span<const SightLine> lines) const {
  std::vector<Segment> segments;
  for (const SightLine& line : lines) {
    const double length = line.length();
    const Vec3 way = line.target - line.eye;
    segments.push_back(
        {line.eye, length > 0 ? Vec3(way / length) : Vec3::UnitX(), 0, length * (1 - kShort)});
  }
  std::vector<std::uint8_t> blocked(lines.size(), 0);
  surfaces_.occluded(segments, blocked);
  return blocked;
}

/// 1 of points in a body: the first triangle above them faces up.
std::vector<std::uint8_t> OccludedSight::within(std::span<const Vec3> points) const {
  std::vector<std::uint8_t> within(points.size(), 0);
  if (what_ == Surfaces::kSheets)
    return within;
  std::vector<Segment> up;
  for (const Vec3& point : points) {
    const double above = surfaces_.bounds().max.z() - point.z() + 1;
    up.push_back({point, Vec3::UnitZ(), 0, std::max(above, 0.0)});
  }
  std::vector<Hit> hits(points.size());
  surfaces_.nearest(up, hits);
  for (std::size_t i = 0; i < points.size(); ++i)
    within[i] = hits[i].found() && surfaces_.outward(up[i], hits[i]).z() > 0;
  return within;
}

void OccludedSight::look(std::span<const SightLine> lines, std::span<Sight> sights) const {
  media_->look(lines, sights);
  const auto behind = occluded(lines);
  for (std::size_t i = 0; i < sights.size(); ++i) sights[i].blocked |= behind[i] != 0;
}

void OccludedSight::blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const {
  media_->blocked(lines, out);
  const auto behind = occluded(lines);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] |= behind[i];
}

void OccludedSight::places(std::span<const Vec3> points, std::span<Place> places) const {
  media_->places(points, places);
  const auto solid = within(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (solid[i] != 0 && places[i] == Place::kGas)
      places[i] = Place::kSolid;
  }
}

void OccludedSight::extinction(std::span<const Vec3> points, std::span<double> extinction) const {
  media_->extinction(points, extinction);
  const auto solid = within(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (solid[i] != 0)
      extinction[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

void OccludedSight::extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                                     std::span<double> high) const {
  media_->extinctionBounds(points, low, high);
  const auto solid = within(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (solid[i] != 0)
      low[i] = high[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

void OccludedSight::floors(std::span<const Vec3> points, double drop, std::span<double> z) const {
  media_->floors(points, drop, z);
  // Or a surface, if it is higher.
  std::vector<Segment> down;
  for (const Vec3& point : points) down.push_back({point, Vec3(0, 0, -1), 0, drop});
  std::vector<Hit> hits(points.size());
  surfaces_.nearest(down, hits);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (hits[i].found() && !(points[i].z() - hits[i].distance < z[i]))
      z[i] = points[i].z() - hits[i].distance;
  }
}

void OccludedSight::weigh(const SightLine& line, std::vector<SightWeight>& weights,
                          Sight& sight) const {
  media_->weigh(line, weights, sight);
  sight.blocked |= occluded({&line, 1}).front() != 0;
}

}  // namespace volute
