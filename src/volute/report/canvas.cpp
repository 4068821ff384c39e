// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/canvas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "volute/image/drawing.hpp"
#include "volute/image/srgb.hpp"
#include "volute/image/text.hpp"
#include "volute/report/page.hpp"

namespace volute {
namespace {

constexpr TextStyle kLetters{Typeface::kSans, kCanvasTextHeight};
constexpr double kBaseline = 0.93;  // of a letter's height, below its top
constexpr double kHatchStep = 8;    // pixels between lines, along x
constexpr double kHatchWidth = 1.3;
constexpr double kDash = 7;

/// Calls draw(from, to) for the lines of a hatch: x + y, or y - x of falling ones, is a multiple of
/// the step.
void hatchLines(double x0, double y0, double x1, double y1, bool falling,
                const std::function<void(const Vec2&, const Vec2&)>& draw) {
  if (falling) {
    hatchLines(-x1, y0, -x0, y1, false, [&](const Vec2& a, const Vec2& b) {
      draw(Vec2(-a.x(), a.y()), Vec2(-b.x(), b.y()));
    });
    return;
  }
  for (double sum = std::ceil((x0 + y0) / kHatchStep) * kHatchStep; sum < x1 + y1;
       sum += kHatchStep) {
    const double left = std::max(x0, sum - y1), right = std::min(x1, sum - y0);
    if (left < right)
      draw(Vec2(left, sum - left), Vec2(right, sum - right));
  }
}

class ImageCanvas final : public Canvas {
 public:
  explicit ImageCanvas(Image& image) : image_(image) {}

  void rect(double x0, double y0, double x1, double y1, const Rgb& color) override {
    const auto ends = [](double from, double to) {
      const int begin = static_cast<int>(std::lround(from));
      return std::pair(begin, std::max(static_cast<int>(std::lround(to)), begin + 1));
    };
    const auto [left, right] = ends(x0, x1);
    const auto [top, bottom] = ends(y0, y1);
    fillRect(image_, left, top, right, bottom, color);
  }

  void line(const Vec2& from, const Vec2& to, double width, const Rgb& color,
            bool dashed) override {
    const double length = (to - from).norm();
    const double step = dashed ? kDash : std::max(length, 1e-9);
    for (double at = 0; at < length; at += dashed ? 2 * step : step) {
      const Vec2 a = from + (to - from) * (at / length);
      const Vec2 b = from + (to - from) * (std::min(at + step, length) / length);
      drawLine(image_, a.x(), a.y(), b.x(), b.y(), width, color);
    }
  }

  void triangle(const Vec2& a, const Vec2& b, const Vec2& c, const Rgb& color) override {
    const auto edge = [](const Vec2& from, const Vec2& to, const Vec2& p) {
      return (to.x() - from.x()) * (p.y() - from.y()) - (to.y() - from.y()) * (p.x() - from.x());
    };
    const double way = edge(a, b, c) >= 0 ? 1 : -1;
    const Vec2 least = a.cwiseMin(b).cwiseMin(c), most = a.cwiseMax(b).cwiseMax(c);
    for (int y = static_cast<int>(least.y()); y <= static_cast<int>(most.y()); ++y) {
      for (int x = static_cast<int>(least.x()); x <= static_cast<int>(most.x()); ++x) {
        const Vec2 p(x + 0.5, y + 0.5);
        if (way * edge(a, b, p) >= 0 && way * edge(b, c, p) >= 0 && way * edge(c, a, p) >= 0)
          fillRect(image_, x, y, x + 1, y + 1, color);
      }
    }
  }

  void hatch(double x0, double y0, double x1, double y1, const Rgb& color, bool falling) override {
    hatchLines(x0, y0, x1, y1, falling, [&](const Vec2& a, const Vec2& b) {
      drawLine(image_, a.x(), a.y(), b.x(), b.y(), kHatchWidth, color);
    });
  }

  void text(std::string_view text, double x, double y, const Rgb& color, Anchor anchor) override {
    const double share = anchor == Anchor::kBegin ? 0 : anchor == Anchor::kMiddle ? 0.5 : 1;
    drawText(image_, text, x - share * canvasTextWidth(text), y, kLetters, color);
  }

