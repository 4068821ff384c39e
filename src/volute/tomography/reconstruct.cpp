// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruct.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/tomography/fit.hpp"
#include "volute/tomography/reduced_view.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

constexpr std::array kSolvers{"apg", "mlem", "sirt", "cgls"};
constexpr std::array kRegularizations{"auto", "none", "tv", "smooth", "wavelet"};

template <class Enum, std::size_t N>
std::optional<Enum> byName(const std::array<const char*, N>& names, std::string_view name) {
  for (std::size_t i = 0; i < N; ++i) {
    if (name == names[i])
      return static_cast<Enum>(i);
  }
  return {};
}

/// What is left of the data's squared residual when only noise is: its variance for each channel
/// and pixel, in the weights of the data.
double expectedResidual(const LeastSquares& data, double sigma) {
  double weights = 0;
  for (std::size_t row = 0; row < data.rows(); ++row)
    weights += data.atLeast[row] != 0 ? 0 : data.squaredWeight[row];
  return 3 * sigma * sigma * weights;
}

/// A fit with what the user fixed: no regularization, or one of a given strength.
Result<Fit> fixedFit(const FitSetup& setup, std::vector<float> start) {
  constexpr int kMax = 400;
  constexpr double kUsualLambda = 1e-5;
  const TomographyOptions& options = setup.options;
  const LeastSquares& data = setup.problem.data;
  // With a strength but no kind, it is the kind that would be chosen.
  const bool automatic = options.regularization == Regularization::kAuto;
  const bool apg = options.solver == TomographySolver::kApg;
  const auto regularization = !automatic ? options.regularization
                              : apg      ? Regularization::kTv
                                         : Regularization::kNone;
  const bool penalised = regularization != Regularization::kNone;
  const PriorStrength prior{regularization, penalised ? options.lambda.value_or(kUsualLambda) : 0,
                            options.sparsity.value_or(usualSparsity(setup.views.size()))};
  if (options.iterations)
    return runFit(setup, data, prior, std::move(start), {*options.iterations, 0, {}, 0});
  if (penalised)
    return runFit(setup, data, prior, std::move(start), {kMax, 0, {}, kSettled});
  if (options.noiseSigma && *options.noiseSigma > 0)
    return runFit(setup, data, prior, std::move(start),
                  {kMax, expectedResidual(data, *options.noiseSigma), {}, 0});
  // The held-out pixels tell how long to go on; the last run has them too.
  const auto heldOut = heldOutRows(data.rows(), options.seed);
  VOLUTE_ASSIGN(Fit search, runFit(setup, withoutRows(data, heldOut), prior, start,
                                   {kMax, 0, heldOut, 0, 0, 2 * kMax}));
  const int best = std::max(1, search.iterations - (search.stoppedBy == "iterations" ? 0 : 12));
  VOLUTE_ASSIGN(Fit fit,
                runFit(setup, data, prior, std::move(start), {best, 0, {}, 0, kMax, kMax + best}));
  if (search.stoppedBy == "held-out pixels")
    fit.stoppedBy = search.stoppedBy;
  fit.searchIterations = search.iterations;
  fit.heldOutError = search.heldOutError;
  return fit;
}

bool choosesStrength(const TomographyOptions& options) {
  if (options.solver != TomographySolver::kApg || options.lambda)
    return false;
  return options.regularization == Regularization::kAuto ||
         options.regularization == Regularization::kTv;
}

/// A coarse volume before that which is asked for: how far it is would be told twice.
class CoarseProgress final : public Progress {
 public:
  explicit CoarseProgress(Progress& whole) : whole_(whole) {}

  void report(std::string_view, double, double) override { whole_.report("coarse volume", 0, 0); }

  void remark(const Remark& remark) override { whole_.remark(remark); }

  bool cancelled() const override { return whole_.cancelled(); }

 private:
  Progress& whole_;
};

/// The half of a resolution.
VolumeGeometry halved(VolumeGeometry geometry) {
  for (int& n : geometry.resolution) n = std::max(1, (n + 1) / 2);
  return geometry;
}

