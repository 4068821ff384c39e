// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>

#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// What becomes of the misfit when all principal points move alike, to the right and down: of the
/// faults of a calibration that all cameras share, the one that a convention explains.
struct CommonShift {
  double pixels = 0;    ///< where one volume fits all pictures best; +-0.5: centres at 0 or 0.5
  double residual = 0;  ///< relative L2 over all views where the principal points are
  double nearest = 0;   ///< the same, moved by half a pixel to the side that fits better
};

/// Fits with all principal points half a pixel to the left and up, where they are, and half a pixel
/// to the right and down, each from the reconstruction and without a prior; the best place is that
/// of a parabola through the squared residuals. The fits share all that voxels leave unexplained,
/// so that the place is told where their size hides the misfit itself.
/// @param options  those of the reconstruction.
/// @return nothing where the fits do not tell places apart, and for orthographic cameras.
[[nodiscard]] Result<std::optional<CommonShift>> findCommonShift(
    std::span<const TomographyView> views, const VolumeGeometry& geometry,
    const TomographyOptions& options, const Reconstruction& reconstruction, Progress& progress);

}  // namespace volute
