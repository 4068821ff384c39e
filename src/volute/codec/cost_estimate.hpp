// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/block_codec.hpp"
#include "volute/codec/wavelet_codec.hpp"

namespace volute {

/// What coding a transformed block would cost, told from the sizes of its coefficients alone: ten
/// times faster than coding it. Good enough to tell modes apart, which differ in how few
/// coefficients they need. Whole numbers: the same everywhere.
class CostEstimate {
 public:
  /// @param lambda  what a bit is worth, in squared steps
  CostEstimate(const WaveletParameters& parameters, double lambda);

  /// Squared error [steps^2] + lambda * bits.
  double of(std::span<const float> planes, const BlockShape& shape, const BlockMode& mode) const;

 private:
  // By the first bits of a squared size in steps: eight to each doubling.
  static constexpr int kShift = 20;
  static constexpr int kFirst = (127 - 12) << 3;  // of 2^-12
  static constexpr int kCount = 42 << 3;
  static constexpr double kUnit = 4096;

  std::array<std::uint32_t, kCount> costs_;
  float steps_;  // a coefficient of norm 1 in steps
};

}  // namespace volute
