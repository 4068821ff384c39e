// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/surface_stack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "volute/base/parallel.hpp"

namespace volute {

void SurfaceStack::add(SurfaceView view) {
  constexpr std::size_t kGrain = 1 << 16;  // pixels
  const bool first = depth_.empty();
  if (first)
    depth_ = std::move(view.depth), color_ = std::move(view.color);
  if (first && background_.isZero(0))
    return;  // black where nothing is
  parallelRanges(depth_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (first && !std::isfinite(depth_[i])) {
        for (std::size_t c = 0; c < 3; ++c)
          color_.pixels[3 * i + c] = static_cast<float>(background_[c]);
      } else if (!first && view.depth[i] < depth_[i]) {
        set(i, view.depth[i], &view.color.pixels[3 * i]);
      }
    }
  });
}

void SurfaceStack::add(std::span<const SignPixel> signs) {
  constexpr float kDark[3] = {};
  if (!signs.empty())
    begin();
  for (const SignPixel& sign : signs)
    set(static_cast<std::size_t>(sign.pixel), sign.distance, kDark);
}

void SurfaceStack::begin() {
  if (!depth_.empty())
    return;
  color_ = Image(width_, height_, 3);
  depth_.assign(color_.pixels.size() / 3, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < color_.pixels.size(); ++i)
    color_.pixels[i] = static_cast<float>(background_[i % 3]);
}

void SurfaceStack::set(std::size_t pixel, float depth, const float* color) {
  depth_[pixel] = depth;
  std::copy_n(color, 3, &color_.pixels[3 * pixel]);
}

}  // namespace volute
