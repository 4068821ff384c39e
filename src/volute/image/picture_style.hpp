// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "volute/image/image.hpp"
#include "volute/image/view_transform.hpp"
#include "volute/math/vec.hpp"

// How light becomes a picture on a display, the same steps for stills, films and the viewer:
//   exposure -> glow -> tone curve -> quantisation to 8 bits with dithering.

namespace volute {

/// How light brighter than a display can be fits into it.
enum class ToneCurve {
  kNone,  ///< it is clipped: for measurements
  /// The fit of ACES' reference and output transform by Stephen Hill: contrast and colour of film;
  /// bright light loses its colour.
  kFilmic,
  /// AgX as Troy Sobotka defined it, with Benjamin Wrensch's polynomial for its sigmoid: less
  /// contrast, and hues that stay what they are.
  kAgx,
  /// As it is up to 0.7 in the brightest channel, of what is white or grey up to 1, and what is
  /// brighter is brought below 1 with its hue: for pictures of measured light in which something
  /// burns before a white ground.
  kShoulder,
};

/// "none", "filmic", "agx", "shoulder".
std::string_view nameOf(ToneCurve tone);

struct PictureStyle {
  double exposure = 1;  ///< a factor of all light
  ToneCurve tone = ToneCurve::kNone;
  double glow = 0;      ///< share of the light that spreads around where it comes from, 0..1
  bool dither = false;  ///< to 8 bits; else whoever writes the picture rounds
  /// What a display is to show, instead of the tone curve; its code values are decoded as sRGB's,
  /// so that a .png has them as they are.
  const ViewTransform* view = nullptr;
};

/// What a display is to show of `light`: linear sRGB, each channel 0..1 but for kNone, which
/// changes nothing. NaN and what is negative count as 0.
Rgb toneMapped(ToneCurve tone, const Rgb& light);

/// The picture with `share` of each pixel's light spread around it by three normalised Gaussians,
/// with deviations of 1/200, 1/50 and 1/12 of the picture's height and a third of `share` each.
/// Light that would leave the picture is reflected at its border, so that their sum stays.
Image withGlow(const Image& image, double share);

/// Each value becomes one of the 256 that a display shows, up or down by its distance to both, so
/// that smooth gradients have no steps and the mean of the light stays. Values that a display shows
/// as they are stay. The pattern (R2 of Martin Roberts) is the same in all frames. What comes out
/// is linear light that toSrgb8() turns into exactly these values.
void dither(Image& image);

/// All steps: RGB, or one channel, which is light without colour.
Image developed(Image light, const PictureStyle& style);

/// 1 for each pixel of a picture, as a display shows it, at which there is an edge: a channel that
/// is more than 12 of 255 levels off the line through its neighbours on both sides.
std::vector<std::uint8_t> edgePixels(const Image& shown);

/// The exposure at which the light below which `share` of all light of `pictures` lies is shown as
/// 1 where it is clipped, and bright under a tone curve, or half of what is lit not brighter than
/// in the middle, if that is darker; 1 where there is no light. `pictures`: of one sequence, which
/// has one exposure.
double suggestExposure(const std::vector<Image>& pictures, ToneCurve tone, double share = 0.99);

}  // namespace volute
