// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/compare.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

Result<ImageDifference> compareImages(const Image& original, const Image& other) {
  if (original.width != other.width || original.height != other.height ||
      original.channels != other.channels) {
    return fail(ErrorCode::kInvalidArgument,
                "the images differ in size: {} x {} with {} channels and {} x {} with {}; compare "
                "images of one size",
                original.width, original.height, original.channels, other.width, other.height,
                other.channels);
  }
  if (original.pixels.empty())
    return fail(ErrorCode::kInvalidArgument, "the images have no pixels to compare");
  ImageDifference difference;
  double squares = 0;
  for (std::size_t i = 0; i < original.pixels.size(); ++i) {
    const double error = std::abs(static_cast<double>(original.pixels[i]) - other.pixels[i]);
    squares += error * error;
    if (!(error <= difference.maxError))
      difference.maxError = error;  // NaN wins and stays
  }
  const auto [low, high] = std::ranges::minmax(original.pixels);
  const double range = static_cast<double>(high) - low;
  difference.rms = std::sqrt(squares / static_cast<double>(original.pixels.size()));
  difference.relativeRms = range > 0 ? difference.rms / range : difference.rms;
  difference.psnr = -20 * std::log10(difference.relativeRms);
  if (std::isnan(difference.rms))
    difference.maxError = difference.rms;
  return difference;
}

Image largestDifferences(const Image& a, const Image& b) {
  Image errors(a.width, a.height, 1);
  const auto channels = static_cast<std::size_t>(a.channels);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    float& error = errors.pixels[i / channels];
    error = std::max(error, std::abs(a.pixels[i] - b.pixels[i]));
  }
  return errors;
}

}  // namespace volute
