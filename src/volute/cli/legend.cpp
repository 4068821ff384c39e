// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/legend.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "volute/image/bitmap_text.hpp"
#include "volute/image/srgb.hpp"

namespace volute::cli {
namespace {

constexpr int kRowsOfDots = 320;  // a dot for so many rows of the picture
constexpr double kShade = 0.08;   // of the ground behind the text, linear
constexpr double kInk = 0.9;

/// In dots.
constexpr int kMargin = 4, kLine = 10, kBarHeight = 6, kBarWidth = 120;

struct Place {
  int x = 0, y = 0, width = 0, height = 0;
};

void shade(Image& image, const Place& place) {
  for (int y = std::max(place.y, 0); y < std::min(place.y + place.height, image.height); ++y) {
    for (int x = std::max(place.x, 0); x < std::min(place.x + place.width, image.width); ++x) {
      for (int c = 0; c < image.channels; ++c)
        image.at(x, y, c) = static_cast<float>(kShade * std::clamp(image.at(x, y, c), 0.0F, 1.0F));
    }
  }
}

void drawBar(Image& image, const ColorScale& scale, const Place& place) {
  for (int x = 0; x < place.width; ++x) {
    // The map's colours are those of the screen.
    const Rgb color = displayColor(scale.map, (x + 0.5) / place.width).unaryExpr(&srgbDecode);
    for (int y = place.y; y < std::min(place.y + place.height, image.height); ++y) {
      for (int c = 0; c < image.channels && place.x + x < image.width; ++c) {
        if (y >= 0)
          image.at(place.x + x, y, c) = static_cast<float>(color[c]);
      }
    }
  }
}

}  // namespace

void drawLegend(Image& image, const std::vector<std::string>& lines,
                const std::optional<ColorScale>& scale) {
  const int dot = std::max(1, image.height / kRowsOfDots);
  int width = scale ? kBarWidth * dot : 0;
  for (const std::string& line : lines) width = std::max(width, textSize(line, dot).width);
  const int rows = static_cast<int>(lines.size()) * kLine + (scale ? kBarHeight + kLine + 2 : 0);
  const Place box{kMargin * dot, image.height - (rows + 3 * kMargin) * dot,
                  width + 2 * kMargin * dot, (rows + 2 * kMargin) * dot};
  shade(image, box);
  const Rgb ink = Rgb::Constant(kInk);
  const int x = box.x + kMargin * dot;
  int y = box.y + kMargin * dot;
  if (scale) {
    drawBar(image, *scale, {x, y, kBarWidth * dot, kBarHeight * dot});
    y += (kBarHeight + 2) * dot;
    const std::string most = fmt::format("{:.4g}", scale->most);
    drawText(image, fmt::format("{:.4g}", scale->least), x, y, dot, ink);
    drawText(image, most, x + kBarWidth * dot - textSize(most, dot).width, y, dot, ink);
    y += kLine * dot;
  }
  for (const std::string& line : lines) {
    drawText(image, line, x, y, dot, ink);
    y += kLine * dot;
  }
}

}  // namespace volute::cli
