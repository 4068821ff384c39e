// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <compare>

namespace volute {
namespace {

struct PlanePoint {
  double x = 0, y = 0;

  auto operator<=>(const PlanePoint&) const = default;
};

/// Twice the area of a triangle, positive where it turns left.
double turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The corners as seen along the mean normal (Newell's), turning left; empty: without area.
std::vector<PlanePoint> seenAlongNormal(std::span<const Vec3> corners) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
    normal += a.cross(b);
  }
  int axis = 0;
  if (!(normal.cwiseAbs().maxCoeff(&axis) > 0) || !normal.allFinite())
    return {};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<PlanePoint> points;
  points.reserve(corners.size());
  for (const Vec3& corner : corners) {
    const Vec3 from = corner - corners[0];
    points.push_back(normal[axis] > 0 ? PlanePoint{from[u], from[v]}
                                      : PlanePoint{from[v], from[u]});
  }
  return points;
}

/// Turns left at each corner, and once around in all.
bool isConvex(const std::vector<PlanePoint>& points) {
  const std::size_t n = points.size();
  int changes = 0;
  bool rising = false, known = false;
  for (std::size_t i = 0; i <= n; ++i) {
    const PlanePoint a = points[i % n], b = points[(i + 1) % n], c = points[(i + 2) % n];
    if (turn(a, b, c) < 0)
      return false;
    if (a.x == b.x)
      continue;
    changes += known && (b.x > a.x) != rising ? 1 : 0;
    rising = b.x > a.x, known = true;
  }
  return changes <= 2;
}

/// Cuts ears. Reflex corners, the only ones that may lie in a triangle of neighbours, are found
/// through a tree, however unevenly they are spread.
class EarCutter {
 public:
  explicit EarCutter(std::vector<PlanePoint> points)
      : points_(std::move(points)),
        next_(points_.size()),
        previous_(points_.size()),
        reflex_(points_.size()),
        budget_(kStepsPerCorner * points_.size()) {
    const auto n = static_cast<std::uint32_t>(points_.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      reflex_[i] = turnAt(i) <= 0;
      tree_.push_back(i);
    }
    fillTree();
  }

  Result<std::vector<std::array<std::uint32_t, 3>>> cut() {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::size_t left = points_.size();
    triangles.reserve(left - 2);
    std::uint32_t at = 0;
    int rounds = 0;  // without an ear
    for (std::size_t waited = 0; left > 3;) {
      if (steps_ > budget_)
        return fail(ErrorCode::kTooLarge, "its outline is too intricate");
      const double area = turnAt(at);
      // After one round without an ear the polygon crosses itself: cut what turns left, or all.
      // After many of them it does so everywhere, and no ear is looked for any more.
      const bool flat = area == 0 || points_[at] == points_[next_[at]];
      rounds += waited == left + 1 ? 1 : 0;
      const bool crossing = rounds > kMaxRounds;
      const bool ear =
          flat || crossing || waited > 2 * left || (area > 0 && (waited > left || isEar(at)));
      ++steps_;
      if (!ear) {
        at = next_[at];
        ++waited;
        continue;
      }
      if (!flat)
        triangles.push_back({previous_[at], at, next_[at]});
      remove(at);
      --left;
      waited = 0;
      at = next_[next_[at]];
    }
    if (turnAt(at) != 0)
      triangles.push_back({previous_[at], at, next_[at]});
    if (rounds > kMaxRounds)
      keepOneOfEach(triangles);
    return triangles;
  }

 private:
  static constexpr std::size_t kStepsPerCorner = 1000;
  static constexpr int kMaxRounds = 64;

  /// An outline that goes around many times has one triangle many times, and each ray would meet
  /// them all.
  void keepOneOfEach(std::vector<std::array<std::uint32_t, 3>>& triangles) const {
    const auto place = [&](const std::array<std::uint32_t, 3>& t) {
      std::array points{points_[t[0]], points_[t[1]], points_[t[2]]};
      std::ranges::sort(points);
      return points;
    };
    std::ranges::sort(triangles, {}, place);
    const auto rest = std::ranges::unique(triangles, {}, place);
    triangles.erase(rest.begin(), rest.end());
  }

