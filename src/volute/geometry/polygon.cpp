// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/polygon.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace volute {
namespace {

struct PlanePoint {
  double x = 0, y = 0;

  bool operator==(const PlanePoint&) const = default;
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
  Eigen::Index axis = 0;
  if (!(normal.cwiseAbs().maxCoeff(&axis) > 0) || !normal.allFinite())
    return {};
  const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
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
/// through a grid of cells.
class EarCutter {
 public:
  explicit EarCutter(std::vector<PlanePoint> points)
      : points_(std::move(points)),
        next_(points_.size()),
        previous_(points_.size()),
        reflex_(points_.size()) {
    const auto n = static_cast<std::uint32_t>(points_.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
    for (std::uint32_t i = 0; i < n; ++i) reflex_[i] = turnAt(i) <= 0;
    fillGrid();
  }

  Result<std::vector<std::array<std::uint32_t, 3>>> cut() {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::size_t left = points_.size();
    triangles.reserve(left - 2);
    const std::size_t budget = kStepsPerCorner * left;
    std::uint32_t at = 0;
    for (std::size_t waited = 0; left > 3;) {
      if (steps_ > budget)
        return fail(ErrorCode::kTooLarge, "its outline is too intricate");
      const double area = turnAt(at);
      // After one round without an ear the polygon crosses itself: cut what turns left, or all.
      const bool flat = area == 0 || points_[at] == points_[next_[at]];
      const bool ear = flat || waited > 2 * left || (area > 0 && (waited > left || isEar(at)));
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
    return triangles;
  }

 private:
  static constexpr std::size_t kStepsPerCorner = 1000;

  double turnAt(std::uint32_t i) const {
    return turn(points_[previous_[i]], points_[i], points_[next_[i]]);
  }

  void remove(std::uint32_t i) {
    const std::uint32_t before = previous_[i], after = next_[i];
    next_[before] = after;
    previous_[after] = before;
    reflex_[i] = false;
    // Corners only become convex as ears go; flat ones stay until they are met.
    for (const std::uint32_t near : {before, after})
      reflex_[near] = reflex_[near] && turnAt(near) <= 0;
  }

  void fillGrid() {
    std::vector<std::uint32_t> reflexes;
    PlanePoint most = points_[0];
    least_ = most;
    for (std::uint32_t i = 0; i < points_.size(); ++i) {
      least_ = {std::min(least_.x, points_[i].x), std::min(least_.y, points_[i].y)};
      most = {std::max(most.x, points_[i].x), std::max(most.y, points_[i].y)};
      if (reflex_[i])
        reflexes.push_back(i);
    }
    side_ =
        std::clamp<int>(static_cast<int>(std::sqrt(static_cast<double>(reflexes.size()))), 1, 1024);
    const double width = std::max(most.x - least_.x, most.y - least_.y);
    scale_ = width > 0 ? side_ / width : 0;
    const auto cells = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
    begins_.assign(cells + 1, 0);
    for (const std::uint32_t i : reflexes) ++begins_[cellOf(points_[i]) + 1];
    for (std::size_t i = 0; i < cells; ++i) begins_[i + 1] += begins_[i];
    members_.resize(reflexes.size());
    std::vector<std::size_t> at(begins_.begin(), begins_.end() - 1);
    for (const std::uint32_t i : reflexes) members_[at[cellOf(points_[i])]++] = i;
  }

  int along(double value, double least) const {
    return std::clamp(static_cast<int>((value - least) * scale_), 0, side_ - 1);
  }

  std::size_t cellOf(PlanePoint p) const {
    return static_cast<std::size_t>(along(p.y, least_.y)) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(along(p.x, least_.x));
  }

  /// Whether no other corner lies in the triangle of `i` and its neighbours. Corners at the same
  /// place as one of these are where a hole is joined to the outline.
  bool isEar(std::uint32_t i) {
    const PlanePoint a = points_[previous_[i]], b = points_[i], c = points_[next_[i]];
    const int x0 = along(std::min({a.x, b.x, c.x}), least_.x),
              x1 = along(std::max({a.x, b.x, c.x}), least_.x),
              y0 = along(std::min({a.y, b.y, c.y}), least_.y),
              y1 = along(std::max({a.y, b.y, c.y}), least_.y);
    for (int y = y0; y <= y1; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(side_);
      const std::size_t begin = begins_[row + static_cast<std::size_t>(x0)],
                        end = begins_[row + static_cast<std::size_t>(x1) + 1];
      ++steps_;
      for (std::size_t k = begin; k < end; ++k) {
        ++steps_;
        const std::uint32_t other = members_[k];
        if (!reflex_[other] || other == previous_[i] || other == next_[i])
          continue;
        const PlanePoint p = points_[other];
        if (p == a || p == b || p == c)
          continue;
        if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0)
          return false;
      }
    }
    return true;
  }

  std::vector<PlanePoint> points_;
  std::vector<std::uint32_t> next_, previous_;
  std::vector<char> reflex_;
  PlanePoint least_;
  double scale_ = 0;
  int side_ = 1;
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> members_;
  std::size_t steps_ = 0;
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
