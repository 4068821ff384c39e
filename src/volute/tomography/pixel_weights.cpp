// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/pixel_weights.hpp"

#include <algorithm>

#include "volute/tomography/hull.hpp"

namespace volute {
namespace {

/// The mean over the channels of the squared gradient by central differences.
double squaredGradient(const Image& image, int x, int y) {
  const int left = std::max(x - 1, 0), right = std::min(x + 1, image.width - 1);
  const int above = std::max(y - 1, 0), below = std::min(y + 1, image.height - 1);
  double sum = 0;
  for (int c = 0; c < image.channels; ++c) {
    const double dx = 0.5 * (image.at(right, y, c) - image.at(left, y, c));
    const double dy = 0.5 * (image.at(x, below, c) - image.at(x, above, c));
    sum += dx * dx + dy * dy;
  }
  return sum / image.channels;
}

}  // namespace

std::vector<float> pixelVariance(const TomographyView& view, std::optional<double> noiseSigma) {
  constexpr double kFloor = 0.1;
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
      const double squared = std::max(squaredGradient(image, x, y) - noise, 0.0);
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
