// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/mean_visibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kSpread = 3, kSpreadWithin = 1.5;

/// The best of each value and its neighbours, corners included: by rows of each axis in turn.
template <class Better>
std::vector<float> bestAround(std::vector<float> values, const std::array<int, 3>& size,
                              Better better) {
  std::vector<float> row;
  std::size_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto count = static_cast<std::size_t>(size[axis]);
    for (std::size_t first = 0; first < values.size(); ++first) {
      if (first / stride % count != 0 || count < 2)
        continue;
      row.resize(count);
      for (std::size_t i = 0; i < count; ++i) row[i] = values[first + i * stride];
      for (std::size_t i = 0; i < count; ++i) {
        float& best = values[first + i * stride];
        if (i > 0)
          best = better(best, row[i - 1]);
        if (i + 1 < count)
          best = better(best, row[i + 1]);
      }
    }
    stride *= count;
  }
  return values;
}

/// Whether a value has neighbours on all sides.
bool isWithin(std::size_t value, const std::array<int, 3>& size) {
  for (const int count : size) {
    const auto at = static_cast<int>(value % static_cast<std::size_t>(count));
    if (at == 0 || at == count - 1)
      return false;
    value /= static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace

std::vector<SmokeBand> bandsOfMeans(const SmokeScale& scale, std::span<const float> stored,
                                    const std::array<int, 3>& size) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto known = [](float value) { return value > 0 && value < kInfinity; };
  std::vector<float> least(stored.begin(), stored.end()), most = least;
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (!known(stored[i]))
      least[i] = kInfinity, most[i] = 0;
  }
  least = bestAround(std::move(least), size, [](float a, float b) { return std::min(a, b); });
  most = bestAround(std::move(most), size, [](float a, float b) { return std::max(a, b); });
  const double cap = scale.visibilityCap, c = scale.visibilityFactor;
  std::vector<SmokeBand> bands(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    SmokeBand& band = bands[i];
    band = scale.band(stored[i]);
    if (!known(stored[i]) || band.low < band.high * 0.99F)
      continue;  // at its cap it is the mean of eight of them
    const double mean = stored[i], spread = isWithin(i, size) ? kSpreadWithin : kSpread;
    const double from = least[i] / spread, to = std::min<double>(most[i] * spread, cap);
    band.high = std::max(band.high, static_cast<float>(c * (from + to - mean) / (from * to)));
    // The tangent to C / V from where cells are cut, which may hold no smoke.
    if (to >= cap && mean > cap / 2)
      band.low = static_cast<float>(4 * c * std::max(0.0, cap - mean) / (cap * cap));
  }
  return bands;
}

}  // namespace volute
