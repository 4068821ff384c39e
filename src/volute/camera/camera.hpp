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
///
/// Every view gives a camera: one whose target is its eye looks along +y, and one whose up is zero
/// or along the view takes the world axis that is furthest from the view instead (z before y before
/// x where they tie).
class Camera {
 public:
  /// `fov`: vertical, in degrees, 0 < fov < 180.
  static Camera pinhole(const View3& view, double fov, int width, int height);

  /// `extent`: the height of the view volume [m], > 0 (Ahrenberg et al. 2005, section 5.2 and
  /// equation 13: a block-shaped view volume; their time translation is the medium's instant).
  static Camera orthographic(const View3& view, double extent, int width, int height);

  /// Frames `bounds` from a little above and beside, with a margin. Empty or infinite bounds count
  /// as a cube of 1 m around the origin.
  static Camera framing(const Box3& bounds, int width, int height);

  int width() const { return width_; }

  int height() const { return height_; }

  bool isOrthographic() const { return orthographic_; }

  const Vec3& eye() const { return eye_; }

  const Vec3& right() const {
    return right_;
  }  ///< unit length, as `down` and `forward`; right x down = forward

  const Vec3& down() const { return down_; }

  const Vec3& forward() const { return forward_; }

  /// The side of a pixel: at distance 1 along `forward` (pinhole, dimensionless) or in the world
  /// (orthographic) [m].
  double pixelSize() const { return pixelSize_; }

  /// The ray through image point (px, py) in pixels; (x + 0.5, y + 0.5) for pixel centres. It
  /// begins at the eye (pinhole) or extends both ways (orthographic: begin = -infinity), has no
  /// near plane, and ends at infinity.
  Segment ray(double px, double py) const;

 private:
  Camera(const View3& view, int width, int height);

  bool orthographic_ = false;
  int width_ = 0, height_ = 0;
  Vec3 eye_, right_, down_, forward_;
  double pixelSize_ = 0;
};

}  // namespace volute
