// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "volute/math/rotation.hpp"

namespace volute {
namespace {

constexpr double kSteepest = 0.49 * std::numbers::pi;  ///< that a hand turns it to
constexpr double kTurn = 0.006;                        ///< radians a pixel

/// Width and height between the insets, or some of them where these leave little.
std::array<double, 2> freeOf(int width, int height, const ViewCamera::Insets& insets) {
  constexpr double kMinFree = 0.2;
  return {std::max(width - insets.left - insets.right, kMinFree * width),
          std::max(height - insets.top - insets.bottom, kMinFree * height)};
}

}  // namespace

Vec3 ViewCamera::forward() const {
  return frame_ * Vec3(-std::sin(yaw_) * std::cos(pitch_), std::cos(yaw_) * std::cos(pitch_),
                       std::sin(pitch_));
}

Mat3 ViewCamera::turned() const {
  return Mat3::ofColumns(right(), forward(), right().cross(forward()));
}

void ViewCamera::setPivot(const Vec3& point) {
  pivot_ = point;
  const double depth = (point - eye_).dot(forward());
  if (depth > 0)
    distance_ = std::max(depth, 1e-6);
}

void ViewCamera::lookAlong(const Vec3& direction) {
  const double away = (pivot_ - eye_).norm();
  const Vec3 own = frame_.transpose() * direction.normalized();
  pitch_ = std::asin(std::clamp(own.z(), -1.0, 1.0));
  if (own.head<2>().norm() > 1e-9)
    yaw_ = std::atan2(-own.x(), own.y());
  else
    yaw_ = 0;
  eye_ = pivot_ - away * forward();
  distance_ = std::max(away, 1e-6);
}

Vec3 ViewCamera::right() const {
  return frame_ * Vec3(std::cos(yaw_), std::sin(yaw_), 0);
}

/// What a view along its up means is Camera's to say.
void ViewCamera::set(const StartView& view) {
  const Camera meant = Camera::pinhole({view.eye, view.target, view.up}, Camera::kUsualFov, 1, 1);
  eye_ = view.eye;
  distance_ = std::max((view.target - view.eye).norm(), 1e-6);
  pivot_ = view.target;
  frame_ = turnOfZ(view.up.norm() > 0 ? view.up : Vec3(-meant.down()));
  const Vec3 right = frame_.transpose() * meant.right();
  yaw_ = std::atan2(right.y(), right.x());
  pitch_ = std::asin(std::clamp(meant.forward().dot(frame_.col(2)), -1.0, 1.0));
  fov_ = view.fov;
  ortho_ = std::max(view.ortho, 0.0);
}

void ViewCamera::frame(const Box3& bounds, int width, int height, const Insets& insets) {
  Box3 upright = bounds;
  if (frame_ != Mat3::Identity() && (bounds.min.array() <= bounds.max.array()).all()) {
    upright = Box3();
    for (int i = 0; i < 8; ++i) upright.extend(frame_.transpose() * bounds.corner(i));
  }
  const auto free = freeOf(width, height, insets);
  const Camera framing =
      Camera::framing(upright, static_cast<int>(free[0]), static_cast<int>(free[1]));
  // The same angle now goes over all of the height.
  const double distance = height / free[1] * (upright.centre() - framing.eye()).norm();
  const double ortho =
      (ortho_ > 0) ? 2 * distance * std::tan(0.5 * Camera::kUsualFov * std::numbers::pi / 180) : 0;
  const Vec3 eye = upright.centre() - distance * framing.forward();
  set({frame_ * eye, frame_ * upright.centre(), frame_.col(2), Camera::kUsualFov, ortho});
  const Vec3 middle = pivot_;
  pan(0.5 * (insets.left - insets.right), 0.5 * (insets.top - insets.bottom), height);
  pivot_ = middle;
}

void ViewCamera::fit(const Box3& bounds, int width, int height, const Insets& insets) {
  if (ortho_ > 0 || (bounds.min.array() > bounds.max.array()).any())
    return;
  const auto [freeWidth, freeHeight] = freeOf(width, height, insets);
  const double focus = 0.5 * height / std::tan(0.5 * fov_ * std::numbers::pi / 180);  // [pixels]
  const Mat3 frame = turned();
  const Vec3 centre = bounds.centre();
  // Of a pinhole that looks at the centre from so far: what the corners cover [pixels].
  const auto covers = [&](double distance) {
    Vec2 from = Vec2::Constant(1e300), to = -from;
    for (int i = 0; i < 8; ++i) {
      const Vec3 own = frame.transpose() * (bounds.corner(i) - centre);
      const double depth = std::max(own.y() + distance, 1e-3 * distance);
      const Vec2 on(focus * own.x() / depth, -focus * own.z() / depth);
      from = from.cwiseMin(on), to = to.cwiseMax(on);
    }
    return std::pair(from, to);
  };
  const double size = bounds.size().norm();
  double near = 0.5 * size, far = 100 * size;
  constexpr int kHalvings = 40;
  constexpr double kFilled = 0.94;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(near * far);
    const auto [from, to] = covers(middle);
    const Vec2 covered = to - from;
    const bool fits = covered.x() <= kFilled * freeWidth && covered.y() <= kFilled * freeHeight;
    (fits ? far : near) = middle;
  }
  const auto [from, to] = covers(far);
  const Vec2 middle = 0.5 * (from + to);
  eye_ = centre - far * forward();
  distance_ = far;
  pivot_ = centre;
  pan(0.5 * (insets.left - insets.right) - middle.x(),
      0.5 * (insets.top - insets.bottom) - middle.y(), height);
  pivot_ = centre;
}

