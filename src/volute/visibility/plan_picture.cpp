// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_picture.hpp"

#include <algorithm>
#include <cmath>

#include "volute/image/bitmap_text.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/drawing.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr int kText = 2;  // pixels a dot
constexpr int kLeft = 92, kTop = 62, kBottom = 66, kBar = 150, kPlain = 24, kRow = 26;

/// A colour as displays show it, as linear light.
Rgb linear(const Rgb& display) {
  return Rgb(srgbDecode(display[0]), srgbDecode(display[1]), srgbDecode(display[2]));
}

Rgb grey(double display) {
  return linear(Rgb::Constant(display));
}

const Rgb kSignColor(0.72, 0.03, 0.03);
const Rgb kRouteColor(0.03, 0.16, 0.62);

Rgb colorOf(PlanMark mark) {
  switch (mark) {
    case PlanMark::kSolid:
      return grey(0.33);
    case PlanMark::kHidden:
      return grey(0.78);
    case PlanMark::kLost:
      return grey(0.58);
    case PlanMark::kKept:
      return linear(Rgb(1.0, 0.98, 0.86));
    default:
      return grey(0.96);
  }
}

double niceStep(double range, int most) {
  const double rough = range / most;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1 - 1e-9))
      return factor * power;
  }
  return 10 * power;
}

std::string tickText(double value) {
  return fmt::format("{:g}", std::abs(value) < 1e-9 ? 0.0 : std::round(value * 1e6) / 1e6);
}

/// From metres to pixels.
struct Frame {
  const FloorPlan& plan;
  int scale;

  int width() const { return plan.nx * scale; }

  int height() const { return plan.ny * scale; }

  double x(double metres) const {
    return kLeft + ((metres - plan.origin[0]) / plan.step + 0.5) * scale;
  }

  double y(double metres) const {
    return kTop + height() - ((metres - plan.origin[1]) / plan.step + 0.5) * scale;
  }

  double from(int axis) const { return plan.origin[axis] - 0.5 * plan.step; }

  double size(int axis) const { return plan.step * (axis == 0 ? plan.nx : plan.ny); }
};

void drawCells(Image& image, const Frame& frame, const PlanPicture& picture) {
  const FloorPlan& plan = frame.plan;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(plan.nx));
    const int y = static_cast<int>(i / static_cast<std::size_t>(plan.nx));
    const double share = (picture.values.empty() ? 0 : picture.values[i] - picture.low) /
                         (picture.high - picture.low);
    const auto valueColor = [&] {
      return linear(picture.kinds.empty()
                        ? displayColor(ColorMap::kViridis, share)
                        : picture.kinds[static_cast<std::size_t>(picture.values[i])].first);
    };
    const Rgb color =
        picture.marks[i] == PlanMark::kValue ? valueColor() : colorOf(picture.marks[i]);
    const int left = kLeft + x * frame.scale, top = kTop + (plan.ny - 1 - y) * frame.scale;
    fillRect(image, left, top, left + frame.scale, top + frame.scale, color);
  }
}

void drawAxes(Image& image, const Frame& frame) {
  const Rgb ink = grey(0.1);
  const int bottom = kTop + frame.height(), right = kLeft + frame.width();
  for (const int y : {kTop - 1, bottom}) fillRect(image, kLeft - 1, y, right + 1, y + 1, ink);
  for (const int x : {kLeft - 1, right}) fillRect(image, x, kTop - 1, x + 1, bottom + 1, ink);
  for (int axis = 0; axis < 2; ++axis) {
    const int pixels = axis == 0 ? frame.width() : frame.height();
    const double step = niceStep(frame.size(axis), std::max(2, pixels / 90));
    const double end = frame.from(axis) + frame.size(axis) * (1 + 1e-9);
    for (double at = std::ceil(frame.from(axis) / step - 1e-9) * step; at <= end; at += step) {
      const std::string text = tickText(at);
      const TextSize size = textSize(text, kText);
      if (axis == 0) {
        const int x = static_cast<int>(std::lround(frame.x(at)));
        fillRect(image, x, bottom, x + 1, bottom + 6, ink);
        drawText(image, text, x - size.width / 2, bottom + 9, kText, ink);
      } else {
        const int y = static_cast<int>(std::lround(frame.y(at)));
        fillRect(image, kLeft - 6, y, kLeft, y + 1, ink);
        drawText(image, text, kLeft - 10 - size.width, y - 7, kText, ink);
      }
    }
  }
  const TextSize x = textSize("x [m]", kText);
  drawText(image, "x [m]", kLeft + (frame.width() - x.width) / 2, bottom + 32, kText, ink);
  drawTextUpwards(image, "y [m]", 10, kTop + (frame.height() + x.width) / 2, kText, ink);
}

