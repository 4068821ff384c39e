// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/camera/lens.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr double kTolerance = 1e-12;

double radialFactor(const Distortion& lens, double r2) {
  return 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
}

Mat2 jacobian(const Distortion& lens, const Vec2& point) {
  const double x = point.x(), y = point.y(), r2 = point.squaredNorm();
  const double radial = radialFactor(lens, r2);
  const double slope = 2 * (lens.k1 + r2 * (2 * lens.k2 + 3 * r2 * lens.k3));
  const double mixed = x * y * slope + 2 * lens.p1 * x + 2 * lens.p2 * y;
  return {radial + x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x, mixed, mixed,
          radial + y * y * slope + 6 * lens.p1 * y + 2 * lens.p2 * x};
}

/// Newton's method with halved steps where a whole one does not come closer.
std::optional<Vec2> solve(const Distortion& lens, const Vec2& target, Vec2 point) {
  constexpr int kMaxSteps = 50;
  const double enough = kTolerance * std::max(1.0, target.norm());
  Vec2 miss = distort(lens, point) - target;
  for (int i = 0; i < kMaxSteps && !(miss.norm() <= 1e-3 * enough); ++i) {
    const Mat2 slope = jacobian(lens, point);
    if (!(std::abs(slope.determinant()) > 1e-9))
      return std::nullopt;
    const Vec2 step = slope.inverse() * miss;
    double share = 1;
    Vec2 next = point - step;
    while (!((distort(lens, next) - target).norm() < miss.norm()) && share > 1e-3) {
      share /= 2;
      next = point - share * step;
    }
    const Vec2 nextMiss = distort(lens, next) - target;
    if (!(nextMiss.norm() < miss.norm()))
      break;  // rounding, or a valley without a solution
    point = next;
    miss = nextMiss;
  }
  if (!(miss.norm() <= enough))
    return std::nullopt;
  return point;
}

}  // namespace

Vec2 distort(const Distortion& lens, const Vec2& point) {
  const double x = point.x(), y = point.y(), r2 = point.squaredNorm();
  const double radial = radialFactor(lens, r2);
  return {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
          y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y};
}

bool beforeFold(const Distortion& lens, const Vec2& point) {
  constexpr int kPlaces = 16;
  if (lens.none())
    return true;
  for (int i = 1; i <= kPlaces; ++i) {
    const Mat2 slope = jacobian(lens, point * (static_cast<double>(i) / kPlaces));
    if (!(slope.determinant() > 0 && slope.trace() > 0))
      return false;
  }
  return true;
}

std::optional<Vec2> undistort(const Distortion& lens, const Vec2& distorted) {
  if (lens.none())
    return distorted;
  auto point = solve(lens, distorted, distorted);
  // A strong lens may send Newton's first step beyond the fold: walk out from the middle instead.
  constexpr int kPlaces = 16;
  if (!point || !beforeFold(lens, *point)) {
    point = Vec2::Zero();
    for (int i = 1; i <= kPlaces && point; ++i)
      point = solve(lens, distorted * (static_cast<double>(i) / kPlaces), *point);
  }
  if (!point || !beforeFold(lens, *point))
    return std::nullopt;
  return point;
}

}  // namespace volute
