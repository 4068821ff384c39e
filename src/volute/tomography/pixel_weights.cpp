// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/pixel_weights.hpp"

#include <algorithm>
#include <cmath>

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

/// Of each pixel, without what noise of this variance adds.
std::vector<float> squaredGradients(const TomographyView& view, double noise) {
  const Image& image = view.radiance;
  std::vector<float> squares;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // Noise alone gives a squared gradient of its own variance.
      squares.push_back(static_cast<float>(std::max(squaredGradient(view, x, y) - noise, 0.0)));
    }
  }
  return squares;
}

/// Of optical depths, the light that is left of the brightest background.
double lightLeft(const TomographyView& view, std::size_t pixel) {
  constexpr double kMin = 1e-3;
  if (view.isSaturated(pixel)) {
    const float* depth = &view.radiance.pixels[3 * pixel];
    return std::max(std::exp(-static_cast<double>(std::max({depth[0], depth[1], depth[2]}))), kMin);
  }
  return view.weight.empty() ? 1 : std::max<double>(view.weight[pixel], kMin);
}

}  // namespace

std::vector<float> pixelVariance(const TomographyView& view, std::optional<double> noiseSigma) {
  constexpr double kFloor = 0.03;
  const double sigma = noiseSigma.value_or(noiseOf(view));
  const double noise = sigma * sigma;
  std::vector<float> variance = squaredGradients(view, noise);
  double sum = 0;
  std::size_t seen = 0;
  for (float& value : variance) {
    value *= static_cast<float>(kSightError * kSightError);
    sum += value;
    seen += value > 0 ? 1 : 0;
  }
  const double floor = seen > 0 ? kFloor * sum / static_cast<double>(seen) : 0;
  for (std::size_t pixel = 0; pixel < variance.size(); ++pixel) {
    const double left = view.opticalDepth ? lightLeft(view, pixel) : 1;
    variance[pixel] += static_cast<float>(noise / (left * left) + floor);
  }
  return variance;
}

}  // namespace volute
