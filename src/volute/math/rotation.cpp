// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/math/rotation.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "volute/math/eigen.hpp"

namespace volute {

Mat3 turnOfZ(const Vec3& up) {
  const Vec3 to = up.normalized();
  // 1 + z, without cancellation.
  const double more = to.z() < 0 ? to.head<2>().squaredNorm() / (1 - to.z()) : 1 + to.z();
  const double s = std::sqrt(2 * more);
  if (!(s > 0))
    return Vec3(1, -1, -1).asDiagonal();
  return Eigen::Quaterniond(0.5 * s, -to.y() / s, to.x() / s, 0).toRotationMatrix();
}

Mat3 turnAbout(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, asEigen(axis)).toRotationMatrix();
}

Mat3 turnOfQuaternion(const Vec4& quaternion) {
  return Eigen::Quaterniond(asEigen(quaternion)).normalized().toRotationMatrix();
}

Mat3 nearestRotation(const Mat3& matrix) {
  constexpr int kMaxSteps = 60;  // each halves what is too long, and squares the error near the end
  constexpr double kRounding = 4e-16;
  Mat3 turn = matrix / std::cbrt(matrix.determinant());
  for (int k = 0; k < kMaxSteps; ++k) {
    const Mat3 next = 0.5 * (turn + turn.inverse().transpose());
    const double change = (next - turn).cwiseAbs().maxCoeff();
    turn = next;
    if (!(change > kRounding))
      break;
  }
  return turn;
}

}  // namespace volute
