// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// The consistency of one camera with the other views.
struct CameraDiagnosis {
  double residual = 0;       ///< relative L2 of S a - (p - b), without what noise explains
  double explained = 0;      ///< of the residual, what the size of the voxels does, ViewMatch::fine
  double residualRatio = 1;  ///< of its misfit, ViewMatch, to the median of the other cameras,
                             ///< after worse ones were left out
  double gain = 1;  ///< the factor on its measured radiance that fits best, next to the median of
                    ///< the others; from a fit without this camera where it stands out
  bool outOfStep = false;  ///< it stands out: another instant, moved, or miscalibrated
  bool gainDrift = false;  ///< it stands out, and with another gain it fits as others do
  std::string warning;     ///< for people, to follow the camera's name; empty: none
};

struct TomographyDiagnosis {
  std::vector<CameraDiagnosis> cameras;
  std::vector<std::string> warnings;  ///< sentences for people on all cameras together
};

/// Looks for what goes wrong in captures: a camera out of step or with a drifted gain, cameras that
/// all disagree, a hull that fills the domain. Says nothing about consistent data.
///
/// The camera that stands out most is named first, and the others are judged by a fit without it.
/// All together misfit when the median of their misfits, ViewMatch, is above what voxels of this
/// size and noise explain, and a fit without a prior changes nothing about it.
/// @param options  those of the reconstruction.
[[nodiscard]] Result<TomographyDiagnosis> diagnose(std::span<const TomographyView> views,
                                                   const VolumeGeometry& geometry,
                                                   const TomographyOptions& options,
                                                   const Reconstruction& reconstruction,
                                                   Progress& progress);

/// Degrees between the lines of sight of two cameras through `centre`, modulo 180: 0..90.
double angleBetween(const Camera& a, const Camera& b, const Vec3& centre);

/// The angle between the lines of sight of a pair of cameras.
struct SightAngle {
  std::size_t a = 0, b = 0;  ///< indices of the cameras, a < b
  double degrees = 0;        ///< modulo 180: 0..90
};

/// Of all pairs, (0, 1), (0, 2), .., (1, 2), ..
std::vector<SightAngle> sightAngles(std::span<const Camera> cameras, const Vec3& centre);

/// Names the pairs of cameras that look along nearly the same line, from the same or from opposite
/// sides, or tells that all do so, and says what to do about it; nothing for other layouts.
std::optional<Remark> layoutAdvice(std::span<const std::string> names,
                                   std::span<const SightAngle> angles);

}  // namespace volute
