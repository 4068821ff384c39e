// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"

namespace volute {
namespace {

constexpr double kStandsOut = 2;         // times the median residual of the others
constexpr double kLeastResidual = 0.02;  // below, nobody stands out
constexpr double kGainShare = 0.3;       // of the squared residual that a gain must explain
constexpr double kMostBorder = 0.01;
constexpr double kMostOutside = 0.02;
constexpr double kFullHull = 0.9;
constexpr double kNarrow = 15;  // [degrees]

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

double medianOfOthers(std::span<const CameraDiagnosis> cameras, std::size_t without,
                      double CameraDiagnosis::* field) {
  std::vector<double> values;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (i != without)
      values.push_back(cameras[i].*field);
  }
  return values.empty() ? cameras[without].*field : median(std::move(values));
}

/// How a view and a picture of the volume go together, over the pixels that count.
struct Match {
  double residual = 0;  ///< relative, without the share of the noise
  double gain = 1;      ///< on what was measured

  Match(const TomographyView& view, const Image& projected, std::optional<double> noiseSigma) {
    double difference = 0, light = 0, both = 0, shown = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < projected.pixels.size(); ++i) {
      if (!view.weight.empty() && view.weight[i / 3] == 0)
        continue;
      const double p = projected.pixels[i], m = view.radiance.pixels[i];
      difference += (p - m) * (p - m);
      light += m * m;
      both += p * m;
      shown += p * p;
      ++count;
    }
    const double sigma = noiseSigma.value_or(noiseOf(view));
    const double noise = sigma * sigma * static_cast<double>(count);
    const double signal = std::max(light - noise, 1e-6 * light);
    if (light > 0)
      residual = std::sqrt(std::max(difference - noise, 0.0) / signal);
    if (both > 0)
      gain = shown / both;
  }
};

/// The share of the image's border that is brighter than a hundredth of the brightest pixel, and
/// than noise.
double litBorder(const TomographyView& view, double threshold) {
  const Image& image = view.radiance;
  std::size_t lit = 0, all = 0;
  for (int y = 0; y < image.height; ++y) {
    const bool edge = y == 0 || y == image.height - 1;
    for (int x = 0; x < image.width; x += edge ? 1 : std::max(image.width - 1, 1)) {
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      const bool counts = view.weight.empty() || view.weight[pixel] != 0;
      const float value = std::max({image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)});
      lit += counts && value > threshold ? 1 : 0;
      ++all;
    }
  }
  return static_cast<double>(lit) / static_cast<double>(all);
}

/// The share of the light above `threshold` on pixels whose rays miss the volume.
double lightOutside(const TomographyView& view, const Box3& bounds, double threshold) {
  const Image& image = view.radiance;
  double outside = 0, all = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      const double value = image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2);
      if (value <= 3 * threshold || (!view.weight.empty() && view.weight[pixel] == 0))
        continue;
      const Segment ray = view.camera.ray(x + 0.5, y + 0.5);
      const bool misses =
          bounds.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end}).empty();
      outside += misses ? value : 0;
      all += value;
    }
  }
  return all > 0 ? outside / all : 0;
}

/// A camera's match with a volume that was fitted without it.
Result<Match> matchWithout(std::span<const TomographyView> views, std::size_t camera,
                           const VolumeGeometry& geometry, const TomographyOptions& options,
                           const Reconstruction& reconstruction, Progress& progress) {
  constexpr int kIterations = 60;
  std::vector<TomographyView> others(views.begin(), views.end());
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(camera));
  TomographyOptions same = options;
  same.regularization = reconstruction.regularization;
  same.lambda = reconstruction.lambda;
  same.iterations = kIterations;
  same.coarseToFine = false;
  VOLUTE_ASSIGN(const Reconstruction fit,
                reconstruct(others, geometry, same, reconstruction.volume, progress));
  return Match(views[camera],
               projectVolume(fit.volume, geometry, options.basis, views[camera].camera,
                             options.raysPerPixel),
               options.noiseSigma);
}

void warnOf(const TomographyView& view, const CameraDiagnosis& camera,
            std::vector<std::string>& warnings) {
  if (camera.gainDrift)
    warnings.push_back(fmt::format(
        "Camera {} is {:.0f} % too {}: its radiance times {:.3f} fits the others; set its gain in "
        "the capture",
        view.name, 100 * std::abs(1 / camera.gain - 1), camera.gain < 1 ? "bright" : "dark",
        camera.gain));
  if (camera.outOfStep)
    warnings.push_back(fmt::format(
        "Camera {} does not fit the others: its residual of {:.3f} is {:.1f} times theirs; check "
        "that it shows the same instant, its calibration and its background",
        view.name, camera.residual, camera.residualRatio));
  if (camera.borderLight > kMostBorder)
    warnings.push_back(fmt::format(
        "Camera {} sees light on {:.0f} % of its image's border: what lies beyond is missing; "
        "mask it, or film from further away",
        view.name, 100 * camera.borderLight));
  if (camera.lightOutside > kMostOutside)
    warnings.push_back(fmt::format(
        "Camera {}: {:.0f} % of its light comes from beside the volume; enlarge the volume, or "
        "check the background and the calibration",
        view.name, 100 * camera.lightOutside));
}

