// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/smoke_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kLargestByte = 254;
constexpr double kHalfStep = 0.5 + 1e-4;  // of NINT; FDS computes in single precision
constexpr double kFloat = 1e-6;           // what rounding to float may take from a band, relative

SmokeBand widened(double value, double low, double high) {
  return {static_cast<float>(value), static_cast<float>(std::max(0.0, low) * (1 - kFloat)),
          static_cast<float>(high * (1 + kFloat))};
}

/// Extinction of an opacity over `length`, for fractional bytes.
double opaque(double byte, double length) {
  return -std::log1p(-byte / kLargestByte) / length;
}

}  // namespace

SmokeBand SmokeScale::band(float stored, int gas) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const double share = 8.0 / gas;
  if (gas == 0 || !std::isfinite(stored))
    return {kNan, kNan, kNan};
  if (bytes == Bytes::kOpacity) {
    const bool full = stored >= kLargestByte;
    const double low = opaque(std::max(0.0, stored - kHalfStep), cellLength);
    const double value = full ? low : opaque(stored, cellLength);
    const double high = full ? kInfinity : opaque(stored + kHalfStep, cellLength);
    return widened(value * share, low * share, high * share);
  }
  if (bytes == Bytes::kDensity) {
    const double perByte = massExtinction * largestDensity / kLargestByte * share;
    const double most = std::min(stored + 1.0, kLargestByte);
    return widened(stored * perByte, (stored - 0.5) * perByte, most * perByte);
  }
  switch (quantity) {
    case SmokeQuantity::kVisibility: {
      const double cap = visibilityFactor / visibilityCap;
      if (!(stored >= 0))
        return {kNan, kNan, kNan};
      if (stored >= visibilityCap * (1 - kFloat))
        return widened(cap, 0, cap);
      return stored > 0 ? widened(visibilityFactor / stored, visibilityFactor / stored,
                                  visibilityFactor / stored)
                        : SmokeBand{kNan, kNan, kNan};
    }
    case SmokeQuantity::kOpticalDensity: {
      const double value = std::max(0.0, stored * std::log(10.0));
      return widened(value, value, value);
    }
    case SmokeQuantity::kSootDensity: {
      const double least = std::max(0.0, massExtinction * (stored - step) * share);
      const double value = std::max(0.0, massExtinction * stored * share);
      return widened(value, least, massExtinction * (stored + step) * share);
    }
    default: {
      const double value = std::max(0.0F, stored);
      return widened(value, value, value);
    }
  }
}

}  // namespace volute
