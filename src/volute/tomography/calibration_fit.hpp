// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// The calibration that goes best with the pictures.
struct CalibrationFit {
  std::vector<CameraCorrection> corrections;  ///< one a view
  std::vector<CameraCorrection> uncertain;    ///< one a view: standard deviations, the common part
                                              ///< left out
  std::vector<Camera> cameras;                ///< as corrected
  std::vector<double> sightError;  ///< one a view: how uncertain the places are at which it sees
                                   ///< points of the volume, root mean square [pixels]
  std::vector<double> before;      ///< for each view, relative L2 of the projected volume as given
  std::vector<double> after;       ///< and as corrected
  double pivot = 0;  ///< radiance at which exponents change nothing, see CameraCorrection
  bool lensOrResponse = false;  ///< whether any lens or exponent was corrected
};

/// Parameters of cameras that are refined.
struct CalibrationFitOptions {
  /// Goes on to the voxels of the volume where coarser ones explain more with the corrections, and
  /// memory suffices (kTooLarge with more than four frames, for fewer may do); what is left before
  /// and after is that of voxels twice as wide all the same.
  bool fine = false;
  bool lens = false;  ///< radial distortion, too
  /// One a view, not 0: its exponent of the radiance, too. The view needs its background, where
  /// that was subtracted. Empty: none.
  std::vector<char> exponent{};
  std::uint64_t maxMemory = std::uint64_t{1} << 30;  ///< [bytes] besides the pictures; rays are
                                                     ///< walked anew where it is little
};

/// Refines poses, focal lengths, principal points and gains together with the volume: Gauss-Newton
/// steps of both, by conjugate gradients on the linearised problem (variable projection), coarse to
/// fine, with Tukey's weights of pixels, and corrections held by what is plausible. What is common
/// to all cameras stays as it is.
///
/// Lenses and exponents follow once the rest is refined. They are kept where the pictures are then
/// explained clearly better, and of those cameras alone whose correction is well above its
/// uncertainty. Of k1 and of exponents the median over the cameras is taken out: another volume
/// explains what they share.
/// @param frames  the same cameras at one or more times; pinholes. Four take hardly more time than
///   one, and memory and time grow with each four.
/// Errors: kInvalidArgument, kNotFound for frames without light, kTooLarge, kCancelled.
[[nodiscard]] Result<CalibrationFit> refineCalibration(
    std::span<const std::vector<TomographyView>> frames, const VolumeGeometry& geometry,
    const CalibrationFitOptions& options, Progress& progress);

}  // namespace volute