void ViewCamera::setFov(double degrees) {
  fov_ = std::clamp(degrees, 5.0, 150.0);
}

void ViewCamera::setOrtho(double height) {
  ortho_ = std::clamp(height, 1e-4, 1e6);
}

void ViewCamera::toggleParallel() {
  const double slope = 2 * std::tan(0.5 * fov_ * std::numbers::pi / 180);
  const double depth = (pivot_ - eye_).dot(forward());
  if (!(ortho_ > 0))
    return setOrtho(slope * (depth > 0 ? depth : distance_));
  const double wanted = ortho_ / slope;
  ortho_ = 0;
  eye_ += (depth - wanted) * forward();
  distance_ = wanted;
}

void ViewCamera::drag(double rightPixels, double downPixels) {
  const Mat3 before = turned();
  yaw_ -= kTurn * rightPixels;
  const double steepest = std::max(kSteepest, std::abs(pitch_));  // it may have begun so
  pitch_ = std::clamp(pitch_ - kTurn * downPixels, -steepest, steepest);
  if (mode_ == Mode::kOrbit)
    eye_ = pivot_ + turned() * before.transpose() * (eye_ - pivot_);
  else
    pivot_ = target();
}

void ViewCamera::turn(double angle) {
  const Mat3 before = turned();
  yaw_ += angle;
  eye_ = pivot_ + turned() * before.transpose() * (eye_ - pivot_);
}

void ViewCamera::pan(double rightPixels, double downPixels, int height) {
  const double seen =
      (ortho_ > 0) ? ortho_ : 2 * std::tan(0.5 * fov_ * std::numbers::pi / 180) * distance_;
  const double perPixel = seen / std::max(height, 1);
  const Vec3 up = right().cross(forward());
  const Vec3 moved = perPixel * (downPixels * up - rightPixels * right());
  eye_ += moved;
  pivot_ += moved;
}

void ViewCamera::zoom(double clicks, const Vec3& towards) {
  const double nearer = std::pow(0.88, clicks);
  if (ortho_ > 0) {
    const double before = ortho_;
    setOrtho(ortho_ * nearer);
    const Vec3 offset = towards - eye_;
    eye_ += (1 - ortho_ / before) * (offset - offset.dot(forward()) * forward());
    return;
  }
  if (mode_ == Mode::kWalk) {
    walkBy(0.1 * clicks * distance_ * forward());
    return;
  }
  const double wanted = std::clamp(distance_ * nearer, 1e-4, 1e6);
  eye_ = towards + wanted / distance_ * (eye_ - towards);
  distance_ = wanted;
}

void ViewCamera::walkBy(const Vec3& step) {
  eye_ += step;
  pivot_ += step;
}

void ViewCamera::walk(double ahead, double aside, double up) {
  const Vec3 level = frame_ * Vec3(-std::sin(yaw_), std::cos(yaw_), 0);
  walkBy(ahead * level + aside * right() + up * frame_.col(2));
}

Camera ViewCamera::camera(int width, int height) const {
  const View3 view{eye_, target(), right().cross(forward())};
  return ortho_ > 0 ? Camera::orthographic(view, ortho_, width, height)
                    : Camera::pinhole(view, fov_, width, height);
}

}  // namespace volute
