// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/fit.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/tomography/diagnostics.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

constexpr unsigned kHeldOutOf = 20;  // one row in so many
constexpr double kBright = 0.7;      // of the typical value

std::unique_ptr<Prior> makePrior(const FitSetup& setup, Regularization regularization,
                                 double lambda) {
  const TomographyOptions& options = setup.options;
  const auto& support = setup.problem.support;
  const double strength = lambda * setup.largest;
  switch (regularization) {
    case Regularization::kTv:
      return makeTotalVariation(support, strength,
                                {options.sparsity * strength, kBright * setup.typical},
                                options.nonNegative);
    case Regularization::kSmooth:
      return makeSmoothness(support, strength, options.nonNegative);
    case Regularization::kWavelet:
      return makeWaveletSparsity(support, options.wavelet, strength, options.nonNegative,
                                 options.seed);
    default:
      return makeNoPrior(options.nonNegative);
  }
}

/// Follows a solver: reports, cancels, and stops it by the rule.
class Watcher {
 public:
  Watcher(const FitSetup& setup, const LeastSquares& data, const StopRule& stop, Fit& fit)
      : setup_(setup),
        data_(data),
        stop_(stop),
        fit_(fit),
        light_(data.squaredResidual(std::vector<float>(data.measured.size()))) {}

  bool operator()(int iteration, std::span<const float> unknowns,
                  std::span<const float> projected) {
    const double residual = std::sqrt(data_.squaredResidual(projected) / std::max(light_, 1e-300));
    setup_.progress.detail(fmt::format("residual {:.3f}", residual));
    setup_.progress.report("solving", stop_.before + iteration,
                           std::max(stop_.all, stop_.before + stop_.iterations));
    if (setup_.progress.cancelled())
      return false;
    fit_.projected.assign(projected.begin(), projected.end());
    if (stop_.squaredResidual > 0 && data_.squaredResidual(projected) <= stop_.squaredResidual)
      return because("discrepancy");
    if (!stop_.heldOut.empty() && rises(unknowns, projected))
      return because("held-out pixels");
    if (stop_.settled > 0 && settled(iteration, unknowns))
      return because("converged");
    return true;
  }

  /// The best unknowns, when the last are not.
  const std::vector<float>& best() const { return best_; }

  const std::vector<float>& bestProjected() const { return bestProjected_; }

 private:
  bool because(std::string_view reason) {
    fit_.stoppedBy = reason;
    return false;
  }

  /// Keeps the best so far; true when the last kPatience were no better.
  bool rises(std::span<const float> unknowns, std::span<const float> projected) {
    constexpr int kPatience = 12;
    const double error = heldOutError(setup_.problem.data, stop_.heldOut, projected);
    if (best_.empty() || error < fit_.heldOutError) {
      fit_.heldOutError = error;
      best_.assign(unknowns.begin(), unknowns.end());
      bestProjected_.assign(projected.begin(), projected.end());
      waited_ = 0;
      return false;
    }
    return ++waited_ >= kPatience;
  }

  /// Compares with kEvery iterations before.
  bool settled(int iteration, std::span<const float> unknowns) {
    constexpr int kEvery = 10;
    if (iteration % kEvery != 0)
      return false;
    bool same = false;
    if (before_.size() == unknowns.size()) {
      const double change = sumElements(unknowns.size(), [&](std::size_t i) {
        const double d = static_cast<double>(unknowns[i]) - before_[i];
        return d * d;
      });
      same = change <= stop_.settled * stop_.settled * dot(unknowns, unknowns);
    }
    before_.assign(unknowns.begin(), unknowns.end());
    return same;
  }

  const FitSetup& setup_;
  const LeastSquares& data_;
  const StopRule& stop_;
  Fit& fit_;
  double light_;  // |W measured|^2
  std::vector<float> best_, bestProjected_, before_;
  int waited_ = 0;
};

/// Strengths from strong to weak, and how the held-out error falls with them.
class StrengthSearch {
 public:
  /// Adds the error of a strength; whether a weaker one may pay.
  bool add(double share, double error) {
    if (!error_) {
      chosen_ = share;
    } else {
      const double slope = std::log(error / *error_), middle = std::sqrt(share * share_);
      const bool pays = slope <= kSlope;
      if (pays)
        chosen_ = share;
      else if (slope_)
        chosen_ = middle_ * std::pow(middle / middle_, (kSlope - *slope_) / (slope - *slope_));
      if (!pays)
        return false;
      slope_ = slope;
      middle_ = middle;
    }
    share_ = share;
    error_ = error;
    return true;
  }

  /// Where, between the middles of two steps, a weaker prior ceases to pay; the weakest if it
  /// always did.
  double chosen() const { return chosen_; }

 private:
  // Of the logarithm of the error a step. What a weaker prior gains without noise comes from more
  // iterations, not from the prior.
  static constexpr double kSlope = -0.0175;

  std::optional<double> error_, slope_;
  double share_ = 0, middle_ = 0, chosen_ = 0;
};

