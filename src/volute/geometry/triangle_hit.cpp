// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/geometry/triangle_hit.hpp"

namespace volute {

SegmentTest::SegmentTest(const Segment& segment) : segment_(segment) {
  const Vec3& d = segment.direction;
  d.cwiseAbs().maxCoeff(&z_);
  x_ = (z_ + 1) % 3;
  y_ = (z_ + 2) % 3;
  shearX_ = d[x_] / d[z_];
  shearY_ = d[y_] / d[z_];
  scaleZ_ = 1 / d[z_];
}

std::optional<double> SegmentTest::meets(const Triangle& triangle) const {
  Vec3 p[3];  // corners in a frame in which the ray goes along z from the origin
  for (int i = 0; i < 3; ++i) {
    const Vec3 corner = triangle.corners[i] - segment_.origin;
    p[i] = {corner[x_] - shearX_ * corner[z_], corner[y_] - shearY_ * corner[z_],
            scaleZ_ * corner[z_]};
  }
  const double u = p[2].x() * p[1].y() - p[2].y() * p[1].x();
  const double v = p[0].x() * p[2].y() - p[0].y() * p[2].x();
  const double w = p[1].x() * p[0].y() - p[1].y() * p[0].x();
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0))
    return std::nullopt;
  const double area = u + v + w;
  if (area == 0)
    return std::nullopt;
  const double distance = (u * p[0].z() + v * p[1].z() + w * p[2].z()) / area;
  if (!(distance > segment_.begin && distance < segment_.end))
    return std::nullopt;
  return distance;
}

}  // namespace volute
