// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>

#include "volute/synth/field.hpp"

namespace volute {

/// A well mixed 32-bit hash: the only source of randomness here, the same on every machine.
std::uint32_t mix(std::uint32_t value);

/// Smooth random vectors in [-1, 1]^3 that vary in space and time: value noise on a lattice over
/// the cube [0, extent]^3 whose nodes take new random values every `period` seconds and blend in
/// between.
class VectorNoise {
 public:
  /// @param cell  [m], distance of the nodes: the size of the eddies.
  VectorNoise(std::uint32_t seed, float extent, float cell, float period);

  /// Sets the snapshot [s], >= 0, that `at` sees.
  void setTime(double seconds);

  /// At a point [m] of the cube.
  std::array<float, 3> at(float px, float py, float pz) const;

 private:
  using Nodes = std::array<Field, 3>;

  void fill(Nodes& nodes, std::uint32_t epoch) const;

  std::uint32_t seed_;
  float perCell_;
  float period_;
  std::uint32_t epoch_ = 0;
  Nodes begin_, end_;  // at the begin and the end of the present period
  Nodes nodes_;        // now
};

}  // namespace volute
