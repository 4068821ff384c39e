// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/fog_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "volute/image/colormap.hpp"

namespace volute {

void FogPlan::draw(const Image& map) {
  stale_ = false;
  if (map.width != width_ || map.height != height_)
    texture_ = makeTexture2d(GL_RGBA8, map.width, map.height);
  width_ = map.width, height_ = map.height;
  constexpr int kColors = 256;
  std::array<std::array<std::uint8_t, 4>, kColors> colors{};
  for (int i = 0; i < kColors; ++i) {
    const Rgb color = displayColor(ColorMap::kViridis, i / (kColors - 1.0));
    for (int c = 0; c < 3; ++c)
      colors[i][c] = static_cast<std::uint8_t>(std::lround(255 * color[c]));
    colors[i][3] = 255;
  }
  std::vector<std::uint8_t> texels;
  for (const float value : map.pixels) {
    const auto& color = colors[std::lround((kColors - 1) * std::clamp(value, 0.0F, 1.0F))];
    texels.insert(texels.end(), color.begin(), color.end());
  }
  glTextureSubImage2D(texture_.name(), 0, 0, 0, map.width, map.height, GL_RGBA, GL_UNSIGNED_BYTE,
                      texels.data());
}

}  // namespace volute
