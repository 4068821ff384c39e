// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/calibration_fit.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "volute/tomography/calibration_level.hpp"

namespace volute {
namespace {

constexpr int kCount = CameraCorrection::kCount;
constexpr int kVolumeSteps = 12;

/// Radiance at which exponents change nothing: a typical one of what shines.
double pivotOf(std::span<const TomographyView> views) {
  double sum = 0, squares = 0;
  for (const TomographyView& view : views) {
    for (std::size_t i = 0; i < view.radiance.pixels.size(); ++i) {
      const double light = view.counts(i / view.radiance.channels) ? view.radiance.pixels[i] : 0;
      sum += std::max(light, 0.0);
      squares += light > 0 ? light * light : 0;
    }
  }
  return sum > 0 ? squares / sum : 1;
}

bool clearlyLess(const std::vector<double>& after, const std::vector<double>& before) {
  constexpr double kClearly = 0.8;
  return std::accumulate(after.begin(), after.end(), 0.0) <
         kClearly * std::accumulate(before.begin(), before.end(), 0.0);
}

/// Poses, focal lengths, principal points and gains; lenses and exponents where `options` say so.
std::vector<FreeParameters> freeParameters(std::size_t views,
                                           const CalibrationFitOptions* extended) {
  std::vector<FreeParameters> free(views);
  for (std::size_t v = 0; v < views; ++v) {
    std::fill_n(free[v].begin(), +CameraCorrection::kLens, true);
    if (extended == nullptr)
      continue;
    free[v][CameraCorrection::kLens] = extended->lens;
    free[v][CameraCorrection::kExponent] =
        !extended->exponent.empty() && extended->exponent[v] != 0;
  }
  return free;
}

/// Takes the median over the cameras of one parameter out, where all of them have it free: another
/// volume explains what they share nearly as well.
void removeMedian(int parameter, std::span<const CameraCorrection> plausible,
                  std::span<CameraCorrection> corrections, std::span<const FreeParameters> free) {
  std::vector<double> shares;
  for (std::size_t v = 0; v < free.size(); ++v) {
    if (!free[v][static_cast<std::size_t>(parameter)])
      return;
    shares.push_back(corrections[v].values[parameter] / plausible[v].values[parameter]);
  }
  std::ranges::sort(shares);
  const double common = 0.5 * (shares[(shares.size() - 1) / 2] + shares[shares.size() / 2]);
  for (std::size_t v = 0; v < free.size(); ++v)
    corrections[v].values[parameter] -= common * plausible[v].values[parameter];
}

/// Leaves of lenses and exponents what is well above its uncertainty and changes the picture.
/// @param free  becomes what is left.
void keepDetermined(std::span<const CameraCorrection> plausible,
                    std::span<const CameraCorrection> uncertain,
                    std::span<CameraCorrection> corrections, std::span<FreeParameters> free) {
  constexpr double kSigmas = 3, kMin = 0.15;  // the latter of what is plausible
  for (std::size_t v = 0; v < free.size(); ++v) {
    for (int p = CameraCorrection::kLens; p < kCount; ++p) {
      double& value = corrections[v].values[p];
      if (free[v][static_cast<std::size_t>(p)] &&
          std::abs(value) >
              std::max(kMin * plausible[v].values[p], kSigmas * uncertain[v].values[p]))
        continue;
      free[v][static_cast<std::size_t>(p)] = false;
      value = 0;
    }
  }
}

double sumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Lenses and exponents from where the fit is. Nothing where they do not pay; the fit's own
/// corrections are then to be set again.
Result<std::optional<std::vector<CameraCorrection>>> extendedCorrections(
    LevelFit& fit, int conjugateSteps, std::span<const CameraCorrection> plausible,
    const CalibrationFitOptions& options) {
  constexpr int kSteps = 4, kMoreSteps = 2;
  constexpr double kPays = 0.93;
  const auto steps = [&](int count) -> Status {
    for (int k = 0; k < count; ++k) {
      fit.weigh();
      VOLUTE_TRY(fit.step(conjugateSteps));
      fit.fitVolume(kVolumeSteps);
    }
    return {};
  };
  // One camera of many, or all together.
  constexpr double kOnePays = 0.75;
  const std::vector<double> before = fit.residuals();
  const auto pays = [&] {
    const std::vector<double> after = fit.residuals();
    bool one = false;
    for (std::size_t v = 0; v < after.size(); ++v) one = one || after[v] < kOnePays * before[v];
    return sumOf(after) < (one ? 1 : kPays) * sumOf(before);
  };
  std::vector<FreeParameters> free = freeParameters(plausible.size(), &options);
  fit.setFree(free);
  VOLUTE_TRY(fit.setCorrections(std::vector<CameraCorrection>(fit.corrections())));
  VOLUTE_TRY(steps(kSteps));
  if (!pays())
    return std::optional<std::vector<CameraCorrection>>();
  std::vector<CameraCorrection> corrections = fit.corrections();
  removeMedian(CameraCorrection::kLens, plausible, corrections, free);
  removeMedian(CameraCorrection::kExponent, plausible, corrections, free);
  keepDetermined(plausible, fit.uncertain(), corrections, free);
  fit.setFree(free);
  VOLUTE_TRY(fit.setCorrections(corrections));
  fit.fitVolume(kVolumeSteps);
  VOLUTE_TRY(steps(kMoreSteps));
  if (!pays())
    return std::optional<std::vector<CameraCorrection>>();
  return std::optional(fit.corrections());
}

bool anyExtended(std::span<const CameraCorrection> corrections) {
  return std::ranges::any_of(corrections, [](const CameraCorrection& one) {
    return one.values.tail<kCount - CameraCorrection::kLens>().squaredNorm() > 0;
  });
}

}  // namespace

Result<CalibrationFit> refineCalibration(std::span<const std::vector<TomographyView>> frames,
                                         const VolumeGeometry& geometry,
                                         const CalibrationFitOptions& options, Progress& progress) {
  if (frames.empty() || frames[0].empty())
    return fail(ErrorCode::kInvalidArgument, "There is no frame to refine with");
  const auto& views = frames[0];
  std::vector<CameraCorrection> plausible, corrections(views.size());
  for (const TomographyView& view : views) {
    if (view.camera.isOrthographic())
      return fail(ErrorCode::kInvalidArgument,
                  "camera {} is orthographic; only pinholes are refined", view.name);
    plausible.push_back(plausibleCorrection(view.camera, geometry.bounds.centre()));
  }
  std::vector<FreeParameters> free = freeParameters(views.size(), nullptr);
  const int coarsest = std::clamp(*std::ranges::min_element(geometry.resolution) / 16, 1, 4);
  std::vector<Level> levels;
  if (coarsest >= 4)
    levels.push_back({4, 6, 12, 8});
  levels.push_back({std::min(coarsest, 2), 5, 12, 3});
  CalibrationFit result;
  result.pivot = pivotOf(views);
  std::unique_ptr<LevelFit> before;
  const auto refineAt = [&](const Level& level) -> Status {
    if (before)
      before->forgetProjector();
    auto fit = std::make_unique<LevelFit>(frames, geometry, level, plausible, free, result.pivot,
                                          options.maxMemory);
    VOLUTE_TRY(fit->begin(corrections, progress));
    if (before)
      fit->startFrom(*before);
    fit->fitVolume(2 * kVolumeSteps);
    for (int k = 0; k < level.steps; ++k) {
      fit->weigh();
      VOLUTE_TRY(fit->step(level.conjugateSteps));
      fit->fitVolume(kVolumeSteps);
    }
    corrections = fit->corrections();
    before = std::move(fit);
    return {};
  };
  for (const Level& level : levels) VOLUTE_TRY(refineAt(level));
  const Level& last = levels.back();
  result.after = before->residuals();
  const auto tellUncertainty = [&] {
    result.uncertain = before->uncertain();
    result.sightError = before->sightError();
  };
  const bool extends =
      options.lens || std::ranges::any_of(options.exponent, [](char one) { return one != 0; });
  tellUncertainty();
  if (extends) {
    const auto extended = extendedCorrections(*before, last.conjugateSteps, plausible, options);
    // A lens may go too far for its inverse: then the rest is kept.
    if (!extended && extended.error().code == ErrorCode::kCancelled)
      return tl::unexpected<Error>(extended.error());
    if (extended && *extended) {
      result.after = before->residuals();
      tellUncertainty();
      corrections = **extended;
      for (std::size_t v = 0; v < views.size(); ++v) {
        for (int p = CameraCorrection::kLens; p < kCount; ++p)
          free[v][static_cast<std::size_t>(p)] = corrections[v].values[p] != 0;
      }
    }
  }
  before->forgetProjector();
  // At the same voxels and as many iterations: coarser voxels explain less of any picture.
  {
    LevelFit asGiven(frames, geometry, last, plausible, free, result.pivot, options.maxMemory);
    VOLUTE_TRY(asGiven.begin(std::vector<CameraCorrection>(views.size()), progress));
    asGiven.fitVolume((2 + last.steps) * kVolumeSteps);
    result.before = asGiven.residuals();
  }
  if (options.fine && coarsest >= 2 && clearlyLess(result.after, result.before)) {
    const auto finest = refineAt({1, 4, 30, 1.5});
    const bool fewerMayDo = frames.size() > LevelFit::kTogether;
    if (!finest && (finest.error().code != ErrorCode::kTooLarge || fewerMayDo))
      return tl::unexpected<Error>(finest.error());
    if (!finest)
      progress.remark(finest.error().message);  // what coarser voxels gave is good, too
    if (finest)
      tellUncertainty();
  }
  std::vector<Camera> given;
  for (const TomographyView& view : views) given.push_back(view.camera);
  VOLUTE_ASSIGN(result.cameras, keepInPlace(given, geometry.bounds, corrections));
  result.lensOrResponse = anyExtended(corrections);
  result.corrections = corrections;
  return result;
}

}  // namespace volute
