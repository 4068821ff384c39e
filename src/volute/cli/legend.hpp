// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/image/colormap.hpp"
#include "volute/image/image.hpp"

namespace volute::cli {

/// The colours of a measured quantity, from `least` to `most`.
struct ColorScale {
  ColorMap map = ColorMap::kViridis;
  double most = 1;
  double least = 0;
};

/// Draws lines of text on a dark ground into the lower left corner of a picture that will be
/// encoded as sRGB, and above them a bar of the colours that values have.
void drawLegend(Image& image, const std::vector<std::string>& lines,
                const std::optional<ColorScale>& scale);

}  // namespace volute::cli