void drawBar(Image& image, const Frame& frame, const PlanPicture& picture) {
  constexpr int kWidth = 22;
  const Rgb ink = grey(0.1);
  const int left = kLeft + frame.width() + 28;
  const int height = std::max(frame.height(), 120), bottom = kTop + height;
  for (int y = kTop; y < bottom; ++y) {
    const double share = (bottom - 0.5 - y) / height;
    fillRect(image, left, y, left + kWidth, y + 1, linear(displayColor(ColorMap::kViridis, share)));
  }
  const double range = picture.high - picture.low;
  const double step = niceStep(range, std::max(2, height / 50));
  for (double at = std::ceil(picture.low / step - 1e-9) * step; at <= picture.high + 1e-9 * range;
       at += step) {
    const int y = static_cast<int>(std::lround(bottom - (at - picture.low) / range * height));
    const bool top = at > picture.high - 1e-6 * range;
    fillRect(image, left + kWidth, y, left + kWidth + 6, y + 1, ink);
    drawText(image, tickText(at) + (top && picture.highIsMore ? "+" : ""), left + kWidth + 10,
             y - 7, kText, ink);
  }
  const TextSize size = textSize(picture.barLabel, kText);
  drawTextUpwards(image, picture.barLabel, left + kWidth + 72, kTop + (height + size.width) / 2,
                  kText, ink);
}

/// A bar along each sign's face and a short line where it faces.
void drawSigns(Image& image, const Frame& frame, std::span<const SightTarget> signs) {
  for (const SightTarget& target : signs) {
    const SafetySign& sign = target.sign;
    const double x = frame.x(sign.position[0]), y = frame.y(sign.position[1]);
    const double nx = sign.normal[0], ny = -sign.normal[1];
    const double half = std::max(9.0, 0.5 * sign.size[0] / frame.plan.step * frame.scale);
    drawLine(image, x + half * ny, y - half * nx, x - half * ny, y + half * nx, 5, kSignColor);
    drawLine(image, x, y, x + 14 * nx, y + 14 * ny, 2, kSignColor);
  }
}

void drawRoutes(Image& image, const Frame& frame, std::span<const Route> routes) {
  for (const Route& route : routes) {
    for (std::size_t i = 1; i < route.points.size(); ++i) {
      drawLine(image, frame.x(route.points[i - 1][0]), frame.y(route.points[i - 1][1]),
               frame.x(route.points[i][0]), frame.y(route.points[i][1]), 3, kRouteColor);
    }
    const double x = frame.x(route.points[0][0]), y = frame.y(route.points[0][1]);
    fillRect(image, static_cast<int>(x) - 5, static_cast<int>(y) - 5, static_cast<int>(x) + 6,
             static_cast<int>(y) + 6, kRouteColor);
  }
}

void drawLegend(Image& image, int top, const std::vector<std::pair<Rgb, std::string>>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const int y = top + static_cast<int>(i) * kRow;
    fillRect(image, kLeft - 1, y - 1, kLeft + 23, y + 17, grey(0.1));
    fillRect(image, kLeft, y, kLeft + 22, y + 16, rows[i].first);
    drawText(image, rows[i].second, kLeft + 32, y + 1, kText, grey(0.1));
  }
}

int scaleOf(const FloorPlan& plan) {
  constexpr int kWide = 900, kHigh = 640;
  return std::clamp(std::min(kWide / plan.nx, kHigh / plan.ny), 1, 64);
}

}  // namespace

Image drawPlan(const FloorPlan& plan, const PlanPicture& picture,
               std::span<const SightTarget> signs, std::span<const Route> routes) {
  const Frame frame{plan, scaleOf(plan)};
  std::vector<std::pair<Rgb, std::string>> rows;
  for (const auto& [color, words] : picture.kinds) rows.emplace_back(linear(color), words);
  for (const auto& [mark, words] : picture.words) {
    if (std::ranges::find(picture.marks, mark) != picture.marks.end())
      rows.emplace_back(colorOf(mark), words);
  }
  rows.emplace_back(kSignColor, "sign, and where it faces");
  if (!routes.empty())
    rows.emplace_back(kRouteColor, "route, from its square");
  int width = kLeft + frame.width() + (picture.barLabel.empty() ? kPlain : kBar);
  for (const auto* text : {&picture.title, &picture.subtitle})
    width = std::max(width, kLeft + textSize(*text, kText).width + kPlain);
  for (const auto& [color, words] : rows)
    width = std::max(width, kLeft + 32 + textSize(words, kText).width + kPlain);
  const int body = picture.barLabel.empty() ? frame.height() : std::max(frame.height(), 120);
  const int legend = kTop + body + kBottom;
  Image image(width, legend + static_cast<int>(rows.size()) * kRow + 6, 3);
  fillRect(image, 0, 0, image.width, image.height, Rgb::Ones());
  drawText(image, picture.title, kLeft, 12, kText, grey(0));
  drawText(image, picture.subtitle, kLeft, 36, kText, grey(0.3));
  drawCells(image, frame, picture);
  drawRoutes(image, frame, routes);
  drawSigns(image, frame, signs);
  drawAxes(image, frame);
  if (!picture.barLabel.empty())
    drawBar(image, frame, picture);
  drawLegend(image, legend, rows);
  return image;
}

}  // namespace volute
