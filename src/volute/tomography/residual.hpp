// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/tomography/view.hpp"

namespace volute {

/// How far the projection of a volume is from what a camera saw.
struct ViewResidual {
  /// |projected - given| / |given| over the pixels that count and show light in either, so that the
  /// noise of a dark surround says nothing; 0 when nothing was seen.
  double relative = 0;
  /// -20 log10(rms / (max - min of given)) over all pixels that count [dB]; infinite when equal.
  double psnr = 0;
};

/// @param inColour  the volume as the view's camera sees it.
/// @param noiseSigma  as TomographyOptions has it: says which pixels show light.
ViewResidual residualOf(const TomographyView& view, const Image& inColour,
                        std::optional<double> noiseSigma);

}  // namespace volute
