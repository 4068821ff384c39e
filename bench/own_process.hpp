// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

#include "volute/base/result.hpp"

namespace volute::bench {

/// What a step took and came to. Crosses from its process as bytes.
struct Outcome {
  double seconds = 0;      ///< of CPU
  double megabytes = 0;    ///< that it held at most
  double growth = 0;       ///< of these, what it did not hold when it began
  double value = 0;        ///< what the step found out
  char problem[500] = {};  ///< empty: none
};

/// Runs a step in a process of its own.
[[nodiscard]] Result<Outcome> measured(const std::function<Result<double>()>& step);

}  // namespace volute::bench
