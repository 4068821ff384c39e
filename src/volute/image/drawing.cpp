// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/drawing.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

void fillRect(Image& image, int x0, int y0, int x1, int y1, const Rgb& color) {
  const int left = std::max(x0, 0), right = std::min(x1, image.width);
  const int top = std::max(y0, 0), bottom = std::min(y1, image.height);
  if (left >= right || top >= bottom)
    return;
  for (int x = left; x < right; ++x) {
    for (int c = 0; c < image.channels; ++c) image.at(x, top, c) = static_cast<float>(color[c]);
  }
  const float* first = &image.at(left, top, 0);
  for (int y = top + 1; y < bottom; ++y)
    std::copy_n(first, (right - left) * image.channels, &image.at(left, y, 0));
}

void drawLine(Image& image, double x0, double y0, double x1, double y1, double width,
              const Rgb& color) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  const double half = 0.5 * width;
  const auto low = [&](double a, double b) {
    return static_cast<int>(std::floor(std::min(a, b) - half));
  };
  const auto high = [&](double a, double b) {
    return static_cast<int>(std::ceil(std::max(a, b) + half));
  };
  const double none = half + 0.5;  // coverage falls from 1 to 0 over one pixel
  const double dx = x1 - x0, dy = y1 - y0;
  const int left = std::max(low(x0, x1), 0), right = std::min(high(x0, x1), image.width);
  if (left >= right)
    return;
  const bool flat = std::abs(dy) < 1e-9 * length || length == 0;
  for (int y = std::max(low(y0, y1), 0); y < std::min(high(y0, y1), image.height); ++y) {
    const double py = y + 0.5 - y0;
    int from = left, to = right;
    if (!flat) {  // within `none` of the endless line; a pixel more for rounding
      const double middle = x0 + py * dx / dy, reach = none * length / std::abs(dy) + 1;
      const auto within = [&](double x) {
        return static_cast<int>(std::clamp<double>(x, left, right));
      };
      from = within(middle - reach);
      to = within(middle + reach + 1);
    }
    for (int x = from; x < to; ++x) {
      const double px = x + 0.5 - x0;
      const double share =
          length > 0 ? std::clamp((px * dx + py * dy) / length, 0.0, length) / length : 0;
      const double offX = px - share * dx, offY = py - share * dy;
      const double squared = offX * offX + offY * offY;
      if (squared >= none * none)
        continue;
      const double cover = std::clamp(none - std::sqrt(squared), 0.0, 1.0);
      for (int c = 0; c < image.channels; ++c) {
        float& value = image.at(x, y, c);
        value = static_cast<float>(value + cover * (color[c] - value));
      }
    }
  }
}

}  // namespace volute
