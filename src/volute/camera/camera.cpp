// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/camera/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/assert.hpp"

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

}  // namespace

Camera::Camera(const View3& view, int width, int height)
    : width_(width), height_(height), eye_(view.eye) {
  VOLUTE_ASSERT(width > 0 && height > 0);
  const Vec3 toTarget = view.target - view.eye;
  forward_ = toTarget.norm() > 0 ? Vec3(toTarget.normalized()) : Vec3(Vec3::UnitY());
  right_ = forward_.cross(usableUp(forward_, view.up)).normalized();
  down_ = forward_.cross(right_);
}

Camera Camera::pinhole(const View3& view, double fov, int width, int height) {
  VOLUTE_ASSERT(fov > 0 && fov < 180);
  Camera camera(view, width, height);
  camera.pixelSize_ = 2 * std::tan(0.5 * fov * std::numbers::pi / 180) / height;
  return camera;
}

Camera Camera::orthographic(const View3& view, double extent, int width, int height) {
  VOLUTE_ASSERT(extent > 0);
  Camera camera(view, width, height);
  camera.orthographic_ = true;
  camera.pixelSize_ = extent / height;
  return camera;
}

Camera Camera::framing(const Box3& bounds, int width, int height) {
  constexpr double kFov = 40;
  constexpr double kMargin = 1.06;
  const bool usable = !bounds.empty() && bounds.min.allFinite() && bounds.max.allFinite();
  const Box3 box = usable ? bounds : Box3{Vec3::Constant(-0.5), Vec3::Constant(0.5)};
  View3 view;
  view.target = box.centre();
  view.eye = view.target + Vec3(0.35, -1, 0.3);
  Camera camera = pinhole(view, kFov, width, height);
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

Segment Camera::ray(double px, double py) const {
  const Vec3 offset =
      (px - 0.5 * width_) * pixelSize_ * right_ + (py - 0.5 * height_) * pixelSize_ * down_;
  if (orthographic_)
    return {eye_ + offset, forward_, -kInfinity, kInfinity};
  return {eye_, (forward_ + offset).normalized(), 0, kInfinity};
}

}  // namespace volute
