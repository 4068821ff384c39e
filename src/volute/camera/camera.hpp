// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/base/result.hpp"
#include "volute/camera/lens.hpp"
#include "volute/math/vec.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// A view as people describe it: eye, target, up (z by default).
struct View3 {
  Vec3 eye = Vec3(0, -1, 0);
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
};

/// A pinhole camera in the convention of calibrations. x right, y down, z forward:
///   x_cam = R x_world + t,  (x, y) = x_cam.xy / x_cam.z,  (x', y') = distort(x, y),
///   u = K(0,0) x' + K(0,1) y' + K(0,2),  v = K(1,1) y' + K(1,2).
struct Calibration {
  int width = 0;   ///< [pixels]
  int height = 0;  ///< [pixels]
  Mat3 K = Mat3::Identity();
  Mat3 R = Mat3::Identity();  ///< a rotation
  Vec3 t = Vec3::Zero();      ///< [m]
  Distortion distortion;
  /// (u, v) at the centre of the first pixel: 0.5 (COLMAP, NeRF transforms) or 0 (OpenCV).
  double pixelCentre = 0.5;
};

/// Pinhole or orthographic. Pixel (0, 0) is at the top left; its centre is (0.5, 0.5), whatever the
/// convention of the calibration that a camera was made from.
///
/// Every view gives a camera: one whose target is its eye looks along +y, and one whose up is zero
/// or along the view takes the world axis that is furthest from the view instead (z before y before
/// x where they tie).
class Camera {
 public:
  /// `fov`: vertical, in degrees, 0 < fov < 180.
  static Camera pinhole(const View3& view, double fov, int width, int height);

  /// `extent`: the height of the view volume [m], > 0 (Ahrenberg et al. 2005, section 5.2 and
  /// equation 13: a block-shaped view volume; their time translation is the medium's time).
  static Camera orthographic(const View3& view, double extent, int width, int height);

  /// A view of all of `bounds` from slightly above and to the side, with a margin. Empty or
  /// infinite bounds are replaced by a cube of 1 m around the origin.
  /// @param up   of the picture, whatever its length but 0
  /// @param fov  as of pinhole()
  static Camera framing(const Box3& bounds, int width, int height, const Vec3& up = Vec3::UnitZ(),
                        double fov = kUsualFov);

  static constexpr double kUsualFov = 40;  ///< [degrees]

  /// The camera of a rectangle of this camera's picture, whose pixel (0, 0) is (left, top) here:
  /// the same rays for the same pixels. The rectangle may extend outside the picture.
  Camera cropped(int left, int top, int width, int height) const;

  /// kInvalidArgument (the message lacks a subject) unless R is a rotation to 1e-3 (rounded digits
  /// are corrected, mirrored and scaled matrices refused), the focal lengths are positive, K's
  /// other entries are those of a pinhole, and the distortion is invertible along the whole border
  /// of the image.
  [[nodiscard]] static Result<Camera> calibrated(const Calibration& calibration);

  int width() const { return width_; }

  int height() const { return height_; }

  bool isOrthographic() const { return orthographic_; }

  const Vec3& eye() const { return eye_; }

  const Vec3& right() const {
    return right_;
  }  ///< unit length, as `down` and `forward`; right x down = forward

  const Vec3& down() const { return down_; }

  const Vec3& forward() const { return forward_; }

  /// The height of a pixel: at distance 1 along `forward` (pinhole, dimensionless) or in the world
  /// (orthographic) [m].
  double pixelSize() const { return pixelSize_; }

  /// The width of a pixel, as pixelSize(): differs only for calibrated cameras.
  double pixelWidth() const { return pixelWidth_; }

  /// The image point that `forward` meets, without the lens; the centre of the image except for
  /// calibrated cameras.
  const Vec2& principalPoint() const { return principal_; }

  /// Only for calibrated cameras; else none.
  const Distortion& distortion() const { return distortion_; }

  /// K for centres at +0.5, as Calibration has it. Pinhole cameras only.
  Mat3 intrinsics() const;

  /// The rotation whose rows are right, down and forward.
  Mat3 rotation() const;

  /// The ray through image point (px, py) in pixels; (x + 0.5, y + 0.5) for pixel centres. It
  /// begins at the eye (pinhole) or extends both ways (orthographic: begin = -infinity), has no
  /// near plane, and ends at infinity. Empty (begin = end = 0) for an image point that the lens
  /// does not reach.
  Segment ray(double px, double py) const;

  /// The same view, turned about an axis through a point, by the right-hand rule.
  /// @param axis  of any length > 0
  /// @param angle  [radians]
  Camera turned(const Vec3& point, const Vec3& axis, double angle) const;

  /// The same view with another number of pixels; the height determines the field of view.
  Camera resized(int width, int height) const;

  /// The same view with all image points moved: its ray(px, py) is this one's ray(px + x, py + y)
  /// [pixels].
  Camera shifted(double x, double y) const;

  /// Where a point of the world appears in the image [pixels], inside its borders or not: the
  /// inverse of ray(). Nothing for points that are not in front of a pinhole, or so far outside
  /// that the lens folds them back.
  std::optional<Vec2> project(const Vec3& point) const;

 private:
  Camera(const View3& view, int width, int height);
  Camera(const Calibration& calibration, const Mat3& rotation);

  bool orthographic_ = false;
  int width_ = 0, height_ = 0;
  Vec3 eye_, right_, down_, forward_;
  double pixelSize_ = 0, pixelWidth_ = 0;
  double skew_ = 0;  // in pixels to the right for one pixel down
  Vec2 principal_;
  Distortion distortion_;
};

}  // namespace volute
