// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/step_search.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr double kGreatestMove = 8;  // a single outcome says little about steps much further away
constexpr int kMoreTries = 6;        // after none was good enough, or none near enough
constexpr double kNear = 0.75;       // of the target

double logOf(double value) {
  return std::log(std::max(value, 1e-300));
}

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
  } else if (!problem_.grows && bad_.known && good_.outcome < kNear * problem_.target &&
             limit_ == problem_.maxTries) {
    limit_ = tries_ + kMoreTries;
    step_ = proposal();
  } else if (good && step_ == good_.step) {
    found_ = true;
  } else {
    step_ = good_.step;  // what is written last must be what was found
  }
}

double StepSearch::Problem::stepOf(double value, double finer, double coarser) const {
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(finer * coarser);
    ((predict(middle) > value) == grows ? coarser : finer) = middle;
  }
  return grows ? finer : coarser;
}

// Between a good and a bad one, where a power law through both meets the aim: of the step, or of
// what is predicted for it. Never so near to either that nothing is learnt.
double StepSearch::between(double aim) const {
  const double span = std::log(bad_.outcome) - logOf(good_.outcome);
  const double along = (logOf(aim) - logOf(good_.outcome)) / span;
  const double steps = std::log(bad_.step / good_.step);
  const auto at = [&](double part) {
    return good_.step * std::exp(std::clamp(part, 0.1, 0.9) * steps);
  };
  if (!problem_.predict)
    return at(along);
  const double predicted = problem_.predict(good_.step) *
                           std::pow(problem_.predict(bad_.step) / problem_.predict(good_.step),
                                    std::clamp(along, 0.0, 1.0));
  const double step =
      problem_.stepOf(predicted, std::min(good_.step, bad_.step), std::max(good_.step, bad_.step));
  return at(std::log(step / good_.step) / steps);
}

double StepSearch::proposal() const {
  const double aim =
      0.5 * (problem_.target + std::max(problem_.closeEnough, 0.9 * problem_.target));
  double next = 0;
  if (good_.known && bad_.known) {
    next = between(aim);
  } else {
    const Try& only = good_.known ? good_ : bad_;
    // Where the outcome hardly depends on the step, or goes up and down with it just beside the
    // target, steps of its own size would never arrive: each try goes further.
    constexpr double kMinMoveAtThird = 0.01;
    const double least = tries_ < 3 ? 1 : 1 + kMinMoveAtThird * std::ldexp(1.0, tries_ - 3);
    const double wanted = aim / std::max(only.outcome, 1e-300);
    double move = std::pow(wanted, problem_.grows ? tries_ : -tries_);
    if (problem_.predict) {
      const double step = problem_.stepOf(problem_.predict(only.step) * std::pow(wanted, tries_),
                                          problem_.finest, problem_.coarsest);
      move = step / only.step;
    }
    const bool coarser = problem_.grows == good_.known;
    move = coarser ? std::max(move, least) : std::min(move, 1 / least);
    const double most = problem_.predict ? kGreatestMove * kGreatestMove : kGreatestMove;
    next = only.step * std::clamp(move, 1 / most, most);
  }
  return std::clamp(next, problem_.finest, problem_.coarsest);
}

}  // namespace volute
