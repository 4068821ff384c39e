// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/noise.hpp"

#include <cmath>

namespace volute {
namespace {

float smooth(float t) { return t * t * (3 - 2 * t); }

// Moves a lattice coordinate so that linear interpolation there is smooth interpolation here.
float eased(float p) {
  const float cell = std::floor(p);
  return cell + smooth(p - cell);
}

}  // namespace

std::uint32_t mix(std::uint32_t value) {
  value ^= value >> 16;
  value *= 0x7FEB352Du;
  value ^= value >> 15;
  value *= 0x846CA68Bu;
  value ^= value >> 16;
  return value;
}

VectorNoise::VectorNoise(std::uint32_t seed, float extent, float cell, float period)
    : seed_(mix(seed)), perCell_(1 / cell), period_(period) {
  const int side = static_cast<int>(std::ceil(extent * perCell_)) + 2;
  nodes_.fill(Field(side, side, side));
  setTime(0);
}

float VectorNoise::node(std::uint32_t epoch, std::size_t index, std::uint32_t component) const {
  const std::uint32_t bits = mix(mix(seed_ + epoch) ^ (static_cast<std::uint32_t>(index) * 3 + component));
  return static_cast<float>(bits >> 8) * 0x1p-23f - 1;
}

void VectorNoise::setTime(double seconds) {
  const double phase = seconds / period_;
  const double epoch = std::floor(phase);
  const float blend = smooth(static_cast<float>(phase - epoch));
  const auto now = static_cast<std::uint32_t>(epoch);
  for (std::uint32_t component = 0; component < 3; ++component) {
    auto& values = nodes_[component].values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float a = node(now, i, component);
      values[i] = a + blend * (node(now + 1, i, component) - a);
    }
  }
}

std::array<float, 3> VectorNoise::at(float px, float py, float pz) const {
  const Tap tap(nodes_[0], eased(px * perCell_), eased(py * perCell_), eased(pz * perCell_));
  return {tap.interpolate(tap.corners(nodes_[0])), tap.interpolate(tap.corners(nodes_[1])),
          tap.interpolate(tap.corners(nodes_[2]))};
}

}  // namespace volute
