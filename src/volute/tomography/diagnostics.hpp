// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// What the consistency of the views says about one camera.
struct CameraDiagnosis {
  double residual = 0;       ///< relative L2 of S a - (p - b), without what noise explains
  double residualRatio = 1;  ///< to the median of the other cameras
  double gain = 1;  ///< the factor on its measured radiance that fits best, next to the median of
                    ///< the others; from a fit without this camera where it stands out
  bool outOfStep = false;   ///< its residual stands out: another instant, moved, or miscalibrated
  bool gainDrift = false;   ///< its residual stands out, and its gain explains much of it
  double borderLight = 0;   ///< share of the image's border that shows the medium
  double lightOutside = 0;  ///< share of its silhouettes' light on rays that miss the volume
};

struct TomographyDiagnosis {
  std::vector<CameraDiagnosis> cameras;
  std::vector<double> angles;         ///< [degrees] between viewing directions modulo 180, 0..90:
                                      ///< pairs (0,1), (0,2), .., (1,2), ..
  std::vector<std::string> warnings;  ///< sentences for people; none for consistent data
  std::vector<std::string> advice;    ///< on the layout of the cameras
};

/// Looks for what goes wrong in captures: a camera out of step or with a drifted gain, light
/// outside the volume, a hull that fills the domain, cameras opposite to each other.
/// @param options  those of the reconstruction.
[[nodiscard]] Result<TomographyDiagnosis> diagnose(std::span<const TomographyView> views,
                                                   const VolumeGeometry& geometry,
                                                   const TomographyOptions& options,
                                                   const Reconstruction& reconstruction,
                                                   Progress& progress);

/// Degrees between the lines of sight of two cameras through `centre`, modulo 180: 0..90.
double angleBetween(const Camera& a, const Camera& b, const Vec3& centre);

/// Whether a number of cameras around a volume, and what their angles are, could be better.
std::vector<std::string> layoutAdvice(std::span<const TomographyView> views, const Vec3& centre);

}  // namespace volute
