// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// Corrections of a camera's calibration, and of the logarithms of its gain and its exponent.
struct CameraCorrection {
  static constexpr int kCount = 12;

  enum : int {
    kTurn = 0,
    kShift = 3,
    kZoom = 6,
    kPrincipal = 7,
    kGain = 9,
    kLens = 10,
    kExponent = 11
  };

  /// turn about the world's axes [rad] (3), shift of the eye [m] (3), logarithm of the factor on
  /// both focal lengths, principal point [pixels] (2), logarithm of the factor on the radiance, k1
  /// of the lens, logarithm of the exponent of the radiance. The gain is that of
  /// radiances at which the exponent changes nothing.
  Eigen::Matrix<double, kCount, 1> values = Eigen::Matrix<double, kCount, 1>::Zero();

  Vec3 turn() const { return values.segment<3>(kTurn); }

  Vec3 shift() const { return values.segment<3>(kShift); }

  double gain() const { return std::exp(values[kGain]); }

  double exponent() const { return std::exp(values[kExponent]); }
};

/// A focal length so many times as long.
CameraCorrection zoomBy(double factor);

/// A lens with so much more k1.
CameraCorrection lensBy(double k1);

/// The camera as corrected, of any size of the same picture: the principal point is in pixels of a
/// picture `scale` times as large as the camera's. kInvalidArgument for orthographic cameras, and
/// where the lens cannot be undone any more.
[[nodiscard]] Result<Camera> corrected(const Camera& camera, const CameraCorrection& correction,
                                       double scale = 1);

/// How much of each correction is plausible, one standard deviation: half a degree, 1 % of the
/// distance to `centre`, 2 % of the focal length, 1 % of the picture's width, 10 % of the gain and
/// of the exponent. The lens may move points at the left and right border by 3 % of their distance
/// from the middle, or by 0.5 % where the calibration states a distortion.
CameraCorrection plausibleCorrection(const Camera& camera, const Vec3& centre);

/// Takes out of the corrections what moves, turns or scales all cameras alike around `centre`, and
/// the mean of the gains: no picture tells it. To first order.
/// @param plausible  one a camera.
void removeCommonPart(std::span<const Camera> cameras, const Vec3& centre,
                      std::span<const CameraCorrection> plausible,
                      std::span<CameraCorrection> corrections);

/// Chooses what no picture tells, a shift, turn and scale of the whole world, so that the corrected
/// cameras see the points of `bounds` where the given ones see them: least absolute distances, so
/// that a camera that was wrong does not pull the others along; and the median of the gains is 1.
/// Focal lengths and lenses that were wrong are left out of account.
/// Returns the corrected cameras and changes the corrections to theirs.
[[nodiscard]] Result<std::vector<Camera>> keepInPlace(std::span<const Camera> given,
                                                      const Box3& bounds,
                                                      std::span<CameraCorrection> corrections);

}  // namespace volute
