// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// How far a picture is from another, over all pixels and channels. A NaN in either makes all of
/// them NaN.
struct ImageDifference {
  double rms = 0;
  double relativeRms =
      0;            ///< rms / (max - min of the first picture); the rms itself when that is 0
  double psnr = 0;  ///< -20 log10 of relativeRms [dB]; infinite for equal pictures
  double maxError = 0;
};

/// Fails when the sizes or channels differ, or there is no pixel.
[[nodiscard]] Result<ImageDifference> compareImages(const Image& original, const Image& other);

/// The largest difference of the channels of each pixel, of pictures of one size.
Image largestDifferences(const Image& a, const Image& b);

}  // namespace volute
