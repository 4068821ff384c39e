// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/tomography/frame_views.hpp"

namespace volute {

/// What the pictures of one frame say about the capture. Each sentence names camera, frame and
/// number.
struct PictureFindings {
  std::vector<std::string> faults;    ///< no good comes of going on
  std::vector<std::string> warnings;  ///< measured, but for a person to decide
  bool dark = false;                  ///< no camera sees light on more than two pixels
};

struct PictureLimits {
  double saturated = 0.5;  ///< of a camera's lit pixels, more than this is a fault
};

/// Looks for pictures that are black while others are not, for saturation, for backgrounds that
/// moved (light cannot be negative), for hot pixels, for silhouettes that touch the border of their
/// picture and for light outside of the volume. Silent about clean pictures.
PictureFindings checkPictures(const FrameViews& views, const VolumeGeometry& geometry,
                              std::optional<double> noiseSigma, const PictureLimits& limits);

/// For a frame whose visual hull is empty: which camera alone is in the way of the others, and how
/// much of the volume they share without it.
std::string explainEmptyHull(const FrameViews& views, const VolumeGeometry& geometry,
                             std::optional<double> noiseSigma);

}  // namespace volute
