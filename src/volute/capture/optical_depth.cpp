// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/optical_depth.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"

namespace volute {

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
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* behind = &background.pixels[3 * i];
    const float* seen = &light.pixels[3 * i];
    if ((!counts.empty() && counts[i] == 0) ||
        !(std::min({behind[0], behind[1], behind[2]}) > 2 * least))
      continue;
    ++lit;
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
  result.opaqueShare =
      static_cast<double>(opaque) / static_cast<double>(std::max<std::size_t>(1, lit));
  return result;
}

}  // namespace volute
