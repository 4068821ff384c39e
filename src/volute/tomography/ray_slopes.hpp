// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>

#include "volute/camera/camera.hpp"
#include "volute/tomography/camera_correction.hpp"

namespace volute {

/// How a pixel's ray changes with each of its camera's corrections.
struct RaySlopes {
  static constexpr int kCount = CameraCorrection::kCount;

  Eigen::Matrix<double, 3, kCount> direction = Eigen::Matrix<double, 3, kCount>::Zero();

  /// @param turn  that the camera was corrected by
  /// @param scale  principal points are in pixels of a picture so many times as large
  RaySlopes(const Camera& camera, const Segment& ray, const Vec3& turn, double scale);
};

}  // namespace volute
