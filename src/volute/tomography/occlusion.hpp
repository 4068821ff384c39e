// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// Dark pixels of one view where all others tell that there is light.
struct Occlusion {
  std::size_t view = 0;
  std::vector<std::uint8_t> pixels;  ///< (height, width), 1: something dark is in the way
  double share = 0;                  ///< of the pixels that should show light
};

/// Finds what stands between a camera and the medium, and would carve a hole into the visual hull.
/// Where one view alone calls voxels empty that all others see amid their light, the view is
/// predicted by a fit to the others, on voxels of 1/24 of the volume. Pixels that show nothing, and
/// of which half of a usual brightness is predicted, are found. Nothing is found of views that do
/// not fit elsewhere (relative L2 above 0.3) or lack nine tenths of their light, of fewer than four
/// views, of orthographic cameras, and of optical depths.
///
/// Errors: those of reconstruct().
[[nodiscard]] Result<std::vector<Occlusion>> findOcclusions(std::span<const TomographyView> views,
                                                            const VolumeGeometry& geometry,
                                                            Progress& progress);

/// Takes the weight of the found pixels: nothing is known there.
void leaveOut(const Occlusion& occlusion, TomographyView& view);

}  // namespace volute
