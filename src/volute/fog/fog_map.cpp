// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_map.hpp"

#include <cmath>

namespace volute {
namespace {

Status check(const FogPlacement& placement) {
  if (!(std::isfinite(placement.cell) && placement.cell > 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "the fog map's cell is {} m, but it must be a length above 0", placement.cell);
  }
  if (!(std::isfinite(placement.sigmaMax) && placement.sigmaMax >= 0)) {
    return fail(ErrorCode::kInvalidArgument,
                "the fog map's sigma_max is {} per metre, but an extinction cannot be negative "
                "and must be finite",
                placement.sigmaMax);
  }
  if (!placement.origin.allFinite())
    return fail(ErrorCode::kInvalidArgument, "the fog map's origin is not finite");
  return {};
}

Status checkSize(int columns, int rows) {
  constexpr double kMax = 1 << 28;
  if (columns < 1 || rows < 1) {
    return fail(ErrorCode::kInvalidData, "the fog map has {} x {} pixels, but needs at least one",
                columns, rows);
  }
  if (double(columns) * rows > kMax) {
    return fail(ErrorCode::kTooLarge,
                "the fog map has {} x {} pixels, but at most 2^28 are allowed", columns, rows);
  }
  return {};
}

/// One pixel as a number; Rec. 709 weights for three channels.
double grey(const Image& image, int x, int y) {
  if (image.channels == 1)
    return image.at(x, y);
  return 0.2126 * image.at(x, y, 0) + 0.7152 * image.at(x, y, 1) + 0.0722 * image.at(x, y, 2);
}

/// Three channels with the same values, as most programs for painting save grey.
bool isGrey(const Image& image) {
  for (std::size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
    if (image.pixels[i] != image.pixels[i + 1] || image.pixels[i] != image.pixels[i + 2])
      return false;
  }
  return true;
}

}  // namespace

Result<FogMap> FogMap::fromImage(const Image& pixels, const FogPlacement& placement,
                                 FogColour colour) {
  VOLUTE_TRY(check(placement));
  VOLUTE_TRY(checkSize(pixels.width, pixels.height));
  const bool rgb = pixels.channels == 3;
  if (pixels.channels != 1 && !(rgb && (colour == FogColour::kLuma || isGrey(pixels)))) {
    return fail(ErrorCode::kInvalidData,
                "the fog map has {} channels, but one is expected: give a greyscale picture{}",
                pixels.channels, rgb ? ", or ask for its luma" : "");
  }
  FogMap map{SplineGrid(pixels.width, pixels.height), placement.origin, placement.cell};
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const double value = grey(pixels, x, y);
      if (!(std::isfinite(value) && value >= 0)) {
        return fail(ErrorCode::kInvalidData,
                    "pixel {}, {} of the fog map is {}, but must be finite and not negative", x, y,
                    value);
      }
      map.coefficients.at(x, pixels.height - 1 - y) = value * placement.sigmaMax;
    }
  }
  return map;
}

Result<FogMap> FogMap::fromCoefficients(SplineGrid coefficients, const FogPlacement& placement) {
  VOLUTE_TRY(check(placement));
  VOLUTE_TRY(checkSize(coefficients.columns, coefficients.rows));
  if (coefficients.c.size() != static_cast<std::size_t>(coefficients.columns) * coefficients.rows) {
    return fail(ErrorCode::kInvalidArgument,
                "the fog map has {} coefficients, but {} x {} = {} are "
                "expected",
                coefficients.c.size(), coefficients.columns, coefficients.rows,
                static_cast<std::size_t>(coefficients.columns) * coefficients.rows);
  }
  for (std::size_t k = 0; k < coefficients.c.size(); ++k) {
    if (!(std::isfinite(coefficients.c[k]) && coefficients.c[k] >= 0)) {
      return fail(ErrorCode::kInvalidData,
                  "coefficient {} of the fog map is {}, but must be finite and not negative", k,
                  coefficients.c[k]);
    }
  }
  return FogMap{std::move(coefficients), placement.origin, placement.cell};
}

}  // namespace volute
