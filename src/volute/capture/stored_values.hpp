// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>

#include "volute/image/image.hpp"

// What the values of a file tell of the camera that took it.

namespace volute {

/// Many pixels that read one largest value, which is less than a file can hold.
struct StoredPlateau {
  double value = 0;       ///< of 1 = the largest that a file can hold
  double share = 0;       ///< of the lit pixels, those that read it in any channel
  bool saturated = true;  ///< false: an evenly lit background looks the same, and is likelier
};

/// Where a sensor or a converter stops counting, though the file could hold more: at least a
/// hundredth of the lit pixels and a dozen read the largest value, eight times as many as other
/// values above its half do on average. Nothing for a largest value of 1, and for pictures of few
/// values.
/// @param image  values as stored, whole numbers / `largest`.
std::optional<StoredPlateau> plateauOf(const Image& image, double largest = 65535);

/// Where each channel stops counting, where that is not the same for all: pictures whose white
/// balance was set after the sensor's limit. A channel counts that has a plateau as plateauOf() has
/// one, also at 1, in pixels half of which or more are in another channel's. Of 1 = the largest
/// that a file can hold; nothing: no two channels have different limits.
/// @param limit  of a channel for which none is found
std::optional<std::array<double, 3>> channelLimits(const Image& image, double limit);

/// The largest of floats that all are whole numbers, as integers are that were only converted; 0
/// where they are few, or end above 16 bits.
double countsOf(const Image& floats);

/// Whether floats are whole 255ths or 65535ths, as integers are that were only divided.
bool areDividedIntegers(const Image& floats);

/// The bits that make a value the largest: 12 for 4095 / 65535; nothing for other values.
/// @param value  whole number / `largest`
std::optional<int> bitsOf(double value, double largest = 65535);

/// The fewest bits that hold all values of a picture whose file could hold 16 or more; 0 for a
/// black one, and for one of less.
/// @param image  values as stored, whole numbers / `largest`.
int bitsHolding(const Image& image, double largest = 65535);

/// Whether the brightness of a grey picture goes by the place in blocks of 2 x 2 pixels: the mosaic
/// of a colour camera that was not made into colours.
bool isMosaic(const Image& image);

}  // namespace volute
