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
  double residual = 0;       ///< relative L2 of S a - (p - b)
  double residualRatio = 1;  ///< to the median of the other cameras
  double gain = 1;           ///< the factor on its measured radiance that fits the others best
  bool outOfStep = false;  ///< its residual stands out: another instant, or moved, or miscalibrated
  bool gainDrift = false;  ///< its gain stands out
  double borderShare = 0;  ///< of the silhouette's pixels, those on the image border
};

struct TomographyDiagnosis {
  std::vector<CameraDiagnosis> cameras;
  std::vector<double> angles;         ///< [degrees] between viewing directions modulo 180, 0..90:
                                      ///< pairs (0,1), (0,2), .., (1,2), ..
  std::vector<std::string> warnings;  ///< sentences for people; none for consistent data
};

/// Looks for what goes wrong in captures: a camera out of step or with a drifted gain, light
/// outside the volume, a hull that fills the domain, cameras opposite to each other.
[[nodiscard]] Result<TomographyDiagnosis> diagnose(std::span<const TomographyView> views,
                                                   const VolumeGeometry& geometry,
                                                   const TomographyOptions& options,
                                                   const Reconstruction& reconstruction,
                                                   Progress& progress);

/// Degrees between the lines of sight of two cameras through `centre`, modulo 180: 0..90.
double angleBetween(const Camera& a, const Camera& b, const Vec3& centre);

}  // namespace volute