  double turnAt(std::uint32_t i) const {
    return turn(points_[previous_[i]], points_[i], points_[next_[i]]);
  }

  void remove(std::uint32_t i) {
    const std::uint32_t before = previous_[i], after = next_[i];
    next_[before] = after;
    previous_[after] = before;
    reflexes_ -= reflex_[i] ? 1 : 0;
    reflex_[i] = false;
    // Corners only become convex as ears go; flat ones stay until they are met.
    for (const std::uint32_t near : {before, after}) {
      if (!reflex_[near] || turnAt(near) <= 0)
        continue;
      reflex_[near] = false;
      --reflexes_;
    }
    if (2 * reflexes_ < tree_.size())
      fillTree();
  }

  /// The reflex corners that are left, as a k-d tree: the middle one of a range parts the others by
  /// x and y in turn.
  void fillTree() {
    std::erase_if(tree_, [&](std::uint32_t i) { return !reflex_[i]; });
    reflexes_ = tree_.size();
    part(0, tree_.size(), true);
  }

  void part(std::size_t begin, std::size_t end, bool byX) {
    if (end - begin < 2)
      return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t k) { return tree_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      return byX ? points_[a].x < points_[b].x : points_[a].y < points_[b].y;
    });
    part(begin, middle, !byX);
    part(middle + 1, end, !byX);
  }

  /// Three corners that follow each other, and the box around them.
  struct Ear {
    PlanePoint a, b, c, least, most;
  };

  /// Whether no reflex corner of a range of the tree lies in the triangle. Corners at the same
  /// place as one of its own are where a hole is joined to the outline.
  bool isFree(const Ear& ear, std::size_t begin, std::size_t end, bool byX) {
    if (begin == end || steps_ > budget_)
      return true;
    const std::size_t middle = begin + (end - begin) / 2;
    const PlanePoint p = points_[tree_[middle]];
    ++steps_;
    const auto& [a, b, c, least, most] = ear;
    if (reflex_[tree_[middle]] && p != a && p != b && p != c && turn(a, b, p) >= 0 &&
        turn(b, c, p) >= 0 && turn(c, a, p) >= 0)
      return false;
    const bool below = byX ? least.x <= p.x : least.y <= p.y;
    const bool above = byX ? most.x >= p.x : most.y >= p.y;
    return (!below || isFree(ear, begin, middle, !byX)) &&
           (!above || isFree(ear, middle + 1, end, !byX));
  }

  bool isEar(std::uint32_t i) {
    const PlanePoint a = points_[previous_[i]], b = points_[i], c = points_[next_[i]];
    const Ear ear{a,
                  b,
                  c,
                  {std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y})},
                  {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y})}};
    return isFree(ear, 0, tree_.size(), true);
  }

  std::vector<PlanePoint> points_;
  std::vector<std::uint32_t> next_, previous_;
  std::vector<char> reflex_;
  std::vector<std::uint32_t> tree_;
  std::size_t reflexes_ = 0;  ///< of the tree, that still are
  std::size_t steps_ = 0, budget_;
};

}  // namespace

Result<std::vector<std::array<std::uint32_t, 3>>> trianglesOf(std::span<const Vec3> corners) {
  std::vector<PlanePoint> points;
  if (corners.size() > 3)
    points = seenAlongNormal(corners);
  if (!points.empty() && !isConvex(points))
    return EarCutter(std::move(points)).cut();
  std::vector<std::array<std::uint32_t, 3>> fan;
  for (std::uint32_t i = 1; i + 1 < corners.size(); ++i) fan.push_back({0, i, i + 1});
  return fan;
}

}  // namespace volute
