// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/srgb.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

/// NaN gives 0.
double clampToUnit(double value) {
  return value > 0 ? std::min(value, 1.0) : 0;
}

}  // namespace

double srgbEncode(double linear) {
  const double v = clampToUnit(linear);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

double srgbDecode(double display) {
  const double v = clampToUnit(display);
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

std::vector<std::uint8_t> toSrgb8(const Image& image, double exposure) {
  std::vector<std::uint8_t> bytes(image.pixels.size());
  std::ranges::transform(image.pixels, bytes.begin(), [&](float value) {
    return static_cast<std::uint8_t>(std::lround(255 * srgbEncode(exposure * value)));
  });
  return bytes;
}

Image exposed(Image image, double factor) {
  for (float& value : image.pixels) value = static_cast<float>(value * factor);
  return image;
}

double suggestExposure(const Image& image, double share) {
  std::vector<float> lit;
  for (float value : image.pixels) {
    if (value > 0 && std::isfinite(value))
      lit.push_back(value);
  }
  if (lit.empty())
    return 1;
  const auto rank =
      static_cast<std::ptrdiff_t>(clampToUnit(share) * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), lit.begin() + rank, lit.end());
  return 1 / static_cast<double>(lit[static_cast<std::size_t>(rank)]);
}

}  // namespace volute
