// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"

namespace volute::conformance {

/// The same numbers on every platform, unlike the distributions of <random>.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  double uniform(double from, double to) { return from + (to - from) * (engine_() / 4294967296.0); }

  Vec3 pointIn(const Box3& box);
  Vec3 direction();
  std::vector<double> numbers(std::size_t count, double from, double to);

 private:
  std::mt19937 engine_;
};

}  // namespace volute::conformance
