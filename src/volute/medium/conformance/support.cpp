// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance/support.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/medium/conformance/random.hpp"

namespace volute::conformance {
namespace {

/// The mean of the finite magnitudes, or 1 when they are all zero.
class Typical {
 public:
  void see(double value) {
    if (!std::isfinite(value) || value == 0)
      return;
    sum_ += std::abs(value);
    ++count_;
  }

  double size() const { return count_ > 0 ? sum_ / count_ : 1; }

 private:
  double sum_ = 0;
  int count_ = 0;
};

}  // namespace

Traits completed(Traits traits, const Box3& bounds) {
  constexpr double kExtent = 10;
  if (traits.region.empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      double& from = traits.region.min[axis];
      double& to = traits.region.max[axis];
      from = std::isfinite(bounds.min[axis]) ? bounds.min[axis] : -kExtent;
      to = std::isfinite(bounds.max[axis]) ? bounds.max[axis] : kExtent;
      if (!(from < to))
        to = from + kExtent;  // the bounds are wrong, and a check says so
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    auto& planes = traits.planes[axis];
    for (double face : {bounds.min[axis], bounds.max[axis]}) {
      if (std::isfinite(face))
        planes.push_back(face);
    }
    std::sort(planes.begin(), planes.end());
    planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
  }
  return traits;
}

Interval insideBounds(const MediumUnderTest& tested, const Segment& segment) {
  return tested.medium.bounds()
      .intersect(segment.origin, segment.direction)
      .intersect({segment.begin, segment.end});
}

Segment backwards(const Segment& segment) {
  return {segment.origin, -segment.direction, -segment.end, -segment.begin};
}

double parameterInside(const MediumUnderTest& tested, const Segment& segment, double share) {
  Interval range = insideBounds(tested, segment);
  if (range.empty())
    range = {segment.begin, segment.end};
  const double far = 10 * tested.traits.region.size().norm();
  if (std::isinf(range.begin))
    range.begin = std::min(range.end, far) - 2 * far;
  if (std::isinf(range.end))
    range.end = range.begin + 2 * far;
  return range.begin + share * (range.end - range.begin);
}

double depthOf(const AnyMedium& medium, const Segment& segment) {
  double depth = std::numeric_limits<double>::quiet_NaN();
  medium.opticalDepth({&segment, 1}, {&depth, 1});
  return depth;
}

std::vector<Piece> piecesOf(const AnyMedium& medium, const Segment& segment) {
  std::vector<Piece> pieces;
  medium.pieces({&segment, 1}, {&pieces, 1});
  return pieces;
}

Radiance radianceOf(const AnyMedium& medium, const Segment& segment) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Radiance radiance{Rgb::Constant(kNan), kNan};
  medium.radiance({&segment, 1}, {&radiance, 1});
  return radiance;
}

Rgb emissionOf(std::span<const Piece> pieces) {
  Rgb sum = Rgb::Zero();
  for (const Piece& piece : pieces) sum += pieceEmission(piece);
  return sum;
}

Scale scaleOf(const MediumUnderTest& tested) {
  Typical depth, emission, extinctionAtPoints, emissionAtPoints;
  for (const NamedSegment& named : segmentsOf(tested)) {
    depth.see(depthOf(tested.medium, named.segment));
    emission.see(emissionOf(piecesOf(tested.medium, named.segment)).maxCoeff());
  }
  Random random(tested.traits.seed + 17);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point = random.pointIn(tested.traits.region);
    extinctionAtPoints.see(tested.medium.extinction(point));
    emissionAtPoints.see(tested.medium.emission(point).maxCoeff());
  }
  return {tested.traits.region.size().norm(), depth.size(), emission.size(),
          extinctionAtPoints.size(), emissionAtPoints.size()};
}

bool near(double a, double b, double relative, double scale) {
  if (a == b)
    return true;
  return std::abs(a - b) <= relative * std::max({std::abs(a), std::abs(b), scale}) &&
         std::isfinite(a - b);
}

bool near(const Rgb& a, const Rgb& b, double relative, double scale) {
  return near(a[0], b[0], relative, scale) && near(a[1], b[1], relative, scale) &&
         near(a[2], b[2], relative, scale);
}

bool near(const Radiance& a, const Radiance& b, double relative, const Scale& scale) {
  return near(a.emitted, b.emitted, relative, scale.emission) &&
         near(a.transmittance, b.transmittance, relative, 1);
}

std::string text(const Segment& segment) {
  const Vec3& o = segment.origin;
  const Vec3& d = segment.direction;
  return fmt::format(
      "{{Vec3({:.17g}, {:.17g}, {:.17g}), Vec3({:.17g}, {:.17g}, {:.17g}), {:.17g}, {:.17g}}}",
      o[0], o[1], o[2], d[0], d[1], d[2], segment.begin, segment.end);
}

std::string text(const Rgb& rgb) {
  return fmt::format("({:.10g}, {:.10g}, {:.10g})", rgb[0], rgb[1], rgb[2]);
}

std::string text(const Radiance& radiance) {
  return fmt::format("{} behind a transmittance of {:.10g}", text(radiance.emitted),
                     radiance.transmittance);
}

Failures Report::take() {
  if (count_ > kShown)
    failures_.push_back(fmt::format("... and {} more", count_ - kShown));
  return std::move(failures_);
}

}  // namespace volute::conformance
