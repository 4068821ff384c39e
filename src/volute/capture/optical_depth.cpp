// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/optical_depth.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Behind a medium that thins out towards its rim fewer pixels are within a tenth of the darkest
/// than within the next two thirds of a power of ten.
double commonLevel(std::vector<float> light, double least) {
  constexpr double kShare = 0.01, kDarkest = 0.1, kWidth = 0.1, kNext = 2.7, kTimes = 1.5;
  constexpr std::size_t kFewest = 50;
  const auto rank = static_cast<std::size_t>(0.5 * kShare * static_cast<double>(light.size()));
  if (light.size() < kFewest)
    return 0;
  const auto place = light.begin() + static_cast<std::ptrdiff_t>(rank);
  std::ranges::nth_element(light, place);
  const double level = *place;
  if (!(level > 2 * least && level < kDarkest))
    return 0;
  const auto below = [&](double limit) {
    return static_cast<double>(
        std::ranges::count_if(light, [&](float value) { return value < limit; }));
  };
  const double top = level + std::max(kWidth * level, least), alike = below(top);
  const double enough = std::max<double>(kFewest, 2 * kShare * static_cast<double>(light.size()));
  return alike > enough && alike > kTimes * (below(kNext * level) - alike) ? level : 0;
}

}  // namespace

OpticalDepths opticalDepths(const Image& light, const Image& background,
                            std::span<const float> counts, double darkest) {
  VOLUTE_ASSERT(light.channels == 3 && light.pixels.size() == background.pixels.size());
  const std::size_t pixels = light.pixels.size() / 3;
  OpticalDepths result;
  result.depth = Image(light.width, light.height);
  result.weight.assign(pixels, 0);
  result.atLeast.assign(pixels, 0);
  float brightest = 0;
  for (const float value : background.pixels) brightest = std::max(brightest, value);
  const float least =
      std::max(static_cast<float>(darkest), static_cast<float>(kDarkestOfBackground) * brightest);
  std::size_t lit = 0, opaque = 0;
  std::vector<float> greys;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* behind = &background.pixels[3 * i];
    const float* seen = &light.pixels[3 * i];
    if ((!counts.empty() && counts[i] == 0) ||
        !(std::min({behind[0], behind[1], behind[2]}) > 2 * least))
      continue;
    ++lit;
    greys.push_back((seen[0] + seen[1] + seen[2]) / (3 * brightest));
    for (std::size_t c = 0; c < 3; ++c) {
      result.depth.pixels[3 * i + c] = std::log(behind[c] / std::max(seen[c], least));
      if (!(seen[c] > least))
        result.atLeast[i] |= static_cast<std::uint8_t>(1U << c);
    }
    if (result.atLeast[i] != 0)
      ++opaque;
    else
      result.weight[i] = std::min(std::min({seen[0], seen[1], seen[2]}) / brightest, 1.0F);
  }
  result.levelLeft = commonLevel(std::move(greys), least / brightest);
  result.opaqueShare =
      static_cast<double>(opaque) / static_cast<double>(std::max<std::size_t>(1, lit));
  return result;
}

}  // namespace volute
