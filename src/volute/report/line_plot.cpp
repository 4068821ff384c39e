// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/line_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/base/plain_number.hpp"
#include "volute/image/colormap.hpp"
#include "volute/report/page.hpp"

namespace volute {
namespace {

constexpr double kWidth = 720, kHeight = 280;
constexpr double kLeft = 64, kRight = 150, kTop = 30, kBottom = 44;

/// 1, 2 or 5 times a power of ten: at most about five steps up to `range`.
double niceStep(double range) {
  const double rough = range / 5;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough)
      return factor * power;
  }
  return 10 * power;
}

struct Axes {
  double x0, x1, y1;

  double px(double x) const {
    return kLeft + (x1 > x0 ? (x - x0) / (x1 - x0) : 0.5) * (kWidth - kLeft - kRight);
  }

  double py(double y) const { return kHeight - kBottom - y / y1 * (kHeight - kTop - kBottom); }
};

std::string colourOf(std::size_t i, std::size_t count) {
  // The yellow end is too pale on white.
  const double place =
      count > 1 ? 0.9 * static_cast<double>(i) / static_cast<double>(count - 1) : 0;
  const Rgb colour = displayColor(ColorMap::kViridis, place);
  return fmt::format("rgb({:.0f},{:.0f},{:.0f})", 255 * colour[0], 255 * colour[1],
                     255 * colour[2]);
}

/// 1500, not 1.5e+03.
std::string tickOf(double value) {
  return value != 0 && (value >= 1e6 || value < 1e-4) ? fmt::format("{:.3g}", value)
                                                      : fmt::format("{:.6g}", value);
}

std::string gridLines(const Axes& axes) {
  std::string svg;
  const double yStep = niceStep(axes.y1);
  for (double y = 0; y <= axes.y1 * 1.0001; y += yStep) {
    svg += fmt::format(
        "<line x1='{}' x2='{}' y1='{:.1f}' y2='{:.1f}' stroke='#ddd'/><text x='{}' y='{:.1f}' "
        "text-anchor='end'>{}</text>\n",
        kLeft, kWidth - kRight, axes.py(y), axes.py(y), kLeft - 6, axes.py(y) + 4, tickOf(y));
  }
  const double xStep = std::max(1.0, niceStep(std::max(1.0, axes.x1 - axes.x0)));
  for (double x = std::ceil(axes.x0 / xStep) * xStep; x <= axes.x1; x += xStep) {
    svg += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle'>{}</text>\n", axes.px(x),
                       kHeight - kBottom + 16, plainNumber(x, 4));
  }
  return svg;
}

std::string drawn(const PlotLine& line, const std::vector<double>& x, const Axes& axes,
                  const std::string& colour, double legendY) {
  std::string path, dots;
  bool pen = false;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(line.y[i])) {
      pen = false;
      continue;
    }
    const double px = axes.px(x[i]), py = axes.py(line.y[i]);
    path += fmt::format("{}{:.1f},{:.1f} ", pen ? "L" : "M", px, py);
    if (x.size() <= 60)
      dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.2' fill='{}'/>", px, py, colour);
    pen = true;
  }
  const char* dash = line.dashed ? " stroke-dasharray='5 3'" : "";
  return fmt::format(
      "<path d='{}' fill='none' stroke='{}' stroke-width='1.6'{}/>{}\n<line x1='{}' x2='{}' "
      "y1='{:.0f}' y2='{:.0f}' stroke='{}' stroke-width='2'{}/><text x='{}' y='{:.0f}'>{}</text>\n",
      path, colour, dash, dots, kWidth - kRight + 10, kWidth - kRight + 32, legendY - 4,
      legendY - 4, colour, dash, kWidth - kRight + 38, legendY, escapedHtml(line.name));
}

}  // namespace

std::string linePlot(const std::string& title, const std::string& xLabel, const std::string& yLabel,
                     const std::vector<double>& x, const std::vector<PlotLine>& lines) {
  double most = 0;
  for (const PlotLine& line : lines) {
    for (const double y : line.y) most = std::isfinite(y) ? std::max(most, y) : most;
  }
  const Axes axes{x.front(), x.back(), most > 0 ? 1.08 * most : 1};
  const double height = std::max(kHeight, kTop + 18.0 * static_cast<double>(lines.size()) + 10);
  std::string svg = fmt::format(
      "<svg viewBox='0 0 {} {}' width='{}' height='{}' font-family='sans-serif' font-size='12'>\n"
      "<text x='{}' y='16' font-weight='bold'>{}</text>\n",
      kWidth, height, kWidth, height, kLeft, escapedHtml(title));
  svg += gridLines(axes);
  svg += fmt::format(
      "<text x='{}' y='{}' text-anchor='middle'>{}</text>\n<text transform='translate(14 {}) "
      "rotate(-90)' text-anchor='middle'>{}</text>\n",
      0.5 * (kLeft + kWidth - kRight), kHeight - 8, escapedHtml(xLabel), 0.5 * kHeight,
      escapedHtml(yLabel));
  for (std::size_t i = 0; i < lines.size(); ++i)
    svg += drawn(lines[i], x, axes, colourOf(i, lines.size()),
                 kTop + 12 + 18.0 * static_cast<double>(i));
  return svg + "</svg>\n";
}

}  // namespace volute
