// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/math/vec.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Where a picture is taken from, the way people say it. z is up unless they say otherwise.
struct View3 {
  Vec3 eye = Vec3(0, -1, 0);
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
};

/// Pinhole or orthographic. Pixel (0, 0) is at the top left; its centre is (0.5, 0.5).
class Camera {
 public:
  /// `fov`: vertical, in degrees, 0 < fov < 180.
  static Camera pinhole(const View3& view, double fov, int width, int height);

  /// `extent`: the height of the view volume [m] (paper A, section 5.2 and equation 13: a block-shaped view volume).
  static Camera orthographic(const View3& view, double extent, int width, int height);

  /// Frames `bounds` from a little above and beside, with a margin.
  static Camera framing(const Box3& bounds, int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  bool isOrthographic() const { return orthographic_; }

  /// The ray through image point (px, py) in pixels; (x + 0.5, y + 0.5) for pixel centres. It begins at the eye
  /// (pinhole) or extends both ways (orthographic: begin = -infinity), has no near plane, and ends at infinity.
  Segment ray(double px, double py) const;

 private:
  bool orthographic_ = false;
  int width_ = 0, height_ = 0;
  Vec3 eye_, right_, down_, forward_;
  double pixelSize_ = 0;  // at distance 1 (pinhole) or in the world (orthographic) [m]
};

}  // namespace volute
