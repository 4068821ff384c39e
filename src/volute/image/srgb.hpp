// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/image/image.hpp"

namespace volute {

/// The sRGB transfer function (IEC 61966-2-1): linear 0..1 to display 0..1. Values outside are
/// clamped, NaN gives 0.
double srgbEncode(double linear);

/// Its inverse; values outside of 0..1 are clamped, NaN gives 0.
double srgbDecode(double display);

/// The picture as bytes for a display, shape (height, width, channels), rounded to nearest;
/// `exposure` is a factor.
std::vector<std::uint8_t> toSrgb8(const Image& image, double exposure = 1);

/// The byte of one value; NaN gives 0.
std::uint8_t toSrgb8(float linear);

/// The picture times `factor`.
Image exposed(Image image, double factor);

/// The factor that maps the `share` quantile of the non-zero pixel values to 1; 1 for a picture
/// without positive finite values. Used for the first picture of a volume of unknown
/// brightness.
double suggestExposure(const Image& image, double share = 0.99);

}  // namespace volute
