// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/legend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "volute/image/srgb.hpp"
#include "volute/image/text.hpp"

namespace volute {
namespace {

constexpr int kRowsOfDots = 320;   // a dot for so many rows of the picture
constexpr double kMaxHigh = 0.22;  // of the picture's height, unless letters are smallest
constexpr double kShade = 0.08;    // of the ground behind the text, linear
constexpr double kInk = 0.9;

/// In dots.
constexpr int kMargin = 4, kLegendLine = 10, kLetter = 6, kBarHeight = 6, kBarWidth = 120;
constexpr int kBar = kBarHeight + 2 + kLegendLine;  // with its numbers

struct Area {
  int x = 0, y = 0, width = 0, height = 0;
};

void shade(Image& image, const Area& place) {
  for (int y = std::max(place.y, 0); y < std::min(place.y + place.height, image.height); ++y) {
    for (int x = std::max(place.x, 0); x < std::min(place.x + place.width, image.width); ++x) {
      for (int c = 0; c < image.channels; ++c)
        image.at(x, y, c) = static_cast<float>(kShade * std::clamp(image.at(x, y, c), 0.0F, 1.0F));
    }
  }
}

void drawBar(Image& image, const ColorScale& scale, const Area& place) {
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

std::string maximumText(const ColorScale& scale) {
  return fmt::format("{:.4g}{}{}", scale.most, scale.unit.empty() ? "" : " ", scale.unit);
}

std::string minimumText(const ColorScale& scale) {
  return fmt::format("{:.4g}", scale.least);
}

/// The ends of a scale, with a letter's gap between them, in letters.
int scaleLetters(const ColorScale& scale) {
  return static_cast<int>(minimumText(scale).size() + 1 + maximumText(scale).size());
}

/// A line in pieces of so many letters at most, broken between words where it can be.
void wrap(std::string_view line, std::size_t letters, std::vector<std::string>& out) {
  while (line.size() > letters) {
    const std::size_t space = line.rfind(' ', letters);
    const bool between = space != std::string_view::npos && space > 0;
    out.emplace_back(line.substr(0, between ? space : letters));
    line.remove_prefix(between ? space + 1 : letters);
  }
  out.emplace_back(line);
}

/// What one size of letters has room for.
struct Room {
  int letters, dots;  ///< across, in letters; down, in dots

  Room(int width, int height, int dot)
      : letters((width / dot - 4 * kMargin + 1) / kLetter), dots(height / dot - 4 * kMargin) {}
};

}  // namespace

LegendLayout layOutLegend(int width, int height, const std::vector<std::string>& lines,
                          const std::optional<ColorScale>& scale) {
  int longest = scale ? std::max(kBarWidth / kLetter, scaleLetters(*scale)) : 0;
  for (const std::string& line : lines) longest = std::max(longest, static_cast<int>(line.size()));
  const int rows = static_cast<int>(lines.size()) * kLegendLine + (scale ? kBar : 0);
  LegendLayout layout;
  layout.dot = std::max(1, height / kRowsOfDots);
  while (layout.dot > 1 && (Room(width, height, layout.dot).letters < longest ||
                            Room(width, height, layout.dot).dots < rows ||
                            (rows + 2 * kMargin) * layout.dot > kMaxHigh * height))
    --layout.dot;
  const Room room(width, height, layout.dot);
  const bool bar = scale && room.dots >= kBar && room.letters >= scaleLetters(*scale);
  const int left = room.dots - (bar ? kBar : 0);
  if (room.letters > 0) {
    for (const std::string& line : lines)
      wrap(line, static_cast<std::size_t>(room.letters), layout.lines);
  }
  layout.lines.resize(std::min(layout.lines.size(), static_cast<std::size_t>(std::max(left, 0)) /
                                                        static_cast<std::size_t>(kLegendLine)));
  if (!bar && layout.lines.empty())
    return layout;
  if (bar)
    layout.barWidth = std::min(std::max(kBarWidth, kLetter * scaleLetters(*scale)),
                               width / layout.dot - 4 * kMargin) *
                      layout.dot;
  int widest = layout.barWidth;
  for (const std::string& line : layout.lines)
    widest = std::max(widest, textSize(line, TextStyle::ofDots(layout.dot)).width);
  const int down = static_cast<int>(layout.lines.size()) * kLegendLine + (bar ? kBar : 0);
  layout.width = widest + 2 * kMargin * layout.dot;
  layout.height = (down + 2 * kMargin) * layout.dot;
  layout.x = kMargin * layout.dot;
  layout.y = height - (down + 3 * kMargin) * layout.dot;
  return layout;
}

void drawLegend(Image& image, const std::vector<std::string>& lines,
                const std::optional<ColorScale>& scale) {
  const LegendLayout layout = layOutLegend(image.width, image.height, lines, scale);
  const int dot = layout.dot;
  shade(image, {layout.x, layout.y, layout.width, layout.height});
  const Rgb ink = Rgb::Constant(kInk);
  const TextStyle style = TextStyle::ofDots(dot);
  const int x = layout.x + kMargin * dot;
  int y = layout.y + kMargin * dot;
  if (layout.barWidth > 0) {
    drawBar(image, *scale, {x, y, layout.barWidth, kBarHeight * dot});
    y += (kBarHeight + 2) * dot;
    const std::string maximum = maximumText(*scale);
    drawText(image, minimumText(*scale), x, y, style, ink);
    drawText(image, maximum, x + layout.barWidth - textSize(maximum, style).width, y, style, ink);
    y += kLegendLine * dot;
  }
  for (const std::string& line : layout.lines) {
    drawText(image, line, x, y, style, ink);
    y += kLegendLine * dot;
  }
}

void drawMark(Image& image, const std::string& text, const Vec2& at) {
  const int dot = std::max(1, image.height / kRowsOfDots);
  const TextStyle style = TextStyle::ofDots(dot);
  const TextSize size = textSize(text, style);
  const int x = static_cast<int>(std::lround(at.x() - 0.5 * size.width));
  const int y = static_cast<int>(std::lround(at.y() - 0.5 * size.height));
  if (x < dot || y < dot || x + size.width + dot > image.width ||
      y + size.height + dot > image.height)
    return;
  for (int dy = -dot; dy <= dot; dy += dot) {
    for (int dx = -dot; dx <= dot; dx += dot)
      drawText(image, text, x + dx, y + dy, style, Rgb::Ones());
  }
  drawText(image, text, x, y, style, Rgb::Zero());
}

}  // namespace volute