/// What one view says on its own.
CameraDiagnosis measured(const TomographyView& view, const VolumeGeometry& geometry,
                         const TomographyOptions& options, const Reconstruction& reconstruction) {
  const Image projected = projectVolume(reconstruction.volume, geometry, options.basis, view.camera,
                                        options.raysPerPixel);
  const Match match(view, projected, options.noiseSigma);
  const double threshold = silhouetteThreshold(view, options.noiseSigma);
  CameraDiagnosis camera;
  camera.residual = match.residual;
  camera.gain = match.gain;
  camera.borderLight = litBorder(view, 5 * threshold);
  camera.lightOutside = lightOutside(view, geometry.bounds, threshold);
  return camera;
}

/// What the view says beside the others. `raw` is as measured() has it.
CameraDiagnosis compared(std::span<const CameraDiagnosis> raw, std::size_t v) {
  CameraDiagnosis camera = raw[v];
  const double others = medianOfOthers(raw, v, &CameraDiagnosis::residual);
  camera.residualRatio = camera.residual / std::max(others, 1e-3);
  camera.gain = raw[v].gain / medianOfOthers(raw, v, &CameraDiagnosis::gain);
  const bool standsOut = camera.residual > kLeastResidual && camera.residualRatio > kStandsOut;
  if (standsOut && raw.size() > 2) {
    // With the gain g a residual of about |1 - g| would be left of a perfect fit.
    const double explained = std::abs(1 - camera.gain) / camera.residual;
    camera.gainDrift = explained * explained > kGainShare;
    camera.outOfStep = !camera.gainDrift;
  }
  return camera;
}

}  // namespace

double angleBetween(const Camera& a, const Camera& b, const Vec3& centre) {
  auto sight = [&](const Camera& camera) -> Vec3 {
    return camera.isOrthographic() ? camera.forward() : (centre - camera.eye()).normalized();
  };
  const double cosine = std::min(std::abs(sight(a).dot(sight(b))), 1.0);
  return std::acos(cosine) * 180 / std::numbers::pi;
}

std::vector<std::string> layoutAdvice(std::span<const TomographyView> views, const Vec3& centre) {
  std::vector<std::string> advice;
  if (views.size() < 3)
    advice.push_back(
        fmt::format("{} cameras leave the volume all but open: take 3 at least, better 6 or more",
                    views.size()));
  std::string pairs;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      const double angle = angleBetween(views[i].camera, views[j].camera, centre);
      if (angle < kNarrow)
        pairs += fmt::format("{}{} and {} ({:.0f} degrees)", pairs.empty() ? "" : ", ",
                             views[i].name, views[j].name, angle);
    }
  }
  if (!pairs.empty())
    advice.push_back(
        fmt::format("These cameras look along nearly the same line, to or fro, and tell nearly the "
                    "same: {}; an odd number in a ring, a half arc, or staggered heights tell more",
                    pairs));
  return advice;
}

Result<TomographyDiagnosis> diagnose(std::span<const TomographyView> views,
                                     const VolumeGeometry& geometry,
                                     const TomographyOptions& options,
                                     const Reconstruction& reconstruction, Progress& progress) {
  TomographyDiagnosis diagnosis;
  std::vector<CameraDiagnosis> raw;
  for (const TomographyView& view : views)
    raw.push_back(measured(view, geometry, options, reconstruction));
  for (std::size_t v = 0; v < views.size(); ++v) {
    CameraDiagnosis camera = compared(raw, v);
    if (camera.gainDrift) {
      VOLUTE_ASSIGN(const Match alone,
                    matchWithout(views, v, geometry, options, reconstruction, progress));
      camera.gain = alone.gain;
    }
    warnOf(views[v], camera, diagnosis.warnings);
    diagnosis.cameras.push_back(camera);
  }
  if (options.hull && reconstruction.hullShare > kFullHull)
    diagnosis.warnings.push_back(fmt::format(
        "The visual hull fills {:.0f} % of the volume: enlarge the volume, or check backgrounds "
        "and silhouettes",
        100 * reconstruction.hullShare));
  const Vec3 centre = geometry.bounds.centre();
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j)
      diagnosis.angles.push_back(angleBetween(views[i].camera, views[j].camera, centre));
  }
  diagnosis.advice = layoutAdvice(views, centre);
  return diagnosis;
}

}  // namespace volute
