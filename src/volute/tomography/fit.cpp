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

  /// Keeps the best so far; true when the last kPatience were no better, or hardly.
  bool rises(std::span<const float> unknowns, std::span<const float> projected) {
    constexpr int kPatience = 12;
    const double error = heldOutError(setup_.problem.data, stop_.heldOut, projected);
    if (best_.empty() || error < fit_.heldOutError) {
      fit_.heldOutError = error;
      best_.assign(unknowns.begin(), unknowns.end());
      bestProjected_.assign(projected.begin(), projected.end());
    }
    if (since_ == 0 || error < (1 - stop_.gain) * since_) {
      since_ = error;
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
  double since_ = 0;  // the error that the next has to fall below
  int waited_ = 0;
};

/// What a fit leaves of the pictures that it is fitted to, of their energy.
struct Residual {
  double whole = 0;
  double alike = 0;  ///< of it what neighbouring pixels have in common, which noise has not
};

Residual residualOf(const FrameProblem& problem, const LeastSquares& data,
                    std::span<const float> projected) {
  const auto pixels = problem.projector->pixels();
  double together = 0, each = 0;
  for (std::size_t row = 0; row + 1 < pixels.size(); ++row) {
    const double weight = data.squaredWeight[row], next = data.squaredWeight[row + 1];
    if (weight == 0 || next == 0 || pixels[row + 1].view != pixels[row].view ||
        pixels[row + 1].pixel != pixels[row].pixel + 1)
      continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = data.misfit(4 * row + c, &projected[4 * row]);
      const double b = data.misfit(4 * (row + 1) + c, &projected[4 * (row + 1)]);
      together += std::sqrt(weight * next) * a * b;
      each += 0.5 * (weight * a * a + next * b * b);
    }
  }
  const double light = data.squaredResidual(std::vector<float>(projected.size()));
  const double whole = light > 0 ? data.squaredResidual(projected) / light : 0;
  return {whole, each > 0 ? whole * together / each : 0};
}

/// Strengths from weak to strong: how well they predict what is held out, and what they leave of
/// the pictures that are fitted. Where that is noise, the volume that predicts another camera best
/// is near the truth; where it is not, the prior leaves mistakes of its own there, and of exact
/// pictures even one that predicts no worse takes detail from the volume.
class StrengthSearch {
 public:
  /// @param without  what hardly any prior leaves
  explicit StrengthSearch(const Residual& without) : without_(without) {}

  /// Adds a strength; whether a stronger one may be better.
  bool add(double share, double error, const Residual& residual) {
    if (tried_.empty() && residual.whole < without_.whole)
      without_ = residual;
    without_.whole = std::min(without_.whole, residual.whole);
    tried_.push_back({share, error, std::max(0.0, residual.alike - without_.alike)});
    return cost(tried_.back()) < cost(*best()) + kRisen;
  }

  bool isLastTheBest() const { return best() + 1 == tried_.end(); }

  /// The held-out error of the best.
  double error() const { return best()->error; }

  /// The best, by a parabola through it and its neighbours.
  double chosen() const {
    const auto at = best();
    if (at == tried_.begin() || at + 1 == tried_.end())
      return at->share;
    const double weaker = cost(*(at - 1)) - cost(*at), stronger = cost(*(at + 1)) - cost(*at);
    const double sum = weaker + stronger;
    const double step = sum > 0 ? (weaker - stronger) / (2 * sum) : 0;  // within half of one
    return at->share * std::pow((at + 1)->share / at->share, step);
  }

 private:
  static constexpr double kRisen = 0.1;
  static constexpr double kBias = 0.03;  // of as much as hardly any prior leaves

  struct Tried {
    double share, error;
    double bias;  ///< what the prior adds to what is alike in the residual
  };

  double cost(const Tried& one) const {
    return std::log(std::max(one.error, 1e-30)) +
           kBias * one.bias / std::max(without_.whole, 1e-30);
  }

  std::vector<Tried>::const_iterator best() const {
    return std::ranges::min_element(tried_, {}, [this](const Tried& one) { return cost(one); });
  }

  std::vector<Tried> tried_;
  Residual without_;
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

  /// From weak to strong: a volume that has the detail of the pictures soon loses what a stronger
  /// prior does not like, while one without needs many iterations for it.
  Status tryTotalVariation(double sparsity) {
    constexpr double kWeakest = 3e-6, kStrongest = 1e-2, kFactor = 3.1622776601683795;
    constexpr int kIterations = 40;
    std::vector<std::vector<float>> volumes;
    VOLUTE_ASSIGN(const Residual without, fitHardlyWithPrior(volumes));
    StrengthSearch search(without);
    std::vector<float> reached;
    for (double share = kWeakest; share <= 1.01 * kStrongest; share *= kFactor) {
      double squares = 0;
      Residual residual;
      for (std::size_t f = 0; f < folds_.size(); ++f) {
        VOLUTE_ASSIGN(Fit fit,
                      run(folds_[f], {Regularization::kTv, share * setup_.typical, sparsity},
                          std::move(volumes[f]), {kIterations, 0, {}, 2 * kSettled}));
        const double error = heldOutError(setup_.problem.data, folds_[f].heldOut, fit.projected);
        squares += error * error / static_cast<double>(folds_.size());
        addShare(residual, folds_[f], fit);
        volumes[f] = std::move(fit.unknowns);
      }
      const bool mayGoOn = search.add(share, std::sqrt(squares), residual);
      if (search.isLastTheBest())
        reached = volumes[0];
      if (!mayGoOn)
        break;
    }
    keep({Regularization::kTv, search.chosen(), sparsity, 0}, search.error(), std::move(reached));
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
  static constexpr double kClearly = 0.98;

  /// Until the held-out error hardly falls.
  Result<Residual> fitHardlyWithPrior(std::vector<std::vector<float>>& volumes) {
    constexpr double kStrength = 1e-6, kGain = 0.01;
    constexpr int kIterations = 300;
    Residual residual;
    for (const Fold& fold : folds_) {
      VOLUTE_ASSIGN(Fit fit, run(fold, {Regularization::kTv, kStrength * setup_.typical, 0}, start_,
                                 {kIterations, 0, fold.heldOut, 2 * kSettled, 0, 0, kGain}));
      addShare(residual, fold, fit);
      volumes.push_back(std::move(fit.unknowns));
    }
    return residual;
  }

  /// Adds what the fit of a fold leaves to the mean over the folds.
  void addShare(Residual& mean, const Fold& fold, const Fit& fit) const {
    const Residual one = residualOf(setup_.problem, fold.rest, fit.projected);
    const auto folds = static_cast<double>(folds_.size());
    mean.whole += one.whole / folds;
    mean.alike += one.alike / folds;
  }

  Result<Fit> run(const Fold& fold, const PriorStrength& prior, std::vector<float> start,
                  StopRule stop) {
    stop.before = searched_;
    stop.all = std::max(2 * searched_, 200) + after_;
    VOLUTE_ASSIGN(Fit fit, runFit(setup_, fold.rest, prior, std::move(start), stop));
    searched_ += fit.iterations;
    return fit;
  }

  /// Takes a candidate that is clearly better than those before.
  void keep(const TomographyChoice& candidate, double error, std::vector<float> end) {
    if (error_ > 0 && !(error < kClearly * error_))
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
  std::vector<float> best_;
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
    VOLUTE_TRY(search.tryTotalVariation(options.sparsity.value_or(0)));
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
