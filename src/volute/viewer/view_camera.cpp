// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace volute {
namespace {

constexpr double kSteepest = 0.49 * std::numbers::pi;
constexpr double kTurn = 0.006;  ///< radians a pixel

}  // namespace

Vec3 ViewCamera::forward() const {
  return {-std::sin(yaw_) * std::cos(pitch_), std::cos(yaw_) * std::cos(pitch_), std::sin(pitch_)};
}

Vec3 ViewCamera::right() const {
  return {std::cos(yaw_), std::sin(yaw_), 0};
}

void ViewCamera::set(const StartView& view) {
  const Vec3 to = view.target - view.eye;
  eye_ = view.eye;
  distance_ = std::max(to.norm(), 1e-6);
  yaw_ = to.head<2>().norm() > 0 ? std::atan2(-to.x(), to.y()) : 0;
  pitch_ = std::clamp(std::asin(std::clamp(to.z() / distance_, -1.0, 1.0)), -kSteepest, kSteepest);
  fov_ = view.fov;
}

void ViewCamera::frame(const Box3& bounds, int width, int height) {
  const Camera framing = Camera::framing(bounds, width, height);
  set({framing.eye(), bounds.centre(), Vec3::UnitZ(), 40});
}

void ViewCamera::setFov(double degrees) {
  fov_ = std::clamp(degrees, 5.0, 150.0);
}

void ViewCamera::drag(double rightPixels, double downPixels) {
  const Vec3 held = target();
  yaw_ -= kTurn * rightPixels;
  pitch_ = std::clamp(pitch_ - kTurn * downPixels, -kSteepest, kSteepest);
  if (mode_ == Mode::kOrbit)
    eye_ = held - distance_ * forward();
}

void ViewCamera::pan(double rightPixels, double downPixels, int height) {
  const double perPixel =
      2 * std::tan(0.5 * fov_ * std::numbers::pi / 180) * distance_ / std::max(height, 1);
  const Vec3 up = right().cross(forward());
  eye_ += perPixel * (downPixels * up - rightPixels * right());
}

void ViewCamera::zoom(double clicks) {
  if (mode_ == Mode::kWalk) {
    eye_ += 0.1 * clicks * distance_ * forward();
    return;
  }
  const Vec3 held = target();
  distance_ = std::clamp(distance_ * std::pow(0.88, clicks), 1e-4, 1e6);
  eye_ = held - distance_ * forward();
}

void ViewCamera::walk(double ahead, double aside, double up) {
  const Vec3 level = Vec3(-std::sin(yaw_), std::cos(yaw_), 0);
  eye_ += ahead * level + aside * right() + up * Vec3::UnitZ();
}

Camera ViewCamera::camera(int width, int height) const {
  return Camera::pinhole({eye_, target(), Vec3::UnitZ()}, fov_, width, height);
}

}  // namespace volute
