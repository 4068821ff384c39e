// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/tomography/view.hpp"

namespace volute {

/// How a view and a picture of the volume go together, over the pixels that count. All numbers are
/// relative L2, without the share of the noise.
struct ViewMatch {
  double residual = 0;
  double gain = 1;        ///< the factor on what was measured that fits best
  double misfit = 0;      ///< the residual of what is two voxels wide and more, where rays meet the
                          ///< volume
  double unresolved = 0;  ///< what a box of 1.5 voxels takes from that part of the picture: about
                          ///< the misfit that the size of the voxels explains
  double fine = 0;  ///< what the same box takes from the whole picture: about the residual that
                    ///< the size of the voxels explains
};

/// @param inColour  the volume as the view's camera sees it, radiance without a background.
ViewMatch matchOf(const TomographyView& view, const Image& inColour, const VolumeGeometry& geometry,
                  std::optional<double> noiseSigma);

}  // namespace volute
