// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "volute/capture/background_drift.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/match.hpp"
#include "volute/tomography/project.hpp"

namespace volute {
namespace {

constexpr double kStandsOut = 2;          // times the median misfit of the others
constexpr double kMinOutstanding = 0.02;  // below, nobody stands out
constexpr double kGainShare = 0.3;        // of the squared residual that a gain must explain
constexpr double kMinMisfit = 0.04;       // below, nobody misfits
constexpr double kMisfits = 1.5;          // times what the size of the voxels explains
constexpr double kFullHull = 0.9;
constexpr double kNarrow = 15;   // [degrees]
constexpr double kOneSide = 30;  // [degrees], of all cameras

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The views that are still believed, and how they match the volume that was fitted to them.
class Consistency {
 public:
  Consistency(std::span<const TomographyView> views, const VolumeGeometry& geometry,
              const TomographyOptions& options, const Reconstruction& reconstruction,
              Progress& progress)
      : views_(views.begin(), views.end()),
        geometry_(geometry),
        options_(options),
        volume_(reconstruction.volume),
        progress_(progress),
        believed_(views.size()),
        judged_(views.size()) {
    std::iota(believed_.begin(), believed_.end(), 0);
    options_.regularization = reconstruction.regularization;
    options_.lambda = reconstruction.lambda;
    options_.iterations = kIterations;
    options_.coarseToFine = false;
    matches_ = matches(volume_);
  }

  Result<TomographyDiagnosis> diagnosis() {
    TomographyDiagnosis found;
    found.cameras.resize(views_.size());
    for (std::size_t v = 0; v < views_.size(); ++v) {
      found.cameras[v].residual = matches_[v].residual;
      found.cameras[v].explained = matches_[v].fine;
    }
    while (const auto worst = maxOutstanding()) {
      compare(*worst, found.cameras[*worst]);
      VOLUTE_TRY(judge(*worst, found.cameras[*worst]));
    }
    for (const std::size_t v : believed_) {
      if (found.cameras[v].warning.empty())
        compare(v, found.cameras[v]);
    }
    VOLUTE_ASSIGN(const auto warning, misfitOfAll(found.cameras));
    if (warning)
      found.warnings.push_back(*warning);
    return found;
  }

 private:
  static constexpr int kIterations = 60;

  /// One a view, believed or not.
  std::vector<ViewMatch> matches(std::span<const float> volume) const {
    std::vector<ViewMatch> all;
    for (const TomographyView& view : views_) {
      const Image seen =
          projectVolume(volume, geometry_, options_.basis, view.camera, options_.raysPerPixel);
      all.push_back(matchOf(view, seen, geometry_, options_.noiseSigma));
    }
    return all;
  }

  /// The median over the believed views but one, or that one's own where it is alone.
  double others(std::size_t without, double ViewMatch::* field) const {
    std::vector<double> values;
    for (const std::size_t v : believed_) {
      if (v != without)
        values.push_back(matches_[v].*field);
    }
    return values.empty() ? matches_[without].*field : median(std::move(values));
  }

  double ratio(std::size_t v) const {
    return matches_[v].misfit / std::max(others(v, &ViewMatch::misfit), 1e-3);
  }

  bool standsOut(std::size_t v) const {
    return matches_[v].misfit > kMinOutstanding && ratio(v) > kStandsOut;
  }

  /// Of the believed that were not judged yet, while most are believed and there are others to
  /// compare with.
  std::optional<std::size_t> maxOutstanding() const {
    if (believed_.size() < 3 || 2 * believed_.size() <= views_.size())
      return {};
    const auto worst = std::ranges::max_element(
        believed_, {}, [&](std::size_t v) { return standsOut(v) && !judged_[v] ? ratio(v) : 0; });
    if (!standsOut(*worst) || judged_[*worst])
      return {};
    return *worst;
  }

  void compare(std::size_t v, CameraDiagnosis& camera) const {
    camera.residualRatio = ratio(v);
    camera.gain = matches_[v].gain / others(v, &ViewMatch::gain);
  }

  /// A fit to the believed views that goes on from the last one.
  Result<std::vector<float>> refitted(const TomographyOptions& options) const {
    std::vector<TomographyView> chosen;
    for (const std::size_t v : believed_) chosen.push_back(views_[v]);
    VOLUTE_ASSIGN(Reconstruction fit, reconstruct(chosen, geometry_, options, volume_, progress_));
    return std::move(fit.volume);
  }

