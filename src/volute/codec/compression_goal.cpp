// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compression_goal.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;

}  // namespace

std::string_view nameOf(ErrorTarget::Kind kind) {
  switch (kind) {
    case Kind::kRms:
      return "support-rms";
    case Kind::kLook:
      return "look";
    case Kind::kRmsOverAll:
      return "rms";
    case Kind::kPsnr:
      return "psnr";
    case Kind::kRatio:
      return "ratio";
    case Kind::kSize:
      return "size";
    case Kind::kMaxError:
      return "max-error";
  }
  return "";
}

bool CompressionGoal::isSize() const {
  return target_.kind == Kind::kRatio || target_.kind == Kind::kSize;
}

// What rounding adds is independent of what the codec is off, where that is more than a part of a
// rounding step; where it is less, the values that come back are those that went in. So one half of
// the goal will always do.
void CompressionGoal::leaveRoomForHalves(double rounding, double offset) {
  const auto left = [&](double rms) {
    const double relative = this->relative(rounding);
    return std::sqrt(std::max(rms * rms / 4, rms * rms - relative * relative));
  };
  if (target_.isOverSupport() || target_.kind == Kind::kRmsOverAll)
    goal_ = left(goal_);
  else if (target_.kind == Kind::kPsnr)
    goal_ = -20 * std::log10(left(std::pow(10, -goal_ / 20)));
  else if (target_.kind == Kind::kMaxError)
    goal_ = std::max(goal_ / 2, goal_ - std::ldexp(greatest_ + std::abs(offset), -11));
}

Status CompressionGoal::leaveRoomFor(double rounding) {
  if (rounding == 0 || isSize())
    return {};
  const bool decibels = target_.kind == Kind::kPsnr;
  const double asked = decibels ? std::pow(10, -goal_ / 20) : goal_;
  const double taken = isMaxError() ? rounding : relative(rounding);
  const double left = std::nextafter(asked - taken, 0.0);
  if (!(left > 0)) {
    // A value that comes back as the float beside its own is two such roundings away from it.
    const double possible = 3.1 * taken;
    return fail(ErrorCode::kUnsupported,
                "a target of {} = {} cannot be met: the values lie up to {:.3g} from the nearest "
                "float32, in which they are kept; ask for {} = {:.2g}, or subtract what all have "
                "in common first",
                nameOf(target_.kind), target_.value, rounding, nameOf(target_.kind),
                decibels ? std::floor(-20 * std::log10(possible)) : possible);
  }
  goal_ = decibels ? -20 * std::log10(left) : left;
  return {};
}

StepSearch::Problem CompressionGoal::problem() const {
  StepSearch::Problem problem;
  // Coarser than the greatest orthonormal coefficient of a block, 4^4 times the greatest value,
  // gives nothing but zeros; finer than a float's rounding gains nothing.
  problem.coarsest = greatest_ > 0 ? std::ldexp(greatest_, 10) : 1;
  problem.finest = own_ > 0 ? std::ldexp(own_, 10 - 31) : std::ldexp(problem.coarsest, -31);
  if (constant_)
    problem.finest = problem.coarsest = greatest_ > 0 ? std::ldexp(greatest_, -12) : 1;
  const double value = goal_;
  switch (target_.kind) {
    case Kind::kRms:
    case Kind::kLook:
    case Kind::kRmsOverAll:
      problem.target = value;
      break;
    case Kind::kPsnr:
      problem.target = std::pow(10, -value / 20);
      break;
    case Kind::kRatio:
      problem.target = std::floor(static_cast<double>(rawBytes_) / value);
      break;
    case Kind::kSize:
      problem.target = value;
      break;
    case Kind::kMaxError:
      break;  // not searched by the error
  }
  problem.grows = !isSize();
  if (isSize() && model_ != nullptr)
    problem.predict = [model = model_](double step) { return model->bits(step) / 8; };
  problem.closeEnough = 0.99 * problem.target;
  return problem;
}

double CompressionGoal::firstStep() const {
  constexpr double kMaxErrorSteps = 1.5;
  if (target_.kind == Kind::kMaxError)
    return within(kMaxErrorSteps * goal_);
  const StepSearch::Problem problem = this->problem();
  if (isSize())
    return problem.stepOf(problem.target, problem.finest, problem.coarsest);
  const double absolute = problem.target / relative(1);
  return within(model_->stepFor(absolute * absolute * values_));
}

double CompressionGoal::betterStep(double step, double outcome, double aim,
                                   double errorPower) const {
  const StepSearch::Problem problem = this->problem();
  const double wanted = aim * problem.target / std::max(outcome, 1e-30);
  if (isSize())
    return problem.stepOf(problem.predict(step) * wanted, problem.finest, problem.coarsest);
  constexpr double kMaxChange = 6;
  const double change = std::pow(wanted, errorPower);
  return within(step * std::clamp(change, 1 / kMaxChange, kMaxChange));
}

double CompressionGoal::within(double step) const {
  const StepSearch::Problem limits = problem();
  return std::clamp(step, limits.finest, limits.coarsest);
}

}  // namespace volute
