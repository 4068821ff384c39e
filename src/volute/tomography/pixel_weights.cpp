// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/pixel_weights.hpp"

#include <algorithm>

#include "volute/tomography/hull.hpp"

namespace volute {
namespace {

/// The mean over the channels of the squared gradient by central differences, or by one-sided ones
/// beside the border and beside pixels that do not count.
double squaredGradient(const TomographyView& view, int x, int y) {
  const Image& image = view.radiance;
  auto counts = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= image.width || j >= image.height)
      return false;
    const std::size_t pixel = static_cast<std::size_t>(j) * image.width + i;
    return view.counts(pixel) || view.isSaturated(pixel);
  };
  const int left = counts(x - 1, y) ? x - 1 : x, right = counts(x + 1, y) ? x + 1 : x;
  const int above = counts(x, y - 1) ? y - 1 : y, below = counts(x, y + 1) ? y + 1 : y;
  double sum = 0;
  for (int c = 0; c < image.channels; ++c) {
    const double dx = image.at(right, y, c) - image.at(left, y, c);
    const double dy = image.at(x, below, c) - image.at(x, above, c);
    sum += dx * dx / std::max(1, (right - left) * (right - left)) +
           dy * dy / std::max(1, (below - above) * (below - above));
  }
  return sum / image.channels;
}

}  // namespace

std::vector<float> pixelVariance(const TomographyView& view, std::optional<double> noiseSigma) {
  constexpr double kFloor = 0.03;
  const Image& image = view.radiance;
  const double sigma = noiseSigma.value_or(noiseOf(view));
  const double noise = sigma * sigma;
  std::vector<float> variance(static_cast<std::size_t>(image.width) * image.height);
  double sum = 0;
  std::size_t seen = 0;
  std::size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i) {
      // Noise alone gives a squared gradient of its own variance.
      const double squared = std::max(squaredGradient(view, x, y) - noise, 0.0);
      variance[i] = static_cast<float>(squared * kSightError * kSightError);
      sum += variance[i];
      seen += variance[i] > 0 ? 1 : 0;
    }
  }
  const double floor = seen > 0 ? kFloor * sum / static_cast<double>(seen) : 0;
  for (float& value : variance) value += static_cast<float>(noise + floor);
  return variance;
}

}  // namespace volute
