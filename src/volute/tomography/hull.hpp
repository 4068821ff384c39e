// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "volute/tomography/support.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// What is taken as noise in one view: a robust estimate from the differences of neighbouring
/// pixels, as radiance; next to 0 for floats without noise, and a quarter of a step or more of
/// integers. Where dark pixels are 0 and never less, the lower half of their noise is cut off.
double noiseOf(const TomographyView& view);

/// The radiance above which a pixel shows the medium, by default: 3.5 times the noise, and at least
/// 1/500 of the view's brightest channel.
double silhouetteThreshold(const TomographyView& view, std::optional<double> noiseSigma);

/// (height, width), 1 where the medium may be seen: the view's own silhouette or |p - b| over the
/// threshold in any channel, dilated by one pixel and by twice the error of the view's sights; 1
/// where the weight is 0, for nothing is known there. Where the noise decides, means of 5 x 5
/// pixels are compared with a fifth of the threshold; of noise that is cut off with a fourth, or
/// 3.5 times what a tenth of the dark means is below, for films smooth noise.
std::vector<std::uint8_t> dilatedSilhouette(const TomographyView& view,
                                            std::optional<double> noiseSigma);

/// (z, y, x), 1 for each voxel that every camera that sees it may have in its silhouette. A voxel
/// counts with its whole footprint: the basis function's when trilinear.
std::vector<std::uint8_t> visualHull(std::span<const TomographyView> views,
                                     std::span<const std::vector<std::uint8_t>> silhouettes,
                                     const VolumeGeometry& geometry);

}  // namespace volute
