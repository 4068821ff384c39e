// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// What figures are drawn on: pixels, or a vector file of the same size. Lengths are in pixels, x
/// to the right and y down; colours are linear RGB. Later things are drawn over earlier ones.
class Canvas {
 public:
  enum class Anchor { kBegin, kMiddle, kEnd };

  virtual ~Canvas() = default;

  /// x0 <= x < x1, y0 <= y < y1; of pixels those whose middle is in it, at least one across.
  virtual void rect(double x0, double y0, double x1, double y1, const Rgb& color) = 0;

  virtual void line(const Vec2& from, const Vec2& to, double width, const Rgb& color,
                    bool dashed = false) = 0;

  /// A filled triangle.
  virtual void triangle(const Vec2& a, const Vec2& b, const Vec2& c, const Rgb& color) = 0;

  /// Thin lines from lower left to upper right (`falling`: from upper left to lower right) across a
  /// rectangle, in step with those of others.
  virtual void hatch(double x0, double y0, double x1, double y1, const Rgb& color,
                     bool falling = false) = 0;

  /// One line of text whose top left, top middle or top right is at (x, y).
  virtual void text(std::string_view text, double x, double y, const Rgb& color,
                    Anchor anchor = Anchor::kBegin) = 0;

  /// The same that runs upwards, its middle at y.
  virtual void textUpwards(std::string_view text, double x, double y, const Rgb& color) = 0;
};

/// How wide text() draws a line, and how high.
double canvasTextWidth(std::string_view text);
inline constexpr double kCanvasTextHeight = 16;

/// Draws into pixels; `image` has three channels and outlives it.
std::unique_ptr<Canvas> imageCanvas(Image& image);

/// Draws into the text of an SVG file.
class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(double width, double height) : width_(width), height_(height) {}

  void rect(double x0, double y0, double x1, double y1, const Rgb& color) override;
  void line(const Vec2& from, const Vec2& to, double width, const Rgb& color, bool dashed) override;
  void triangle(const Vec2& a, const Vec2& b, const Vec2& c, const Rgb& color) override;
  void hatch(double x0, double y0, double x1, double y1, const Rgb& color, bool falling) override;
  void text(std::string_view text, double x, double y, const Rgb& color, Anchor anchor) override;
  void textUpwards(std::string_view text, double x, double y, const Rgb& color) override;

  /// The whole file.
  std::string finish() const;

 private:
  double width_, height_;
  std::string body_;
};

}  // namespace volute