  static std::string misfitOf(const CameraDiagnosis& camera) {
    return fmt::format(
        "does not fit the others: its residual of {:.3f} is {:.1f} times theirs in what is two "
        "voxels wide and more: another instant, moved, or miscalibrated?",
        camera.residual, camera.residualRatio);
  }

  /// Leaves the camera out, and says why: with another gain it fits as the others do, or not.
  Status judge(std::size_t worst, CameraDiagnosis& camera) {
    // With the gain g a misfit of about |1 - g| would be left of a perfect fit.
    const double explained = std::abs(1 - camera.gain) / matches_[worst].misfit;
    judged_[worst] = 1;
    std::erase(believed_, worst);
    VOLUTE_ASSIGN(volume_, refitted(options_));
    matches_ = matches(volume_);
    camera.gain = matches_[worst].gain;
    if (explained * explained > kGainShare) {
      VOLUTE_ASSIGN(camera.gainDrift, fitsWithGain(worst, camera.gain));
    }
    camera.outOfStep = !camera.gainDrift;
    camera.warning =
        camera.gainDrift
            ? fmt::format(
                  "{:.0f} % too {}: its radiance times {:.3f} fits what the other cameras "
                  "saw; set its gain in the capture",
                  100 * std::abs(1 / camera.gain - 1), camera.gain < 1 ? "bright" : "dark",
                  camera.gain)
            : misfitOf(camera);
    return {};
  }

  /// Whether the camera stands out no more when its pictures are multiplied by `gain`; then it is
  /// believed again, with that gain, and `gain` is made better.
  Result<bool> fitsWithGain(std::size_t camera, double& gain) {
    const TomographyView before = views_[camera];
    const auto without = believed_;
    for (float& value : views_[camera].radiance.pixels) value *= static_cast<float>(gain);
    believed_.insert(std::ranges::lower_bound(believed_, camera), camera);
    VOLUTE_ASSIGN(auto volume, refitted(options_));
    auto last = std::exchange(matches_, matches(volume));
    if (!standsOut(camera)) {
      gain *= matches_[camera].gain / others(camera, &ViewMatch::gain);
      volume_ = std::move(volume);
      return true;
    }
    views_[camera] = before;
    believed_ = without;
    matches_ = std::move(last);
    return false;
  }

  double medianMisfit() const {
    std::vector<double> misfits;
    for (const std::size_t v : believed_) misfits.push_back(matches_[v].misfit);
    return median(std::move(misfits));
  }

  /// The median misfit of the believed, where it is more than their pictures explain.
  std::optional<double> unexplained(double& explained) const {
    std::vector<double> unresolved;
    for (const std::size_t v : believed_) unresolved.push_back(matches_[v].unresolved);
    const double misfit = medianMisfit();
    explained = median(std::move(unresolved));
    if (misfit > std::max(kMinMisfit, kMisfits * explained))
      return misfit;
    return {};
  }

  /// A sentence on all believed cameras when they disagree and it is not for a few of them, which
  /// are then named.
  Result<std::optional<std::string>> misfitOfAll(std::span<CameraDiagnosis> cameras) {
    double explained = 0;
    if (!unexplained(explained))
      return std::nullopt;
    // A prior, or too few iterations, keep a volume from fitting as well.
    TomographyOptions plain = options_;
    plain.solver = TomographySolver::kApg;
    plain.regularization = Regularization::kNone;
    plain.lambda.reset();
    VOLUTE_ASSIGN(volume_, refitted(plain));
    matches_ = matches(volume_);
    const auto misfit = unexplained(explained);
    if (!misfit)
      return std::nullopt;
    const std::string sentence = fmt::format(
        "the cameras disagree: no volume comes nearer to the pictures of {} of them than {:.1f} % "
        "(relative L2, median) in what is two voxels wide and more, and voxels of this size "
        "explain {:.1f} %; check that each picture is its camera's and no mirror image, that the "
        "bounds "
        "hold all of the medium, where pixel centres are (0 or 0.5), principal points, the lens, "
        "poses (from world to camera, or the other way), and how the pictures store light (linear "
        "or sRGB)",
        believed_.size(), 100 * *misfit, 100 * explained);
    VOLUTE_ASSIGN(const auto culprits, culpritsOf(plain));
    for (const std::size_t v : culprits) {
      compare(v, cameras[v]);
      cameras[v].outOfStep = true;
      cameras[v].warning = misfitOf(cameras[v]);
    }
    return culprits.empty() ? std::optional(sentence) : std::nullopt;
  }

