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
  for (int y = std::max(low(y0, y1), 0); y < std::min(high(y0, y1), image.height); ++y) {
    for (int x = std::max(low(x0, x1), 0); x < std::min(high(x0, x1), image.width); ++x) {
      const double px = x + 0.5 - x0, py = y + 0.5 - y0;
      const double along =
          length > 0 ? std::clamp((px * (x1 - x0) + py * (y1 - y0)) / length, 0.0, length) : 0;
      const double share = length > 0 ? along / length : 0;
      // Coverage falls from 1 to 0 over one pixel.
      const double off = std::hypot(px - share * (x1 - x0), py - share * (y1 - y0));
      const double cover = std::clamp(half + 0.5 - off, 0.0, 1.0);
      for (int c = 0; c < image.channels; ++c) {
        float& value = image.at(x, y, c);
        value = static_cast<float>(value + cover * (color[c] - value));
      }
    }
  }
}

}  // namespace volute
