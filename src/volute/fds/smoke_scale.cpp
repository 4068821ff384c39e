// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/smoke_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kLargestByte = 254;
constexpr double kSlack = 1e-4;      // of a byte: FDS may compute in single precision
constexpr double kWordSlack = 0.02;  // of a 16-bit step, for the same reason
constexpr double kFloat = 1e-6;      // what rounding to float may take from a band, relative
constexpr double kNoise = 1e-4;      // [1/m]; what is more negative is no extinction

SmokeBand widened(double value, double low, double high) {
  return {static_cast<float>(value), static_cast<float>(std::max(0.0, low) * (1 - kFloat)),
          static_cast<float>(high * (1 + kFloat))};
}

/// Extinction of an opacity over `length`, for fractional bytes.
double opaque(double byte, double length) {
  return -std::log1p(-byte / kLargestByte) / length;
}

}  // namespace

SmokeBand SmokeScale::band(float stored) const {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  if (!std::isfinite(stored))
    return {kNan, kNan, kNan};
  if (bytes == Bytes::kOpacity) {
    const double below = rounding == Rounding::kDown ? 0 : 0.5;
    const double above = rounding == Rounding::kNearest ? 0.5 : 1;
    const double least = std::clamp(stored - below - kSlack, 0.0, kLargestByte - 0.5);
    const double most = std::min(stored + above + kSlack, kLargestByte);
    const double middle = rounding == Rounding::kDown && stored > 0 ? stored + 0.5 : stored;
    return widened(opaque(std::min(middle, kLargestByte - 0.5), cellLength),
                   opaque(least, cellLength), opaque(most, cellLength));
  }
  if (bytes == Bytes::kDensity) {
    const double perByte = massExtinction * largestDensity / kLargestByte;
    const double above = rounding == Rounding::kNearest ? 0.5 : 1.0;
    const double most = std::min(stored + above, kLargestByte);
    return widened(stored * perByte, (stored - 0.5) * perByte, most * perByte);
  }
  if (bytes == Bytes::kHeat) {
    const double perByte = largestHeat / kLargestByte;
    const double middle = stored > 0 ? stored + 0.5 : 0;
    return widened(
        middle * perByte, stored * perByte,
        stored < kLargestByte ? (stored + 1) * perByte : std::numeric_limits<double>::infinity());
  }
  if (bytes == Bytes::kTemperature) {
    const auto [least, most] = temperature;
    const double perByte = (most - least) / kLargestByte;
    const auto at = [&](double byte) { return static_cast<float>(least + byte * perByte); };
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    return {stored > 0 ? at(std::min(stored + 0.5, kLargestByte)) : at(0),
            stored > 0 ? at(stored) : -kInfinity,
            stored < kLargestByte ? at(stored + 1) : kInfinity};
  }
  if (asStored)
    return {stored, stored, stored};
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
      const double value = stored * std::log(10.0);
      if (value < -kNoise)
        return {kNan, kNan, kNan};
      return widened(std::max(0.0, value), value, std::max(0.0, value));
    }
    case SmokeQuantity::kSootDensity: {
      if (massExtinction * stored < -kNoise)
        return {kNan, kNan, kNan};
      const double slack = kWordSlack * step;
      const double middle = stored > 0 ? massExtinction * (stored + 0.5 * step) : 0;
      return widened(middle, massExtinction * (stored - slack),
                     std::max(middle, massExtinction * (stored + step + slack)));
    }
    default: {
      if (stored < -kNoise)
        return {kNan, kNan, kNan};
      const double value = std::max(0.0F, stored);
      return widened(value, value, value);
    }
  }
}

SmokeBand gasOnly(const SmokeBand& all, const SmokeBand& first, const NodeCells& cells) {
  const double gas = cells.gas;
  const double all8 = gas + cells.open + cells.held;
  SmokeBand held;  // of one held cell; nothing in a case that began clear
  if (first.value > 0) {
    const double perCell = 8 / all8;
    held = widened(first.value * perCell, first.low * perCell, first.high * perCell);
  }
  const auto rest = [&](double mean, double one) {
    return std::max(0.0, 8 * mean - cells.held * one);
  };
  const double value = rest(all.value, held.value) / (gas + cells.open);
  const double low = rest(all.low, held.high) / (gas + cells.open);
  const double high = rest(all.high, held.low) / std::max(gas, 1.0);
  return widened(value, std::min(low, value), std::max(high, value));
}

SmokeBand gasOnly(const SmokeBand& all, double ambient, const NodeCells& cells) {
  const auto rise = [&](float value) { return static_cast<float>(value - ambient); };
  const float value = std::isinf(all.low) ? 0 : rise(all.value);  // "at most"
  const SmokeBand gas = gasOnly({value, rise(all.low), rise(all.high)}, SmokeBand{}, cells);
  const auto shifted = [&](float value) { return static_cast<float>(value + ambient); };
  return {shifted(gas.value), shifted(gas.low), shifted(gas.high)};
}

}  // namespace volute