// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/tomography/view.hpp"

namespace volute {

/// The line integrals of a volume through a camera (Ahrenberg et al. 2005, equation 3), linear RGB
/// [value * m]; exact for the basis up to float rounding.
/// @param volume  (z, y, x, 3). Box: constant in each voxel. Trilinear: interpolated between voxel
///   centres, zero one voxel beyond the outer ones.
/// @param raysPerPixel  1: through the pixel's centre; 4: mean of 2 x 2 at its quarter points.
Image projectVolume(std::span<const float> volume, const VolumeGeometry& geometry, Basis basis,
                    const Camera& camera, int raysPerPixel);

/// The same as a view's camera measures it: the mean of the channels in all three for one that is
/// grey.
Image asSeenBy(const TomographyView& view, Image inColour);

}  // namespace volute
