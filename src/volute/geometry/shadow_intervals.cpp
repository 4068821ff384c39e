// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/shadow_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kParallel = 1e-7;  ///< [rad]
constexpr double kInPlane = 1e-9;   ///< where a light is on a triangle, relative: rounding
constexpr double kGap = 1e-9;  ///< between shadows of neighbouring triangles, relative: rounding

/// The plane through a segment and a light.
class LightPlane {
 public:
  LightPlane(const Segment& segment, const Vec3& toLight, bool far)
      : origin_(segment.origin),
        toLight_(toLight),
        part_{segment.begin, segment.end},
        near_(far ? 0 : 1) {
    const Vec3 normal = segment.direction.cross(toLight);
    normal_ = normal.normalized();
    along_ = toLight.cross(normal) / normal.squaredNorm();
    across_ = normal.cross(segment.direction) / normal.squaredNorm();
  }

  /// Whether something in the box may stand between the light and the segment.
  bool mayMeet(const Box3& box) const {
    const Vec3 centre = 0.5 * (box.min + box.max) - origin_, half = 0.5 * (box.max - box.min);
    const auto most = [&](const Vec3& f) { return f.dot(centre) + f.cwiseAbs().dot(half); };
    if (std::abs(normal_.dot(centre)) > normal_.cwiseAbs().dot(half))
      return false;
    if (most(across_) < 0 || (near_ == 1 && -most(-across_) > 1))
      return false;
    // a >= begin (1 - c) and a <= end (1 - c); without c for a far light.
    if (std::isfinite(part_.begin) && most(along_ + near_ * part_.begin * across_) < part_.begin)
      return false;
    return !std::isfinite(part_.end) || -most(-(along_ + near_ * part_.end * across_)) <= part_.end;
  }

  /// What a triangle keeps the light from.
  std::optional<Interval> shadow(const Triangle& triangle) const {
    Vec3 corner[3];
    double height[3];
    for (int i = 0; i < 3; ++i) {
      corner[i] = triangle.corners[i] - origin_;
      height[i] = normal_.dot(corner[i]);
    }
    Vec3 cut[2];
    int cuts = 0;
    for (int i = 0; i < 3; ++i) {
      int low = i, high = (i + 1) % 3;
      if ((height[low] < 0) == (height[high] < 0))
        continue;
      if (height[low] >= 0)
        std::swap(low, high);  // the neighbour that shares this edge finds the same point
      const double share = height[low] / (height[low] - height[high]);
      cut[cuts++] = corner[low] + share * (corner[high] - corner[low]);
    }
    return cuts == 2 && !lightInPlane(triangle) ? project(cut[0], cut[1]) : std::nullopt;
  }

 private:
  /// No way to such a light crosses the triangle.
  bool lightInPlane(const Triangle& triangle) const {
    if (near_ == 0)
      return false;
    const Vec3 normal = triangle.normal(), way = origin_ + toLight_ - triangle.corners[0];
    const double size = way.norm() + triangle.corners[0].norm();
    return std::abs(normal.dot(way)) <= kInPlane * size * normal.norm();
  }

  /// The line between two points of the plane, seen from the light.
  std::optional<Interval> project(const Vec3& p, const Vec3& q) const {
    double a0 = along_.dot(p), a1 = along_.dot(q);
    double c0 = across_.dot(p), c1 = across_.dot(q);
    if (c0 > c1)
      std::swap(a0, a1), std::swap(c0, c1);
    const double slope = c1 > c0 ? (a1 - a0) / (c1 - c0) : 0;
    if (!(c1 > 0) || (near_ == 1 && !(c0 < 1)))
      return std::nullopt;
    if (c0 < 0)
      a0 -= slope * c0, c0 = 0;
    if (near_ == 1 && c1 > 1)
      a1 += slope * (1 - c1), c1 = 1;
    const double s0 = onSegment(a0, c0), s1 = onSegment(a1, c1);
    const Interval found = Interval{std::min(s0, s1), std::max(s0, s1)}.intersect(part_);
    return found.empty() ? std::nullopt : std::optional(found);
  }

  double onSegment(double a, double c) const {
    const double left = 1 - near_ * c;
    return left > 0 ? a / left : std::copysign(kInfinity, a);
  }

  Vec3 origin_, toLight_, normal_;
  Vec3 along_, across_;  ///< what a and c of a point are, by dot products
  Interval part_;
  double near_;  ///< 1 for a light at a point, 0 for a far one
};

