// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/camera/camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/assert.hpp"
#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// `up` unless it is (nearly) zero or along the view; then the world axis furthest from the view.
Vec3 usableUp(const Vec3& forward, const Vec3& up) {
  if (up.cross(forward).norm() > 1e-9 * up.norm())
    return up;
  Vec3 best = Vec3::UnitZ();
  for (const Vec3& axis : {Vec3(Vec3::UnitY()), Vec3(Vec3::UnitX())}) {
    if (std::abs(axis.dot(forward)) < std::abs(best.dot(forward)))
      best = axis;
  }
  return best;
}

/// The rotation that R means.
Result<Mat3> rotationOf(const Mat3& R) {
  constexpr double kRounding = 1e-3;
  if (!R.allFinite())
    return fail(ErrorCode::kInvalidArgument, "R is not finite");
  const double error = (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
  const double determinant = R.determinant();
  if (!(error <= kRounding)) {
    return fail(ErrorCode::kInvalidArgument,
                "R is no rotation: R R' is off the identity by {:.3g} (determinant {:.3g}); "
                "expected orthonormal rows",
                error, determinant);
  }
  if (determinant < 0) {
    return fail(ErrorCode::kInvalidArgument,
                "R is mirrored (determinant {:.3g}); expected a rotation with x right, y down, z "
                "forward: an axis has the wrong sign or two are swapped",
                determinant);
  }
  return nearestRotation(R);
}

Status checkIntrinsics(const Calibration& calibration) {
  const Mat3& K = calibration.K;
  if (calibration.width < 1 || calibration.height < 1) {
    return fail(ErrorCode::kInvalidArgument, "the image has {} x {} pixels", calibration.width,
                calibration.height);
  }
  if (!K.allFinite() || !calibration.t.allFinite())
    return fail(ErrorCode::kInvalidArgument, "K or t is not finite");
  if (!(K(0, 0) > 0 && K(1, 1) > 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "the focal lengths are {} and {} pixels; expected positive ones", K(0, 0), K(1, 1));
  }
  constexpr double kNarrowest = 1e4;  // widths; a field of view of 0.006 degrees
  if (K(0, 0) > kNarrowest * calibration.width || K(1, 1) > kNarrowest * calibration.height) {
    return fail(ErrorCode::kInvalidArgument,
                "the focal lengths are {} and {} pixels for pictures of {} x {}; expected at most "
                "{} times as much as these",
                K(0, 0), K(1, 1), calibration.width, calibration.height, kNarrowest);
  }
  if (K(1, 0) != 0 || K(2, 0) != 0 || K(2, 1) != 0 || K(2, 2) != 1) {
    return fail(ErrorCode::kInvalidArgument,
                "K has entries that a pinhole has not; expected [[fx, skew, cx], [0, fy, cy], [0, "
                "0, 1]]");
  }
  if (calibration.pixelCentre != 0 && calibration.pixelCentre != 0.5) {
    return fail(ErrorCode::kInvalidArgument, "the first pixel's centre is at {}; expected 0 or 0.5",
                calibration.pixelCentre);
  }
  return {};
}

/// Every image point between the middle and a border that can be undone can be undone too.
Status checkLens(const Camera& camera) {
  constexpr int kPlaces = 32;
  for (int i = 0; i < 4 * kPlaces; ++i) {
    const double along = static_cast<double>(i % kPlaces) / kPlaces;
    const Vec2 corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    const Vec2 place = (1 - along) * corners[i / kPlaces] + along * corners[i / kPlaces + 1];
    const double px = place.x() * camera.width(), py = place.y() * camera.height();
    if (!camera.ray(px, py).empty())
      continue;
    return fail(ErrorCode::kInvalidArgument,
                "the lens distortion cannot be undone at image point ({:.1f}, {:.1f}): its "
                "polynomial folds over before it; check the order [k1, k2, p1, p2, k3]",
                px, py);
  }
  return {};
}

}  // namespace

Camera::Camera(const View3& view, int width, int height)
    : width_(width), height_(height), eye_(view.eye), principal_(0.5 * width, 0.5 * height) {
  VOLUTE_ASSERT(width > 0 && height > 0);
  const Vec3 toTarget = view.target - view.eye;
  forward_ = toTarget.norm() > 0 ? Vec3(toTarget.normalized()) : Vec3(Vec3::UnitY());
  right_ = forward_.cross(usableUp(forward_, view.up)).normalized();
  down_ = forward_.cross(right_);
}

Camera::Camera(const Calibration& calibration, const Mat3& rotation)
    : width_(calibration.width),
      height_(calibration.height),
      eye_(-rotation.transpose() * calibration.t),
      right_(rotation.row(0)),
      down_(rotation.row(1)),
      forward_(rotation.row(2)),
      pixelSize_(1 / calibration.K(1, 1)),
      pixelWidth_(1 / calibration.K(0, 0)),
      skew_(calibration.K(0, 1) / calibration.K(1, 1)),
      principal_(calibration.K(0, 2), calibration.K(1, 2)),
      distortion_(calibration.distortion) {
  principal_ += Vec2::Constant(0.5 - calibration.pixelCentre);
}

