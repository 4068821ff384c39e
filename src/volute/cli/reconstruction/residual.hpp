// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/tomography/view.hpp"

namespace volute::cli {

/// How far the projection of a volume is from what a camera saw, over the pixels that count.
struct ViewResidual {
  double relative = 0;  ///< |W (projected - given)| / |W given|; 0 when nothing was seen
  double psnr = 0;      ///< -20 log10(rms / (max - min of given)) [dB]; infinite when equal
};

ViewResidual residualOf(const TomographyView& view, const Image& projected);

}  // namespace volute::cli
