// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/ray_slopes.hpp"

#include <Eigen/Dense>

namespace volute {

RaySlopes::RaySlopes(const Camera& camera, const Segment& ray, const Vec3& turn, double scale) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 by = Vec3::Unit(axis) + 0.5 * turn.cross(Vec3::Unit(axis));
    direction.col(CameraCorrection::kTurn + axis) = by.cross(ray.direction);
  }
  const Mat3 rotation = camera.rotation();
  const Vec3 inCamera = rotation * ray.direction;
  const Vec2 point = inCamera.head<2>() / inCamera.z();
  const Distortion& lens = camera.distortion();
  Eigen::Matrix2d undistorted = Eigen::Matrix2d::Identity();
  if (!lens.none()) {
    constexpr double kLittle = 1e-5;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec2 aside = kLittle * Vec2::Unit(axis);
      undistorted.col(axis) =
          (distort(lens, point + aside) - distort(lens, point - aside)) / (2 * kLittle);
    }
    undistorted = undistorted.inverse().eval();
  }
  Eigen::Matrix<double, 2, kCount> moved = Eigen::Matrix<double, 2, kCount>::Zero();
  moved.col(CameraCorrection::kZoom) = -distort(lens, point);
  moved.middleCols<2>(CameraCorrection::kPrincipal) =
      -camera.intrinsics().topLeftCorner<2, 2>().inverse() / scale;
  moved.col(CameraCorrection::kLens) = -point.squaredNorm() * point;
  // The direction is of length 1.
  Mat3 across = rotation.transpose() * inCamera.z();
  across -= ray.direction * (inCamera.z() * inCamera).transpose();
  direction += across.leftCols<2>() * undistorted * moved;
}

}  // namespace volute
