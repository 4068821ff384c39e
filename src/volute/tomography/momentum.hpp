// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <span>

#include "volute/tomography/vector_ops.hpp"

namespace volute {

/// How far accelerated gradient steps go on along the one before (Nesterov; Beck and Teboulle 2009,
/// FISTA).
class Momentum {
 public:
  /// The factor of the step before: 0 at first, then ever closer to 1.
  float next() {
    const double grown = 0.5 * (1 + std::sqrt(1 + 4 * weight_ * weight_));
    const auto factor = static_cast<float>((weight_ - 1) / grown);
    weight_ = grown;
    return factor;
  }

  /// The same after a step from `before` by way of `ahead` to `x`, of four channels with a step
  /// size each four. Begins anew where the momentum went uphill (O'Donoghue and Candes 2015, the
  /// gradient scheme).
  float next(std::span<const float> x, std::span<const float> ahead, std::span<const float> before,
             std::span<const float> step) {
    const double uphill = sumElements(x.size(), [&](std::size_t i) {
      return (static_cast<double>(ahead[i]) - x[i]) * (static_cast<double>(x[i]) - before[i]) /
             step[i / 4];
    });
    if (uphill > 0)
      weight_ = 1;
    return next();
  }

 private:
  double weight_ = 1;
};

}  // namespace volute