  void textUpwards(std::string_view text, double x, double y, const Rgb& color) override {
    drawTextUpwards(image_, text, x, y + 0.5 * canvasTextWidth(text), kLetters, color);
  }

 private:
  Image& image_;
};

std::string hexOf(const Rgb& color) {
  const auto byte = [&](int c) {
    return std::lround(255 * srgbEncode(std::clamp(color[c], 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(0), byte(1), byte(2));
}

}  // namespace

double canvasTextWidth(std::string_view text) {
  return textSize(text, kLetters).width;
}

std::unique_ptr<Canvas> imageCanvas(Image& image) {
  return std::make_unique<ImageCanvas>(image);
}

void SvgCanvas::rect(double x0, double y0, double x1, double y1, const Rgb& color) {
  body_ += fmt::format("<rect x='{:.2f}' y='{:.2f}' width='{:.2f}' height='{:.2f}' fill='{}'/>\n",
                       x0, y0, std::max(x1 - x0, 0.5), std::max(y1 - y0, 0.5), hexOf(color));
}

void SvgCanvas::line(const Vec2& from, const Vec2& to, double width, const Rgb& color,
                     bool dashed) {
  body_ += fmt::format(
      "<line x1='{:.2f}' y1='{:.2f}' x2='{:.2f}' y2='{:.2f}' stroke='{}' "
      "stroke-width='{:.3g}'{}/>\n",
      from.x(), from.y(), to.x(), to.y(), hexOf(color), width,
      dashed ? fmt::format(" stroke-dasharray='{0} {0}'", kDash) : "");
}

void SvgCanvas::triangle(const Vec2& a, const Vec2& b, const Vec2& c, const Rgb& color) {
  body_ += fmt::format("<polygon points='{:.2f},{:.2f} {:.2f},{:.2f} {:.2f},{:.2f}' fill='{}'/>\n",
                       a.x(), a.y(), b.x(), b.y(), c.x(), c.y(), hexOf(color));
}

void SvgCanvas::hatch(double x0, double y0, double x1, double y1, const Rgb& color, bool falling) {
  std::string path;
  hatchLines(x0, y0, x1, y1, falling, [&](const Vec2& a, const Vec2& b) {
    path += fmt::format("M{:.2f} {:.2f}L{:.2f} {:.2f}", a.x(), a.y(), b.x(), b.y());
  });
  if (!path.empty()) {
    body_ += fmt::format("<path d='{}' stroke='{}' stroke-width='{}'/>\n", path, hexOf(color),
                         kHatchWidth);
  }
}

void SvgCanvas::text(std::string_view text, double x, double y, const Rgb& color, Anchor anchor) {
  constexpr std::string_view kAnchors[] = {"start", "middle", "end"};
  body_ += fmt::format("<text x='{:.2f}' y='{:.2f}' fill='{}' text-anchor='{}'>{}</text>\n", x,
                       y + kBaseline * kCanvasTextHeight, hexOf(color),
                       kAnchors[static_cast<int>(anchor)], escapedHtml(std::string(text)));
}

void SvgCanvas::textUpwards(std::string_view text, double x, double y, const Rgb& color) {
  const double base = x + kBaseline * kCanvasTextHeight;
  body_ += fmt::format(
      "<text x='{0:.2f}' y='{1:.2f}' fill='{2}' text-anchor='middle' transform='rotate(-90 "
      "{0:.2f} {1:.2f})'>{3}</text>\n",
      base, y, hexOf(color), escapedHtml(std::string(text)));
}

std::string SvgCanvas::finish() const {
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 "
      "{0:.0f} "
      "{1:.0f}' font-family='DejaVu Sans, Verdana, sans-serif' font-size='{2}'>\n<rect "
      "width='100%' "
      "height='100%' fill='#fff'/>\n{3}</svg>\n",
      width_, height_, kCanvasTextHeight, body_);
}

}  // namespace volute
