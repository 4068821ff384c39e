// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/ray_slopes.hpp"

#include <Eigen/Dense>

#include "volute/math/eigen.hpp"

namespace volute {

RaySlopes::RaySlopes(const Camera& camera, const Segment& ray, const Vec3& turn, double scale) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 by = Vec3::Unit(axis) + 0.5 * turn.cross(Vec3::Unit(axis));
    direction.col(CameraCorrection::kTurn + axis) = asEigen(by.cross(ray.direction));
  }
  const Mat3 rotation = camera.rotation();
  const Vec3 inCamera = rotation * ray.direction;
  const Vec2 point = inCamera.head<2>() / inCamera.z();
  const Distortion& lens = camera.distortion();
  Mat2 undistorted = Mat2::Identity();
  if (!lens.none()) {
    constexpr double kLittle = 1e-5;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec2 aside = kLittle * Vec2::Unit(axis);
      undistorted.col(axis) =
          (distort(lens, point + aside) - distort(lens, point - aside)) / (2 * kLittle);
    }
    undistorted = undistorted.inverse();
  }
  Eigen::Matrix<double, 2, kCount> moved = Eigen::Matrix<double, 2, kCount>::Zero();
  moved.col(CameraCorrection::kZoom) = asEigen(-distort(lens, point));
  moved.middleCols<2>(CameraCorrection::kPrincipal) =
      -asEigen(camera.intrinsics()).topLeftCorner<2, 2>().inverse() / scale;
  moved.col(CameraCorrection::kLens) = asEigen(-point.squaredNorm() * point);
  // The direction is of length 1.
  Mat3 across = rotation.transpose() * inCamera.z();
  across -= outerProduct(ray.direction, inCamera.z() * inCamera);
  direction += asEigen(across).leftCols<2>() * asEigen(undistorted) * moved;
}

}  // namespace volute
