// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string_view>

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// Letters of 5 x 8 dots in cells of 6 x 9, printable ASCII; anything else is drawn as '?'. Each
/// dot is a square of `scale` pixels.
struct TextSize {
  int width = 0, height = 0;  ///< [pixels], without the gap after the last letter
};

TextSize textSize(std::string_view text, int scale);

/// Draws one line with its top left corner at (x, y); what lies outside of the picture is left out.
/// `color` is in the picture's own values; a picture of one channel takes its first.
void drawText(Image& image, std::string_view text, int x, int y, int scale, const Rgb& color);

}  // namespace volute
