// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string_view>

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

// Words in pictures, so that a legend travels with its picture.

namespace volute {

/// Letters of 5 x 7 dots on a raster of 6 x 9, `scale` pixels a dot.
struct TextStyle {
  int scale = 2;
  Rgb color = Rgb::Zero();  ///< linear
};

/// [pixels]
int textWidth(std::string_view text, int scale);
int textHeight(int scale);  ///< of a line, descenders included

/// Draws one line, its top left corner at x, y; what lies outside of the picture is cut off. ASCII;
/// other bytes show as '?', one for each character of UTF-8.
void drawText(Image& image, int x, int y, std::string_view text, const TextStyle& style);

/// The same upwards, for the label of a vertical axis: x, y is the corner at the text's top left,
/// when the head is turned.
void drawTextUpwards(Image& image, int x, int y, std::string_view text, const TextStyle& style);

/// Fills x0 <= x < x1, y0 <= y < y1, cut to the picture.
void fillRect(Image& image, int x0, int y0, int x1, int y1, const Rgb& color);

/// A straight line, `width` pixels wide.
void drawLine(Image& image, double x0, double y0, double x1, double y1, double width,
              const Rgb& color);

}  // namespace volute
