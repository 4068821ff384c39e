// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

namespace volute {

/// Uniform quantisation with a wide zero: an index q stands for q * step, and |c| is rounded down
/// beyond 0.4, which costs fewer bits at equal error than rounding at 0.5 (coefficients are
/// Laplace-like: most of a bin lies at its start).
inline constexpr float kRoundingOffset = 0.4f;

inline std::int32_t quantise(float coefficient, float inverseStep) {
  constexpr float kLargest = 2.0e9f;
  const float magnitude =
      std::fmin(std::fabs(coefficient) * inverseStep + kRoundingOffset, kLargest);
  const auto q = static_cast<std::int32_t>(magnitude);
  return coefficient < 0 ? -q : q;
}

/// Predicts what quantisation of a set of coefficients with any step costs, from one pass over
/// them: a histogram with 64 bins an octave. Counts only, so the order of additions does not
/// matter.
class QuantisationModel {
 public:
  QuantisationModel();

  void add(float coefficient);
  void merge(const QuantisationModel& other);

  /// How many coefficients there are of each size: whole numbers, so that the order in which models
  /// are merged does not matter. Those of several processes are added place by place.
  std::span<std::uint64_t> counts() { return counts_; }

  /// The sum of squared errors of all coefficients at `step`; good to about 2 %.
  double squaredError(double step) const;

  /// About how many bits all coefficients take at `step`; above 0, and the more the finer it is.
  double bits(double step) const;

  /// The largest step whose squaredError is at most `target`; 0 when no coefficient was added.
  double stepFor(double target) const;

 private:
  std::vector<std::uint64_t> counts_;
};

}  // namespace volute
