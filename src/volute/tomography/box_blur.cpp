// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/box_blur.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

std::vector<float> boxWeights(double width) {
  const auto whole = static_cast<int>(std::ceil((width - 1) / 2));
  std::vector<float> weights(2 * static_cast<std::size_t>(std::max(whole, 0)) + 1,
                             static_cast<float>(1 / std::max(width, 1.0)));
  if (whole > 0) {
    // What of the box lies in the outermost pixels.
    const double outer = (width - (2 * whole - 1)) / 2;
    weights.front() = weights.back() = static_cast<float>(outer / width);
  }
  return weights;
}

Image boxBlurred(const Image& image, double width) {
  const std::vector<float> weights = boxWeights(width);
  const int reach = static_cast<int>(weights.size() / 2);
  Image wide(image.width, image.height, image.channels), out = wide;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < image.channels; ++c)
        for (int d = -reach; d <= reach; ++d)
          wide.at(x, y, c) += weights[static_cast<std::size_t>(d + reach)] *
                              image.at(std::clamp(x + d, 0, image.width - 1), y, c);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < image.channels; ++c)
        for (int d = -reach; d <= reach; ++d)
          out.at(x, y, c) += weights[static_cast<std::size_t>(d + reach)] *
                             wide.at(x, std::clamp(y + d, 0, image.height - 1), c);
  return out;
}

}  // namespace volute
