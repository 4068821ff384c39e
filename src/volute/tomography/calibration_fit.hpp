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
  std::vector<double> before;  ///< for each view, relative L2 of the projected volume as given
  std::vector<double> after;   ///< and as corrected
};

/// Refines poses, focal lengths, principal points and gains together with the volume: Gauss-Newton
/// steps of both, by conjugate gradients on the linearised problem (variable projection), coarse to
/// fine, with Tukey's weights of pixels, and corrections held by what is plausible. What is common
/// to all cameras stays as it is.
/// @param frames  the same cameras at one to three times; pinholes.
/// @param fine  goes on to the voxels of `geometry` where coarser ones explain more with the
///   corrections, and memory suffices; what is left before and after is that of voxels twice as
///   wide all the same.
/// @param maxMemory  [bytes] besides the pictures; rays are walked anew where it is little.
/// Errors: kInvalidArgument, kNotFound for frames without light, kTooLarge, kCancelled.
[[nodiscard]] Result<CalibrationFit> refineCalibration(
    std::span<const std::vector<TomographyView>> frames, const VolumeGeometry& geometry, bool fine,
    std::uint64_t maxMemory, Progress& progress);

}  // namespace volute
