// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/light_blockers.hpp"

#include "volute/base/content_hash.hpp"

namespace volute {
namespace {

/// Vertices of a mesh lie on the walls that the geometry shows, but for the rounding of two files:
/// of the geometry's size, and of coordinates as float. So may lamps.
constexpr double kLift = 1e-5;
constexpr double kTransformRounding = 2.5e-7;

}  // namespace

Blocks blocksOf(const TriangleScene& geometry) {
  if (geometry.empty())
    return {};
  return [geometry](std::span<const Segment> segments, std::span<std::uint8_t> blocked) {
    const double lift = kLift * (1 + geometry.bounds().size().maxCoeff());
    std::vector<Segment> lifted(segments.begin(), segments.end());
    for (Segment& segment : lifted) {
      const double from = lift + kTransformRounding * segment.origin.cwiseAbs().maxCoeff();
      segment.begin += from, segment.end -= from;
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
