// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/step_search.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr double kGreatestMove = 8;  // a single outcome says little about steps much further away
constexpr int kMoreTries = 6;        // after none was good enough

}  // namespace

StepSearch::StepSearch(const Problem& problem, double first)
    : problem_(problem),
      step_(std::clamp(first, problem.finest, problem.coarsest)),
      limit_(problem.maxTries) {}

void StepSearch::tell(double outcome) {
  ++tries_;
  const bool good = outcome <= problem_.target;
  const double safest = problem_.grows ? problem_.finest : problem_.coarsest;
  const double boldest = problem_.grows ? problem_.coarsest : problem_.finest;
  const bool repeated = good && good_.known && step_ == good_.step;
  if (good && (!good_.known || outcome >= good_.outcome))
    good_ = {step_, outcome, true};
  if (!good && (!bad_.known || outcome <= bad_.outcome))
    bad_ = {step_, outcome, true};

  if (good && (outcome >= problem_.closeEnough || step_ == boldest || repeated)) {
    found_ = true;
  } else if (!good && step_ == safest) {
    failed_ = true;
  } else if (tries_ < limit_) {
    step_ = proposal();
  } else if (!good_.known) {
    // Where the outcome hardly depends on the step, the safest one would be far too safe.
    step_ = safest < step_ ? std::max(safest, step_ / kGreatestMove)
                           : std::min(safest, step_ * kGreatestMove);
    limit_ = tries_ + kMoreTries;
  } else if (good && step_ == good_.step) {
    found_ = true;
  } else {
    step_ = good_.step;  // what is written last must be what was found
  }
}

double StepSearch::proposal() const {
  const double aim =
      0.5 * (problem_.target + std::max(problem_.closeEnough, 0.9 * problem_.target));
  const auto logOf = [](double value) { return std::log(std::max(value, 1e-300)); };
  double next = 0;
  if (good_.known && bad_.known) {
    // Between the two, where a power law through both meets the aim; never so near to either that
    // nothing is learnt.
    const double span = logOf(bad_.outcome) - logOf(good_.outcome);
    const double along = std::clamp((logOf(aim) - logOf(good_.outcome)) / span, 0.1, 0.9);
    next = good_.step * std::exp(along * std::log(bad_.step / good_.step));
  } else {
    const Try& only = good_.known ? good_ : bad_;
    // Where the outcome hardly depends on the step, or goes up and down with it just beside the
    // target, steps of its own size would never arrive: each try goes further.
    constexpr double kMinMoveAtThird = 0.01;
    const double least = tries_ < 3 ? 1 : 1 + kMinMoveAtThird * std::ldexp(1.0, tries_ - 3);
    double ratio = std::pow(aim / std::max(only.outcome, 1e-300), tries_);
    ratio = ratio < 1 ? std::min(ratio, 1 / least) : std::max(ratio, least);
    const double move =
        std::clamp(problem_.grows ? ratio : 1 / ratio, 1 / kGreatestMove, kGreatestMove);
    next = only.step * move;
  }
  return std::clamp(next, problem_.finest, problem_.coarsest);
}

}  // namespace volute
