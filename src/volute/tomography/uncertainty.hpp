// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// How sure a reconstruction is of each voxel.
struct VoxelUncertainty {
  std::vector<float> sigma;  ///< (z, y, x, 3), standard deviations; 0 outside the visual hull
  double expectedError =
      0;                  ///< |sigma| / |volume|: the relative L2 that the volume is expected off
  double priorShare = 0;  ///< of the energy |a|^2 that is expected, what the pictures leave open
  double channelCorrelation =
      0;  ///< of the errors of two channels, 0..1, as left-out views have it
  std::array<double, 3> scale{1, 1,
                              1};    ///< of samples, from fine to coarse; see estimateUncertainty()
  std::vector<std::string> heldOut;  ///< the views that told it; empty: of so few none could
};

/// Standard deviations of the voxels of a reconstruction, from what its pictures leave open.
///
/// Samples of what a volume may be besides the one found: the noise of the pixels, sights of each
/// camera that are off by its sightError, and differences of neighbours that are drawn as large as
/// those of the volume are thereabouts go through one linear least-squares problem (randomise, then
/// optimise; Bardsley et al. 2014), by conjugate gradients. What the pictures determine comes out
/// as small as their noise, what they leave open as large as the volume varies. How large that is
/// is then measured: a view, of five or fewer two, is predicted by a volume without it, and in
/// three bands of size the samples are scaled by how much its picture differs more than samples of
/// that volume do. Values below 0 are clamped. The variance is .85 of that and .35 of what the
/// noise alone does, times a factor between .16 and 2.25 by how much of the samples' pictures is in
/// the large; of two views it is that of the samples.
/// @param solved  by reconstruct() with the same views, geometry and options.
/// Errors: those of reconstruct().
[[nodiscard]] Result<VoxelUncertainty> estimateUncertainty(std::span<const TomographyView> views,
                                                           const VolumeGeometry& geometry,
                                                           const TomographyOptions& options,
                                                           const Reconstruction& solved,
                                                           Progress& progress);

}  // namespace volute
