// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/tolerance_search.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace volute::bench {
namespace {

constexpr double kEnough = 0.98;  ///< of the target
constexpr double kAim = 0.99;
constexpr int kTries = 24;

struct Try {
  double tolerance = 0, error = 0;
};

/// Where a line through both tries, logarithmic in both axes, meets `aim`; well inside of them, so
/// that a bent curve cannot stall the search.
double between(const Try& low, const Try& high, double aim) {
  double share = 0.5;
  if (low.error > 0 && high.error > low.error)
    share = std::log(aim / low.error) / std::log(high.error / low.error);
  share = std::clamp(share, 0.1, 0.9);
  return low.tolerance * std::pow(high.tolerance / low.tolerance, share);
}

/// From one try alone, as if the error were proportional to the tolerance.
double beyond(const Try& one, double aim) {
  return one.tolerance * (one.error > 0 ? std::clamp(aim / one.error, 0.125, 8.0) : 8.0);
}

}  // namespace

Result<double> searchTolerance(double target, double start,
                               const std::function<Result<double>(double)>& error) {
  const double aim = kAim * target;
  std::optional<Try> within, above;
  for (int i = 0; i < kTries; ++i) {
    Try next{start, 0};
    if (within && above)
      next.tolerance = between(*within, *above, aim);
    else if (within || above)
      next.tolerance = beyond(within ? *within : *above, aim);
    VOLUTE_ASSIGN(next.error, error(next.tolerance));
    (next.error <= target ? within : above) = next;
    const bool narrow = within && above && above->tolerance < 1.002 * within->tolerance;
    if (narrow || (next.error <= target && next.error >= kEnough * target))
      break;
  }
  if (!within)
    return fail(ErrorCode::kInvalidArgument, "no tolerance keeps the relative RMS within {}",
                target);
  return within->tolerance;
}

}  // namespace volute::bench
