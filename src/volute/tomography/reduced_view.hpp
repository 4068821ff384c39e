// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/tomography/view.hpp"

namespace volute {

/// How wide a voxel at the volume's centre is in the picture, at least 1 [pixels].
double voxelInPixels(const Camera& camera, const VolumeGeometry& geometry);

/// The view with pixels that are the means of `factor` x `factor` of the given ones, of those that
/// count; its camera sees the same. Columns and rows beyond a multiple of `factor` are left out.
/// Saturated pixels do not count, and there are no bounds of them any more. The camera must not be
/// orthographic, `factor` no larger than the picture.
TomographyView reducedView(const TomographyView& view, int factor);

/// The resolution divided by `factor`, rounded up; the bounds stay.
VolumeGeometry coarserGeometry(VolumeGeometry geometry, int factor);

}  // namespace volute
