// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <vector>

namespace volute {

/// A picture of linear floats. Row 0 is the top, channels interleaved: 1 (a measured quantity) or 3
/// (linear RGB).
struct Image {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<float> pixels;  ///< shape (height, width, channels)

  Image() = default;

  Image(int w, int h, int c = 3)
      : width(w), height(h), channels(c), pixels(static_cast<std::size_t>(w) * h * c) {}

  float& at(int x, int y, int c = 0) {
    return pixels[(static_cast<std::size_t>(y) * width + x) * channels + c];
  }

  float at(int x, int y, int c = 0) const {
    return pixels[(static_cast<std::size_t>(y) * width + x) * channels + c];
  }
};

}  // namespace volute
