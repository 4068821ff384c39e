// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace volute {
namespace {

constexpr double kSteepest = 0.49 * std::numbers::pi;  ///< that a hand turns it to
constexpr double kTurn = 0.006;                        ///< radians a pixel
constexpr double kFramed = 40;                         ///< [degrees] in which all is seen

/// A turn that takes z to `up`.
Mat3 uprightAlong(const Vec3& up) {
  const double length = up.norm();
  if (!(length > 0) || up.z() == length)
    return Mat3::Identity();
  return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up / length).toRotationMatrix();
}

}  // namespace

Vec3 ViewCamera::forward() const {
  return frame_ * Vec3(-std::sin(yaw_) * std::cos(pitch_), std::cos(yaw_) * std::cos(pitch_),
                       std::sin(pitch_));
}

Vec3 ViewCamera::right() const {
  return frame_ * Vec3(std::cos(yaw_), std::sin(yaw_), 0);
}

/// What a view along its up means is Camera's to say.
void ViewCamera::set(const StartView& view) {
  const Camera meant = Camera::pinhole({view.eye, view.target, view.up}, kFramed, 1, 1);
  eye_ = view.eye;
  distance_ = std::max((view.target - view.eye).norm(), 1e-6);
  frame_ = uprightAlong(view.up.norm() > 0 ? view.up : Vec3(-meant.down()));
  const Vec3 right = frame_.transpose() * meant.right();
  yaw_ = std::atan2(right.y(), right.x());
  pitch_ = std::asin(std::clamp(meant.forward().dot(upwards()), -1.0, 1.0));
  fov_ = view.fov;
  ortho_ = std::max(view.ortho, 0.0);
}

void ViewCamera::frame(const Box3& bounds, int width, int height) {
  Box3 upright = bounds;
  if (frame_ != Mat3::Identity() && (bounds.min.array() <= bounds.max.array()).all()) {
    upright = Box3();
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner(i & 1 ? bounds.max.x() : bounds.min.x(),
                        i & 2 ? bounds.max.y() : bounds.min.y(),
                        i & 4 ? bounds.max.z() : bounds.min.z());
      upright.extend(frame_.transpose() * corner);
    }
  }
  const Camera framing = Camera::framing(upright, width, height);
  const double distance = (upright.centre() - framing.eye()).norm();
  const double ortho =
      parallel() ? 2 * distance * std::tan(0.5 * kFramed * std::numbers::pi / 180) : 0;
  set({frame_ * framing.eye(), frame_ * upright.centre(), upwards(), kFramed, ortho});
}

void ViewCamera::setFov(double degrees) {
  fov_ = std::clamp(degrees, 5.0, 150.0);
}

void ViewCamera::setOrtho(double height) {
  ortho_ = std::clamp(height, 1e-4, 1e6);
}

void ViewCamera::drag(double rightPixels, double downPixels) {
  const Vec3 held = target();
  yaw_ -= kTurn * rightPixels;
  const double steepest = std::max(kSteepest, std::abs(pitch_));  // it may have begun so
  pitch_ = std::clamp(pitch_ - kTurn * downPixels, -steepest, steepest);
  if (mode_ == Mode::kOrbit)
    eye_ = held - distance_ * forward();
}

void ViewCamera::pan(double rightPixels, double downPixels, int height) {
  const double seen =
      parallel() ? ortho_ : 2 * std::tan(0.5 * fov_ * std::numbers::pi / 180) * distance_;
  const double perPixel = seen / std::max(height, 1);
  const Vec3 up = right().cross(forward());
  eye_ += perPixel * (downPixels * up - rightPixels * right());
}

void ViewCamera::zoom(double clicks) {
  if (parallel())
    setOrtho(ortho_ * std::pow(0.88, clicks));
  if (mode_ == Mode::kWalk) {
    eye_ += 0.1 * clicks * distance_ * forward();
    return;
  }
  const Vec3 held = target();
  distance_ = std::clamp(distance_ * std::pow(0.88, clicks), 1e-4, 1e6);
  eye_ = held - distance_ * forward();
}

void ViewCamera::walk(double ahead, double aside, double up) {
  const Vec3 level = frame_ * Vec3(-std::sin(yaw_), std::cos(yaw_), 0);
  eye_ += ahead * level + aside * right() + up * upwards();
}

Camera ViewCamera::camera(int width, int height) const {
  const View3 view{eye_, target(), right().cross(forward())};
  return parallel() ? Camera::orthographic(view, ortho_, width, height)
                    : Camera::pinhole(view, fov_, width, height);
}

}  // namespace volute
