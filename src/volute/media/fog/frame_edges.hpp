// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/image/image.hpp"

// The pixels of a frame at the borders of its surfaces, which show several of them at once, each at
// a distance of its own: fog between them turns soft edges into stairs unless they are told apart.

namespace volute {

/// A share of each pixel of a picture that is at one distance.
struct FrameSample {
  Image color{};                ///< linear RGB
  std::vector<float> depth{};   ///< [m] along the pixels' rays, infinite for the sky
  std::vector<float> weight{};  ///< 0..1; those of all samples of a pixel add up to 1
};

/// How finely a frame's file stores colours.
enum class FrameSteps { kHalf, kSrgb8, kSrgb16 };

/// From one distance a pixel, as renderers write it. Where distances jump, a pixel's colour is
/// taken apart into that of the near and that of the far surface beside it, if it lies between
/// them; else the pixel stays whole. The less the colours of both differ, compared with their noise
/// and steps, the more the shares are those of the pixel's distance. Without fog the samples add up
/// to the picture.
/// @param depth  of the colour's size [m]
std::vector<FrameSample> samplesOf(const Image& color, std::vector<float> depth, FrameSteps steps);

/// From several distances a pixel: each sample gets the colour of the surface beside the pixel that
/// is at its distance.
/// @param depths  a picture of distances for each sample [m]
std::vector<FrameSample> samplesOf(const Image& color, std::vector<std::vector<float>> depths);

}  // namespace volute
