// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/image/color_scale.hpp"
#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// How a legend fits into a picture: in pixels.
struct LegendLayout {
  int dot = 1;                       ///< the side of a letter's dots
  int x = 0, y = 0;                  ///< of the ground's top left corner
  int width = 0, height = 0;         ///< of the ground; 0: there is no room for a legend
  int barWidth = 0;                  ///< 0: there is none
  std::vector<std::string> lines{};  ///< as they are drawn
};

/// Lines of text in the lower left corner of a picture, below a bar of colours if there is a
/// `scale`. Letters shrink where a large picture's would not fit, to a dot a pixel; then lines are
/// broken between words, within words too long for the picture; then the last ones are left out.
LegendLayout layOutLegend(int width, int height, const std::vector<std::string>& lines,
                          const std::optional<ColorScale>& scale);

/// Draws the legend on a dark ground into a picture that will be encoded as sRGB.
void drawLegend(Image& image, const std::vector<std::string>& lines,
                const std::optional<ColorScale>& scale);

/// Draws letters around a pixel, dark with a light edge, into a picture that will be encoded as
/// sRGB. Nothing where they would be cut off.
void drawMark(Image& image, const std::string& text, const Vec2& at);

}  // namespace volute
