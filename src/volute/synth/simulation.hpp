// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "volute/synth/fluid.hpp"

namespace volute {

constexpr float kExtent = 2;                ///< [m], the side of the simulated cube
constexpr float kFrameSeconds = 1.0f / 25;  ///< from one frame to the next

/// A running simulation that begins at rest.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// Goes on by one frame.
  virtual void advanceFrame() = 0;

  /// How many frames pass until what is seen is fully developed.
  virtual int warmUpFrames() const = 0;

  /// The present state, shape (z, y, x, c); finite, >= 0, exactly 0 where nothing is seen.
  /// `channels` is 1 or 3.
  virtual void write(int channels, std::span<float> values) const = 0;
};

std::unique_ptr<Simulation> makeFire(int size, std::uint32_t seed);
std::unique_ptr<Simulation> makeSmoke(int size, std::uint32_t seed);

/// 0 below `low`, 1 above `high`, smooth in between.
inline float smoothStep(float low, float high, float value) {
  const float t = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// 1 inside, falling to 0 at the open faces of the cube, so that what leaves it fades instead of
/// being cut off.
/// @param x, y, z  [m], x and y from the axis, z from the floor.
inline float fadeAtBorder(float x, float y, float z, float width) {
  const float sides =
      std::min({kExtent / 2 - std::max(x, -x), kExtent / 2 - std::max(y, -y), kExtent - z});
  return smoothStep(0, width, sides);
}

}  // namespace volute
