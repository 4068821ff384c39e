// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tomography/least_squares.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// One frame as linear algebra.
struct FrameProblem {
  std::shared_ptr<const Support> support;
  std::unique_ptr<const Projector> projector;
  LeastSquares data;
  double hullShare = 1;
  double variance = 0;  ///< what pixelVariance() says of a pixel with a weight of 1
};

/// Validates the views, the geometry and the options; see reconstruct().
[[nodiscard]] Status checkReconstruction(std::span<const TomographyView> views,
                                         const VolumeGeometry& geometry,
                                         const TomographyOptions& options);

/// Silhouettes, hull, rays and weights of a frame. The weights are normalised to a mean of 1.
[[nodiscard]] Result<FrameProblem> makeFrameProblem(std::span<const TomographyView> views,
                                                    const VolumeGeometry& geometry,
                                                    const TomographyOptions& options,
                                                    Progress& progress);

/// The relative L2 of S a - (p - b) over the pixels of each view, without weights.
std::vector<double> residualOfViews(const FrameProblem& problem, std::size_t views,
                                    std::span<const float> projected);

/// (z, y, x, 3) from four floats for each unknown, and back.
std::vector<float> toVolume(const Support& support, std::span<const float> unknowns);
std::vector<float> toUnknowns(const Support& support, std::span<const float> volume);

}  // namespace volute
