// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// What became of a background by the time of a picture, for each channel: lamps that got darker, a
/// black level that moved.
struct BackgroundDrift {
  std::array<double, 3> gain{1, 1, 1};
  std::array<double, 3> offset{};  ///< linear radiance

  /// gain * background + offset.
  Image applied(const Image& background) const;
};

/// (height, width), 1 for the pixels of a camera whose line of sight misses the box, with two
/// pixels between them and those that meet it: what they show is background.
std::vector<std::uint8_t> pixelsBeside(const Camera& camera, const Box3& bounds);

/// Fits gain * background + offset to a picture, with Tukey's weights, so that a few pixels of
/// something else do not matter. The offset is held near 0 as far as the background does not vary.
/// @param picture, background  RGB of one size, linear.
/// @param pixels  (height, width), 1 for those to look at.
/// @return nothing for fewer than 100 pixels, where most of them do not follow the background, and
///   where the fit takes away less than a tenth of the mean difference: there the background is as
///   it was, or it changed in other ways than these.
std::optional<BackgroundDrift> findBackgroundDrift(const Image& picture, const Image& background,
                                                   std::span<const std::uint8_t> pixels);

/// What all pixels show evenly where there is nothing to see: a black level, or light that is all
/// around. Nothing where they are dark but for noise, or not even, and for fewer than 100 pixels.
/// @param picture  RGB, linear.
/// @param pixels  (height, width), 1 for those to look at.
std::optional<Rgb> findPedestal(const Image& picture, std::span<const std::uint8_t> pixels);

}  // namespace volute
