// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/light_blockers.hpp"

#include "volute/base/content_hash.hpp"

namespace volute {
namespace {

constexpr double kLift = 1e-5;       ///< [m]
constexpr double kRounding = 1e-14;  ///< of the coordinates

}  // namespace

double surfaceLift(const Vec3& point) {
  return kLift + kRounding * point.cwiseAbs().maxCoeff();
}

Blocks blocksOf(const TriangleScene& geometry) {
  if (geometry.empty())
    return {};
  return [geometry](std::span<const Segment> segments, std::span<std::uint8_t> blocked) {
    std::vector<Segment> lifted(segments.begin(), segments.end());
    for (Segment& segment : lifted) {
      const double lift = surfaceLift(segment.origin);
      segment.begin += lift, segment.end -= lift;
    }
    geometry.occluded(lifted, blocked);
  };
}

ShadowsOn shadowsOf(const TriangleScene& geometry) {
  if (geometry.empty())
    return {};
  return [geometry](const Segment& segment, const Lamp& lamp, std::vector<Interval>& dark) {
    const bool sun = lamp.kind == Lamp::Kind::kSun;
    geometry.shadows(segment, {sun ? Vec3(-lamp.direction) : lamp.position, sun}, dark);
  };
}

std::string keyOf(const TriangleScene& geometry) {
  ContentHash hash;
  for (const Triangle& triangle : geometry.triangles()) {
    for (const Vec3& corner : triangle.corners) hash.add(std::span<const double>(corner.data(), 3));
  }
  return hash.digits();
}

}  // namespace volute