/// Those that touch become one.
void unite(std::vector<Interval>& dark) {
  std::ranges::sort(dark, {}, &Interval::begin);
  std::size_t kept = 0;
  for (const Interval& next : dark) {
    if (kept > 0 && next.begin <= dark[kept - 1].end + kGap * (1 + std::abs(next.begin))) {
      dark[kept - 1].end = std::max(dark[kept - 1].end, next.end);
    } else {
      dark[kept++] = next;
    }
  }
  dark.resize(kept);
}

/// Adds one to those in order and apart; quick where it is among the last of them.
void addTo(std::vector<Interval>& dark, Interval next) {
  const auto touch = [](const Interval& a, const Interval& b) {
    return b.begin <= a.end + kGap * (1 + std::abs(b.begin));
  };
  if (dark.empty() || next.begin >= dark.back().begin) {
    if (!dark.empty() && touch(dark.back(), next))
      dark.back().end = std::max(dark.back().end, next.end);
    else
      dark.push_back(next);
    return;
  }
  std::size_t end = dark.size();
  while (end > 0 && !touch(next, dark[end - 1])) --end;
  std::size_t first = end;
  for (; first > 0 && touch(dark[first - 1], next); --first) {
    next.begin = std::min(next.begin, dark[first - 1].begin);
    next.end = std::max(next.end, dark[first - 1].end);
  }
  if (first == end) {
    dark.insert(dark.begin() + static_cast<std::ptrdiff_t>(end), next);
    return;
  }
  dark[first] = next;
  dark.erase(dark.begin() + static_cast<std::ptrdiff_t>(first + 1),
             dark.begin() + static_cast<std::ptrdiff_t>(end));
}

/// A segment that leads to the light, which is at `lamp` on it, perhaps infinite.
template <class Nearest>
void onLineOfLight(const Segment& segment, double lamp, Nearest&& nearest,
                   std::vector<Interval>& dark) {
  if (segment.begin < lamp) {  // seen from the lamp: back from it
    const Hit last = nearest({segment.origin, -segment.direction, -lamp, -segment.begin});
    if (last.found())
      dark.push_back(Interval{segment.begin, -last.distance}.intersect({-kInfinity, segment.end}));
  }
  if (segment.end > lamp) {
    const Hit first = nearest({segment.origin, segment.direction, lamp, segment.end});
    if (first.found())
      dark.push_back(Interval{first.distance, segment.end}.intersect({segment.begin, kInfinity}));
  }
  std::erase_if(dark, [](const Interval& part) { return part.empty(); });
}

}  // namespace

void shadowsOn(const Segment& segment, const LightPoint& light, const TriangleTree& tree,
               std::vector<Interval>& dark) {
  dark.clear();
  if (segment.empty())
    return;
  const Vec3 toLight = light.far ? light.place.normalized() : Vec3(light.place - segment.origin);
  const double length = toLight.norm();
  if (segment.direction.cross(toLight).norm() <= kParallel * length) {
    const double along = segment.direction.dot(toLight);
    onLineOfLight(
        segment, light.far ? std::copysign(kInfinity, along) : along,
        [&](const Segment& part) { return tree.nearest(part); }, dark);
    return;
  }
  const LightPlane plane(segment, toLight, light.far);
  tree.select([&](const Box3& box) { return plane.mayMeet(box); },
              [&](const Triangle& triangle) {
                if (const auto shadow = plane.shadow(triangle))
                  dark.push_back(*shadow);
              });
  unite(dark);
}

void shadowsOn(const Segment& segment, const LightPoint& light, const SunTree& tree,
               const TriangleScene& along, std::vector<Interval>& dark) {
  dark.clear();
  if (segment.empty())
    return;
  const Vec3 toLight = light.place.normalized();
  if (segment.direction.cross(toLight).norm() <= kParallel) {
    const auto nearest = [&](const Segment& part) {
      Hit hit;
      along.nearest({&part, 1}, {&hit, 1});
      return hit;
    };
    onLineOfLight(segment, std::copysign(kInfinity, segment.direction.dot(toLight)), nearest, dark);
    return;
  }
  tree.walk(
      segment, [&](const Interval& part) { addTo(dark, part); },
      [&](const Triangle& triangle, const Interval& part) {
        const auto shadow = LightPlane(segment, toLight, true).shadow(triangle);
        const Interval within = shadow ? shadow->intersect(part) : Interval{};
        if (!within.empty())
          addTo(dark, within);
      });
}

}  // namespace volute
