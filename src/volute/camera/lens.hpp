// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/math/vec.hpp"

namespace volute {

/// Radial and tangential lens distortion as OpenCV has it (Brown 1966) of points of the image plane
/// at distance 1 in front of the camera, x to the right, y down, dimensionless: with r2 = x^2 +
/// y^2,
///   x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)
///   y' = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 y^2) + 2 p2 x y.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool none() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }

  bool operator==(const Distortion&) const = default;
};

/// Where the lens puts a point of the image plane.
Vec2 distort(const Distortion& lens, const Vec2& point);

/// True when the lens maps the straight way from the middle of the image to `point` without folding
/// over, so that the point shows in the image where distort() says and nowhere nearer.
bool beforeFold(const Distortion& lens, const Vec2& point);

/// The inverse of distort() near the middle of the image, by Newton's method to 1e-12. Nothing when
/// no point that the lens shows without folding over lands there: the polynomial has left the part
/// of the image that it was fitted to.
std::optional<Vec2> undistort(const Distortion& lens, const Vec2& distorted);

}  // namespace volute