  /// The few without which the others agree; none when that is not so. They are believed no more.
  Result<std::vector<std::size_t>> culpritsOf(const TomographyOptions& plain) {
    constexpr std::size_t kMin = 5;  // fewer agree on nearly everything
    constexpr double kBetter = 0.5;
    const double before = medianMisfit();
    std::vector<std::size_t> culprits;
    for (std::size_t most = views_.size() / 4; most > 0 && believed_.size() > kMin; --most) {
      culprits.push_back(*std::ranges::max_element(
          believed_, {}, [&](std::size_t v) { return matches_[v].misfit; }));
      std::erase(believed_, culprits.back());
      VOLUTE_ASSIGN(volume_, refitted(plain));
      matches_ = matches(volume_);
      double explained = 0;
      if (!unexplained(explained) && medianMisfit() < kBetter * before)
        return culprits;
    }
    return std::vector<std::size_t>{};
  }

  std::vector<TomographyView> views_;  // with the gains that were found
  const VolumeGeometry& geometry_;
  TomographyOptions options_;  // of a fit that goes on
  std::vector<float> volume_;  // fitted to the believed
  Progress& progress_;
  std::vector<std::size_t> believed_;  // ascending
  std::vector<char> judged_;           // one a view
  std::vector<ViewMatch> matches_;     // one a view
};

}  // namespace

double angleBetween(const Camera& a, const Camera& b, const Vec3& centre) {
  auto sight = [&](const Camera& camera) -> Vec3 {
    return camera.isOrthographic() ? camera.forward() : (centre - camera.eye()).normalized();
  };
  const double cosine = std::min(std::abs(sight(a).dot(sight(b))), 1.0);
  return std::acos(cosine) * 180 / std::numbers::pi;
}

std::vector<SightAngle> sightAngles(std::span<const Camera> cameras, const Vec3& centre) {
  std::vector<SightAngle> angles;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    for (std::size_t k = i + 1; k < cameras.size(); ++k)
      angles.push_back({i, k, angleBetween(cameras[i], cameras[k], centre)});
  }
  return angles;
}

std::optional<Remark> layoutAdvice(std::span<const std::string> names,
                                   std::span<const SightAngle> angles) {
  if (const auto widest = std::ranges::max_element(angles, {}, &SightAngle::degrees);
      widest != angles.end() && widest->degrees < kOneSide) {
    return Remark(RemarkCode::kDoubtful,
                  fmt::format("all cameras look along lines within {:.0f} degrees: how the medium "
                              "lies along these is hardly known; another camera that looks from "
                              "the side tells the most",
                              widest->degrees));
  }
  std::string pairs;
  for (const SightAngle& pair : angles) {
    if (pair.degrees < kNarrow)
      pairs += fmt::format("{}{} and {} ({:.0f})", pairs.empty() ? "" : ", ", names[pair.a],
                           names[pair.b], pair.degrees);
  }
  if (pairs.empty())
    return {};
  return Remark(fmt::format(
      "cameras that look along nearly one line, from the same or from opposite sides, tell nearly "
      "the same: {} degrees modulo 180; an odd number on a ring, a half ring, or staggered heights "
      "tell more",
      pairs));
}

namespace {

/// Whether the medium itself may fill the bounds: lines of sight beside them see mostly nothing.
bool isDarkBeside(std::span<const TomographyView> views, const Box3& bounds,
                  std::optional<double> noiseSigma) {
  constexpr std::size_t kFewest = 100;
  std::size_t beside = 0, lit = 0;
  for (const TomographyView& view : views) {
    const auto pixels = pixelsBeside(view.camera, bounds);
    const auto silhouette = dilatedSilhouette(view, noiseSigma);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i] == 0 || !view.counts(i))
        continue;
      ++beside;
      lit += silhouette[i];
    }
  }
  return beside >= kFewest && 2 * lit < beside;
}

}  // namespace

Result<TomographyDiagnosis> diagnose(std::span<const TomographyView> views,
                                     const VolumeGeometry& geometry,
                                     const TomographyOptions& options,
                                     const Reconstruction& reconstruction, Progress& progress) {
  VOLUTE_ASSIGN(auto diagnosis,
                Consistency(views, geometry, options, reconstruction, progress).diagnosis());
  if (options.hull && reconstruction.hullShare > kFullHull &&
      !isDarkBeside(views, geometry.bounds, options.noiseSigma))
    diagnosis.warnings.push_back(fmt::format(
        "the visual hull fills {:.0f} % of the volume, so silhouettes tell nothing: are there "
        "backgrounds to subtract, or is noise_sigma too small?",
        100 * reconstruction.hullShare));
  return diagnosis;
}

}  // namespace volute
