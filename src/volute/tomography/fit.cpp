// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/fit.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "volute/tomography/diagnostics.hpp"
#include "volute/tomography/reduced_view.hpp"
#include "volute/tomography/temporal_prior.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

constexpr unsigned kHeldOutOf = 20;   // one row in so many
constexpr double kBright = 0.7;       // of the typical value
constexpr std::size_t kMinViews = 4;  // of which one can be held out
constexpr std::size_t kFewViews = 5;  // of which few are left to predict it

std::unique_ptr<Prior> makeSpatialPrior(const FitSetup& setup, const PriorStrength& prior) {
  const TomographyOptions& options = setup.options;
  const auto& support = setup.problem.support;
  const double strength = prior.lambda * setup.largest;
  switch (prior.regularization) {
    case Regularization::kTv:
      return makeTotalVariation(support, strength,
                                {prior.sparsity * strength, kBright * setup.typical},
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

std::unique_ptr<Prior> makePrior(const FitSetup& setup, const PriorStrength& prior) {
  auto spatial = makeSpatialPrior(setup, prior);
  if (setup.expected.empty())
    return spatial;
  return makeTemporalPrior(std::move(spatial), setup.options.temporal * setup.largest,
                           {setup.expected.begin(), setup.expected.end()});
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

double usualSparsity(std::size_t views) {
  constexpr double kUsual = 2.5;
  return views < kMinViews ? 0 : kUsual;
}

double typicalValue(const LeastSquares& data, double largest) {
  std::vector<float> gradient(4 * data.unknowns());
  data.gradient(std::vector<float>(4 * data.rows()), gradient);
  float most = 0;
  for (float value : gradient) most = std::max(most, -value);
  return largest > 0 ? most / largest : 0;
}

std::vector<std::size_t> viewsToHoldOut(std::span<const TomographyView> views, const Vec3& centre,
                                        std::size_t fewest) {
  if (views.size() < fewest)
    return {};
  std::vector<std::pair<double, std::size_t>> nearest;
  for (std::size_t v = 0; v < views.size(); ++v) {
    double angle = 90;
    for (std::size_t other = 0; other < views.size(); ++other) {
      if (other != v)
        angle = std::min(angle, angleBetween(views[v].camera, views[other].camera, centre));
    }
    nearest.emplace_back(angle, v);
  }
  std::ranges::sort(nearest);
  std::vector<std::size_t> chosen{nearest[nearest.size() / 2].second};
  if (views.size() <= kFewViews)
    chosen.push_back(nearest[nearest.size() / 2 - 1].second);
  return chosen;
}

int pixelsTogether(std::span<const TomographyView> views, const VolumeGeometry& geometry,
                   const TomographyOptions& options) {
  constexpr double kPixels = 1.8;
  if (options.solver != TomographySolver::kApg || options.raysPerPixel == 1)
    return 1;
  double narrowest = 64;
  for (const TomographyView& view : views) {
    if (view.camera.isOrthographic() || !view.atLeast.empty())
      return 1;
    const double pixels = std::min(view.camera.width(), view.camera.height());
    narrowest = std::min({narrowest, voxelInPixels(view.camera, geometry), pixels / 8 * kPixels});
  }
  return std::max(1, static_cast<int>(narrowest / kPixels));
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
      const double difference = data.misfit(4 * row + c, &projected[4 * row]);
      error += data.squaredWeight[row] * difference * difference;
      light += data.squaredWeight[row] * measured * measured;
    }
  }
  return light > 0 ? std::sqrt(error / light) : 0;
}

Result<Fit> runFit(const FitSetup& setup, const LeastSquares& data, const PriorStrength& prior,
                   std::vector<float> start, const StopRule& stop) {
  Fit fit;
  fit.prior = prior;
  fit.unknowns = std::move(start);
  const auto made = makePrior(setup, prior);
  Watcher watcher(setup, data, stop, fit);
  fit.iterations = solve(setup, data, *made, stop.iterations, fit.unknowns, std::ref(watcher));
  if (setup.progress.cancelled())
    return fail(ErrorCode::kCancelled, "Stopped");
  if (!watcher.best().empty()) {
    fit.unknowns = watcher.best();
    fit.projected = watcher.bestProjected();
  }
  return fit;
}

namespace {

/// Rows that are held out together, and what is left.
struct Fold {
  std::vector<std::uint8_t> heldOut;
  LeastSquares rest;
};

/// Whole cameras, those whose nearest neighbour is as far as is usual first; or pixels.
std::vector<Fold> foldsOf(const FitSetup& setup) {
  const FrameProblem& problem = setup.problem;
  const auto& views = setup.views;
  std::vector<Fold> folds;
  if (views.size() < kMinViews) {
    folds.push_back({heldOutRows(problem.data.rows(), setup.options.seed), {}});
  } else {
    const auto chosen = viewsToHoldOut(views, problem.support->geometry().bounds.centre());
    for (const std::size_t view : chosen) {
      Fold& fold = folds.emplace_back();
      for (const PixelRow& row : problem.projector->pixels())
        fold.heldOut.push_back(static_cast<std::size_t>(row.view) == view ? 1 : 0);
    }
  }
  for (Fold& fold : folds) fold.rest = withoutRows(problem.data, fold.heldOut);
  return folds;
}

/// Tries priors on the folds.
class PriorSearch {
 public:
  PriorSearch(const FitSetup& setup, const std::vector<float>& start, int iterationsAfter)
      : setup_(setup), start_(start), folds_(foldsOf(setup)), after_(iterationsAfter) {}

  Status tryTotalVariation(double sparsity) {
    constexpr double kStrongest = 1e-2, kWeakest = 1e-6, kFactor = 0.31622776601683794;
    constexpr int kIterations = 40;
    std::vector<std::vector<float>> volumes(folds_.size(), start_);
    StrengthSearch search;
    double least = 0;
    for (double share = kStrongest; share >= 0.99 * kWeakest; share *= kFactor) {
      double squares = 0;
      for (std::size_t f = 0; f < folds_.size(); ++f) {
        VOLUTE_ASSIGN(Fit fit,
                      run(folds_[f], {Regularization::kTv, share * setup_.typical, sparsity},
                          std::move(volumes[f]), {kIterations, 0, {}, 2 * kSettled}));
        const double error = heldOutError(setup_.problem.data, folds_[f].heldOut, fit.projected);
        squares += error * error;
        volumes[f] = std::move(fit.unknowns);
      }
      const double error = std::sqrt(squares / static_cast<double>(folds_.size()));
      if (least == 0 || error < least)
        least = error;
      if (!search.add(share, error))
        break;
      reached_ = std::move(volumes[0]);
      volumes[0] = reached_;
    }
    // One or two cameras tell little of how light is spread over dark voxels: of fire, volumes with
    // sparsity come nearer to the truth though they predict a camera 3 to 9 % worse; of smoke,
    // where sparsity is wrong, they predict it worse by a quarter and more.
    keep({Regularization::kTv, search.chosen(), sparsity, 0}, least, std::move(reached_), kMuch);
    return {};
  }

  Status tryPlainIterations() {
    constexpr int kIterations = 60, kPatience = 12;
    double squares = 0;
    int iterations = 0;
    for (const Fold& fold : folds_) {
      VOLUTE_ASSIGN(const Fit fit, run(fold, {}, std::vector<float>(start_.size()),
                                       {kIterations, 0, fold.heldOut, 0}));
      squares += fit.heldOutError * fit.heldOutError;
      iterations += fit.iterations - (fit.stoppedBy == "held-out pixels" ? kPatience : 0);
    }
    const auto folds = static_cast<int>(folds_.size());
    // One camera more tells more: a few iterations less would be lost rather than a few too many.
    keep({Regularization::kNone, 0, 0, std::max(1, (iterations + folds - 1) / folds)},
         std::sqrt(squares / folds), {});
    return {};
  }

  const TomographyChoice& choice() const { return choice_; }

  double error() const { return error_; }

  int iterations() const { return searched_; }

  /// Where the fits with the choice ended: a start for the last fit.
  std::vector<float> takeStart() { return std::move(best_); }

 private:
  static constexpr double kClearly = 0.98, kMuch = 0.9;

  Result<Fit> run(const Fold& fold, const PriorStrength& prior, std::vector<float> start,
                  StopRule stop) {
    stop.before = searched_;
    stop.all = std::max(2 * searched_, 200) + after_;
    VOLUTE_ASSIGN(Fit fit, runFit(setup_, fold.rest, prior, std::move(start), stop));
    searched_ += fit.iterations;
    return fit;
  }

  /// Takes a candidate that is clearly better than those before.
  void keep(const TomographyChoice& candidate, double error, std::vector<float> end,
            double clearly = kClearly) {
    if (error_ > 0 && !(error < clearly * error_))
      return;
    choice_ = candidate;
    error_ = error;
    best_ = std::move(end);
  }

  const FitSetup& setup_;
  const std::vector<float>& start_;
  std::vector<Fold> folds_;
  int after_ = 0, searched_ = 0;
  TomographyChoice choice_;
  double error_ = 0;
  std::vector<float> best_, reached_;
};

}  // namespace

Result<Fit> chooseFit(const FitSetup& setup, std::vector<float> start) {
  constexpr int kFinalIterations = 600;
  const TomographyOptions& options = setup.options;
  const int most = options.iterations.value_or(kFinalIterations);
  TomographyChoice choice;
  double error = 0;
  int searched = 0;
  if (options.choice) {
    choice = *options.choice;
  } else {
    PriorSearch search(setup, start, most);
    const double sparsity = options.sparsity.value_or(usualSparsity(setup.views.size()));
    // The first is taken unless the second predicts much better: of few views that without
    // sparsity, which of thin flames is nearer to the truth, and of others hardly further.
    std::vector<double> tried{sparsity};
    if (!options.sparsity && sparsity > 0)
      tried.insert(setup.views.size() <= kFewViews ? tried.begin() : tried.end(), 0);
    for (const double one : tried) VOLUTE_TRY(search.tryTotalVariation(one));
    if (options.regularization == Regularization::kAuto && !options.iterations)
      VOLUTE_TRY(search.tryPlainIterations());
    choice = search.choice();
    error = search.error();
    searched = search.iterations();
    start = search.takeStart();
  }
  const bool plain = choice.regularization == Regularization::kNone;
  // What plain iterations leave out depends on where they begin.
  if (plain || start.empty())
    start.assign(4 * setup.problem.data.unknowns(), 0);
  if (plain && !setup.expected.empty())
    start.assign(setup.expected.begin(), setup.expected.end());
  const PriorStrength prior{choice.regularization, choice.strength * setup.typical,
                            choice.sparsity};
  const StopRule stop{plain ? choice.iterations : most,
                      0,
                      {},
                      plain || options.iterations ? 0 : 2 * kSettled,
                      searched,
                      searched + most};
  VOLUTE_ASSIGN(Fit fit, runFit(setup, setup.problem.data, prior, std::move(start), stop));
  if (plain)
    fit.stoppedBy = "held-out pixels";
  fit.choice = choice;
  fit.heldOutError = error;
  fit.searchIterations = searched;
  return fit;
}

}  // namespace volute
