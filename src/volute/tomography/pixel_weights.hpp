// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <vector>

#include "volute/tomography/view.hpp"

namespace volute {

/// How far the sight of a pixel may be off [pixels]: calibration, and the few places in a pixel
/// that a renderer or the four rays sample.
inline constexpr double kSightError = 0.05;

/// What of a pixel's radiance is uncertain, squared, (height, width): the noise, and the radiance's
/// gradient times kSightError. A floor of 3 % of its mean keeps dark pixels from ruling alone.
/// Of optical depths the noise grows as the light that is left falls.
std::vector<float> pixelVariance(const TomographyView& view, std::optional<double> noiseSigma);

}  // namespace volute