int solve(const FitSetup& setup, const LeastSquares& data, Prior& prior, int iterations,
          std::vector<float>& unknowns, const SolverWatch& watch) {
  const bool nonNegative = setup.options.nonNegative;
  switch (setup.options.solver) {
    case TomographySolver::kMlem:
      return solveMlem(data, iterations, unknowns, watch);
    case TomographySolver::kSirt:
      return solveSirt(data, nonNegative, iterations, unknowns, watch);
    case TomographySolver::kCgls:
      return solveCgls(data, nonNegative, iterations, unknowns, watch);
    default:
      return solveApg(data, setup.largest, prior, iterations, unknowns, watch);
  }
}

}  // namespace

double typicalValue(const LeastSquares& data, double largest) {
  std::vector<float> gradient(4 * data.unknowns());
  data.gradient(std::vector<float>(4 * data.rows()), gradient);
  float most = 0;
  for (float value : gradient) most = std::max(most, -value);
  return largest > 0 ? most / largest : 0;
}

std::vector<std::uint8_t> heldOutRows(std::size_t rows, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> heldOut(rows);
  for (auto& row : heldOut) row = random() % kHeldOutOf == 0 ? 1 : 0;
  return heldOut;
}

LeastSquares withoutRows(const LeastSquares& data, std::span<const std::uint8_t> heldOut) {
  LeastSquares rest = data;
  for (std::size_t row = 0; row < heldOut.size(); ++row) {
    if (heldOut[row])
      rest.squaredWeight[row] = 0;
  }
  return rest;
}

double heldOutError(const LeastSquares& data, std::span<const std::uint8_t> heldOut,
                    std::span<const float> projected) {
  double error = 0, light = 0;
  for (std::size_t row = 0; row < heldOut.size(); ++row) {
    if (!heldOut[row])
      continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double measured = data.measured[4 * row + c];
      const double difference = data.misfit(4 * row + c, projected[4 * row + c]);
      error += data.squaredWeight[row] * difference * difference;
      light += data.squaredWeight[row] * measured * measured;
    }
  }
  return light > 0 ? std::sqrt(error / light) : 0;
}

Result<Fit> runFit(const FitSetup& setup, const LeastSquares& data, Regularization regularization,
                   double lambda, std::vector<float> start, const StopRule& stop) {
  Fit fit;
  fit.regularization = regularization;
  fit.lambda = lambda;
  fit.unknowns = std::move(start);
  const auto prior = makePrior(setup, regularization, lambda);
  Watcher watcher(setup, data, stop, fit);
  fit.iterations = solve(setup, data, *prior, stop.iterations, fit.unknowns, std::ref(watcher));
  if (setup.progress.cancelled())
    return fail(ErrorCode::kCancelled, "Stopped");
  if (!watcher.best().empty()) {
    fit.unknowns = watcher.best();
    fit.projected = watcher.bestProjected();
  }
  return fit;
}

std::vector<std::uint8_t> heldOutView(const FrameProblem& problem,
                                      std::span<const TomographyView> views) {
  const Vec3 centre = problem.support->geometry().bounds.centre();
  std::vector<std::pair<double, int>> nearest;
  for (std::size_t v = 0; v < views.size(); ++v) {
    double angle = 90;
    for (std::size_t other = 0; other < views.size(); ++other) {
      if (other != v)
        angle = std::min(angle, angleBetween(views[v].camera, views[other].camera, centre));
    }
    nearest.emplace_back(angle, static_cast<int>(v));
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::ranges::nth_element(nearest, middle);
  std::vector<std::uint8_t> heldOut;
  for (const PixelRow& row : problem.projector->pixels())
    heldOut.push_back(row.view == middle->second ? 1 : 0);
  return heldOut;
}

Result<Fit> chooseFit(const FitSetup& setup, std::vector<float> start) {
  constexpr double kStrongest = 1e-2, kWeakest = 1e-6, kFactor = 0.31622776601683794;
  constexpr int kSearches = 9;  // from the strongest to the weakest
  constexpr int kSearchIterations = 40, kFinalIterations = 600;
  constexpr std::size_t kLeastViews = 4;
  const LeastSquares& data = setup.problem.data;
  int searched = 0;
  const auto heldOut = setup.views.size() >= kLeastViews
                           ? heldOutView(setup.problem, setup.views)
                           : heldOutRows(data.rows(), setup.options.seed);
  const LeastSquares rest = withoutRows(data, heldOut);
  const std::optional<int>& wanted = setup.options.iterations;
  const int most = wanted.value_or(kFinalIterations);
  const int all = kSearches * kSearchIterations + most;
  StrengthSearch search;
  double error = 0;
  int before = 0;
  for (double share = kStrongest; share >= 0.99 * kWeakest; share *= kFactor) {
    VOLUTE_ASSIGN(Fit fit, runFit(setup, rest, Regularization::kTv, share * setup.typical, start,
                                  {kSearchIterations, 0, {}, 2 * kSettled, before, all}));
    before += kSearchIterations;
    fit.heldOutError = heldOutError(data, heldOut, fit.projected);
    if (searched += fit.iterations; !search.add(share, fit.heldOutError))
      break;
    error = fit.heldOutError;
    start = std::move(fit.unknowns);
  }
  const StopRule stop{most, 0, {}, wanted ? 0 : kSettled, kSearches * kSearchIterations, all};
  VOLUTE_ASSIGN(Fit fit, runFit(setup, data, Regularization::kTv, search.chosen() * setup.typical,
                                std::move(start), stop));
  fit.heldOutError = error;
  fit.searchIterations = searched;
  return fit;
}

}  // namespace volute
