// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/image/image.hpp"

namespace volute {

/// The weights of a box `width` >= 1 pixels wide, centred at a pixel: an odd number, their sum 1.
std::vector<float> boxWeights(double width);

/// The mean over a square box around each pixel; pixels at the border are counted again beyond it.
/// @param width  of the box [pixels], 1 or more, whole or not.
Image boxBlurred(const Image& image, double width);

}  // namespace volute
