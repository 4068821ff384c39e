// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/noise.hpp"

#include <cmath>

namespace volute {
namespace {

float smooth(float t) {
  return t * t * (3 - 2 * t);
}

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
  begin_ = end_ = nodes_;
  fill(begin_, 0);
  fill(end_, 1);
  setTime(0);
}

void VectorNoise::fill(Nodes& nodes, std::uint32_t epoch) const {
  const std::uint32_t base = mix(seed_ + epoch);
  for (std::uint32_t component = 0; component < 3; ++component) {
    std::uint32_t key = component;
    for (float& value : nodes[component].values) {
      value = static_cast<float>(mix(base ^ key) >> 8) * 0x1p-23f - 1;
      key += 3;
    }
  }
}

void VectorNoise::setTime(double seconds) {
  const double phase = seconds / period_;
  const double start = std::floor(phase);
  const float blend = smooth(static_cast<float>(phase - start));
  const auto epoch = static_cast<std::uint32_t>(start);
  if (epoch != epoch_) {
    fill(begin_, epoch);
    fill(end_, epoch + 1);
    epoch_ = epoch;
  }
  for (std::size_t c = 0; c < nodes_.size(); ++c) {
    for (std::size_t i = 0; i < nodes_[c].values.size(); ++i) {
      const float from = begin_[c].values[i];
      nodes_[c].values[i] = from + blend * (end_[c].values[i] - from);
    }
  }
}

std::array<float, 3> VectorNoise::at(float px, float py, float pz) const {
  const Tap tap(nodes_[0], eased(px * perCell_), eased(py * perCell_), eased(pz * perCell_));
  return {tap.interpolate(tap.corners(nodes_[0])), tap.interpolate(tap.corners(nodes_[1])),
          tap.interpolate(tap.corners(nodes_[2]))};
}

}  // namespace volute