Result<Camera> Camera::calibrated(const Calibration& calibration) {
  VOLUTE_TRY(checkIntrinsics(calibration));
  VOLUTE_ASSIGN(const Mat3 rotation, rotationOf(calibration.R));
  const Camera camera(calibration, rotation);
  VOLUTE_TRY(checkLens(camera));
  return camera;
}

Camera Camera::pinhole(const View3& view, double fov, int width, int height) {
  VOLUTE_ASSERT(fov > 0 && fov < 180);
  Camera camera(view, width, height);
  camera.pixelSize_ = 2 * std::tan(0.5 * fov * std::numbers::pi / 180) / height;
  camera.pixelWidth_ = camera.pixelSize_;
  return camera;
}

Camera Camera::orthographic(const View3& view, double extent, int width, int height) {
  VOLUTE_ASSERT(extent > 0);
  Camera camera(view, width, height);
  camera.orthographic_ = true;
  camera.pixelSize_ = extent / height;
  camera.pixelWidth_ = camera.pixelSize_;
  return camera;
}

Camera Camera::framing(const Box3& bounds, int width, int height, const Vec3& up, double fov) {
  constexpr double kMargin = 1.06;
  const bool usable = !bounds.empty() && bounds.min.allFinite() && bounds.max.allFinite();
  const Box3 box = usable ? bounds : Box3{Vec3::Constant(-0.5), Vec3::Constant(0.5)};
  View3 view;
  view.target = box.centre();
  view.eye = view.target + turnOfZ(up) * Vec3(0.35, -1, 0.3);
  view.up = up;
  Camera camera = pinhole(view, fov, width, height);
  // The nearest distance at which every corner lies inside the image.
  const double halfHeight = 0.5 * height * camera.pixelSize_ / kMargin;
  const double halfWidth = 0.5 * width * camera.pixelSize_ / kMargin;
  double distance = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3 sign(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    const Vec3 corner = box.size().cwiseProduct(sign);
    const double needed = std::max(std::abs(corner.dot(camera.right_)) / halfWidth,
                                   std::abs(corner.dot(camera.down_)) / halfHeight);
    distance = std::max(distance, needed - corner.dot(camera.forward_));
  }
  camera.eye_ = box.centre() - distance * camera.forward_;
  return camera;
}

Mat3 Camera::intrinsics() const {
  VOLUTE_ASSERT(!orthographic_);
  Mat3 K = Mat3::Identity();
  K(0, 0) = 1 / pixelWidth_;
  K(1, 1) = 1 / pixelSize_;
  K(0, 1) = skew_ / pixelSize_;
  K(0, 2) = principal_.x(), K(1, 2) = principal_.y();
  return K;
}

Mat3 Camera::rotation() const {
  return Mat3::ofRows(right_, down_, forward_);
}

Camera Camera::cropped(int left, int top, int width, int height) const {
  VOLUTE_ASSERT(width > 0 && height > 0);
  Camera camera = *this;
  camera.width_ = width, camera.height_ = height;
  camera.principal_ -= Vec2(left, top);
  return camera;
}

Segment Camera::ray(double px, double py) const {
  const double v = py - principal_.y();
  Vec2 place((px - principal_.x() - skew_ * v) * pixelWidth_, v * pixelSize_);
  if (!distortion_.none()) {
    const auto undistorted = undistort(distortion_, place);
    if (!undistorted)
      return {eye_, forward_, 0, 0};
    place = *undistorted;
  }
  const Vec3 offset = place.x() * right_ + place.y() * down_;
  if (orthographic_)
    return {eye_ + offset, forward_, -kInfinity, kInfinity};
  return {eye_, (forward_ + offset).normalized(), 0, kInfinity};
}

Camera Camera::turned(const Vec3& point, const Vec3& axis, double angle) const {
  const Mat3 turn = turnAbout(axis.normalized(), angle);
  Camera other = *this;
  other.eye_ = point + turn * (eye_ - point);
  other.right_ = turn * right_, other.down_ = turn * down_, other.forward_ = turn * forward_;
  return other;
}

Camera Camera::resized(int width, int height) const {
  Camera other = *this;
  const double factor = height / static_cast<double>(height_);
  other.width_ = width, other.height_ = height;
  other.pixelSize_ /= factor, other.pixelWidth_ /= factor;
  other.principal_ = factor * principal_;
  other.principal_.x() += 0.5 * (width - factor * width_);
  return other;
}

Camera Camera::shifted(double x, double y) const {
  Camera other = *this;
  other.principal_ -= Vec2(x, y);
  return other;
}

std::optional<Vec2> Camera::project(const Vec3& point) const {
  const Vec3 offset = point - eye_;
  const double depth = orthographic_ ? 1 : offset.dot(forward_);
  if (!(depth > 0))
    return std::nullopt;
  Vec2 place(offset.dot(right_) / depth, offset.dot(down_) / depth);
  if (!beforeFold(distortion_, place))
    return std::nullopt;
  place = distort(distortion_, place);
  const double v = place.y() / pixelSize_;
  return principal_ + Vec2(place.x() / pixelWidth_ + skew_ * v, v);
}

}  // namespace volute