/// Values of a coarser volume at the voxel centres of a finer one, interpolated.
std::vector<float> upsampled(std::span<const float> coarse, const VolumeGeometry& from,
                             const VolumeGeometry& to) {
  std::vector<float> fine(3 * to.voxels());
  const auto& n = to.resolution;
  const auto& m = from.resolution;
  parallelFor(static_cast<std::size_t>(n[2]), [&](std::size_t z) {
    for (int y = 0; y < n[1]; ++y) {
      for (int x = 0; x < n[0]; ++x) {
        const std::array<int, 3> at{x, y, static_cast<int>(z)};
        std::array<int, 3> low{}, high{};
        std::array<float, 3> share{};
        for (int a = 0; a < 3; ++a) {
          const double place = (at[a] + 0.5) * m[a] / n[a] - 0.5;
          low[a] = std::clamp(static_cast<int>(std::floor(place)), 0, m[a] - 1);
          high[a] = std::min(low[a] + 1, m[a] - 1);
          share[a] = static_cast<float>(std::clamp(place - low[a], 0.0, 1.0));
        }
        float* out = &fine[3 * ((z * n[1] + y) * n[0] + x)];
        for (int corner = 0; corner < 8; ++corner) {
          float weight = 1;
          std::array<int, 3> voxel{};
          for (int a = 0; a < 3; ++a) {
            const bool up = (corner >> a & 1) != 0;
            voxel[a] = up ? high[a] : low[a];
            weight *= up ? share[a] : 1 - share[a];
          }
          const std::size_t i =
              (static_cast<std::size_t>(voxel[2]) * m[1] + voxel[1]) * m[0] + voxel[0];
          for (int c = 0; c < 3; ++c) out[c] += weight * coarse[3 * i + c];
        }
      }
    }
  });
  return fine;
}

/// reconstruct() of pictures that are as fine as they need be.
Result<Reconstruction> reconstructReduced(std::span<const TomographyView> views,
                                          const VolumeGeometry& geometry,
                                          const TomographyOptions& options,
                                          std::span<const float> warmStart, Progress& progress) {
  std::vector<float> first(warmStart.begin(), warmStart.end());
  if (options.coarseToFine && first.empty() && std::ranges::min(geometry.resolution) >= 8) {
    TomographyOptions coarse = options;
    coarse.coarseToFine = false;
    CoarseProgress quietly(progress);
    VOLUTE_ASSIGN(const Reconstruction start,
                  reconstructReduced(views, halved(geometry), coarse, {}, quietly));
    first = upsampled(start.volume, halved(geometry), geometry);
  }
  VOLUTE_ASSIGN(const FrameProblem problem, makeFrameProblem(views, geometry, options, progress));
  std::vector<float> start = first.empty() ? std::vector<float>(4 * problem.support->size())
                                           : toUnknowns(*problem.support, first);
  const double largest = problem.data.largestEigenvalue();
  if (!(largest > 0))
    return fail(ErrorCode::kInvalidData, "No pixel that counts sees the volume");
  const bool expects = options.temporal > 0 && !warmStart.empty();
  const std::vector<float> expected = expects ? start : std::vector<float>{};
  const FitSetup setup{problem,  views,   options, largest, typicalValue(problem.data, largest),
                       progress, expected};
  VOLUTE_ASSIGN(const Fit fit, choosesStrength(options) ? chooseFit(setup, std::move(start))
                                                        : fixedFit(setup, std::move(start)));
  Reconstruction result;
  result.volume = toVolume(*problem.support, fit.unknowns);
  result.iterations = fit.iterations;
  result.searchIterations = fit.searchIterations;
  result.regularization = fit.prior.regularization;
  result.lambda = fit.prior.lambda;
  result.sparsity = fit.prior.sparsity;
  result.choice = fit.choice;
  result.stoppedBy = fit.stoppedBy == "iterations" && !options.iterations ? "limit" : fit.stoppedBy;
  result.largestEigenvalue = largest;
  result.hullShare = problem.hullShare;
  result.pixels = problem.projector->rows();
  result.residual = residualOfViews(problem, views.size(), fit.projected);
  result.heldOutError = fit.heldOutError;
  return result;
}

}  // namespace

std::optional<TomographySolver> tomographySolverByName(std::string_view name) {
  return byName<TomographySolver>(kSolvers, name);
}

std::string_view tomographySolverName(TomographySolver solver) {
  return kSolvers[static_cast<std::size_t>(solver)];
}

std::optional<Regularization> regularizationByName(std::string_view name) {
  return byName<Regularization>(kRegularizations, name);
}

std::string_view regularizationName(Regularization regularization) {
  return kRegularizations[static_cast<std::size_t>(regularization)];
}

Result<Reconstruction> reconstruct(std::span<const TomographyView> views,
                                   const VolumeGeometry& geometry, const TomographyOptions& options,
                                   std::span<const float> warmStart, Progress& progress) {
  VOLUTE_TRY(checkReconstruction(views, geometry, options));
  if (!warmStart.empty() && warmStart.size() != 3 * geometry.voxels())
    return fail(ErrorCode::kInvalidArgument,
                "The volume to start from has {} values, not the {} of the volume's resolution",
                warmStart.size(), 3 * geometry.voxels());
  if (const int together = pixelsTogether(views, geometry, options); together > 1) {
    std::vector<TomographyView> reduced;
    for (const TomographyView& view : views) reduced.push_back(reducedView(view, together));
    TomographyOptions rest = options;
    if (rest.noiseSigma)
      *rest.noiseSigma /= together;
    return reconstructReduced(reduced, geometry, rest, warmStart, progress);
  }
  return reconstructReduced(views, geometry, options, warmStart, progress);
}

}  // namespace volute
