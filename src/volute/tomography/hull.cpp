// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/hull.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/tomography/box_blur.hpp"

namespace volute {
namespace {

/// How many rays on a side of a pixel keep neighbours within one voxel, all through the volume.
int raysPerSide(const Camera& camera, const VolumeGeometry& geometry) {
  constexpr double kMax = 16;
  const double x = 0.5 * camera.width(), y = 0.5 * camera.height();
  const Segment middle = camera.ray(x, y), right = camera.ray(x + 1, y),
                below = camera.ray(x, y + 1);
  double furthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
    const Vec3 point = geometry.bounds.min + up.cwiseProduct(geometry.bounds.size());
    furthest = std::max(furthest, (point - middle.origin).dot(middle.direction));
  }
  const Vec3 there = middle.at(furthest);
  const double spacing =
      std::max((right.at(furthest) - there).norm(), (below.at(furthest) - there).norm());
  const double rays = std::ceil(spacing / geometry.voxelSize().minCoeff());
  return rays > 1 ? static_cast<int>(std::min(rays, kMax)) : 1;
}

enum Seen : std::uint8_t { kUnseen = 0, kOutside = 1, kInside = 2 };

/// (z, y, x): how the camera sees each voxel of a range; the others count as unseen.
std::vector<std::uint8_t> seenVoxels(const Camera& camera, std::span<const std::uint8_t> silhouette,
                                     const VolumeGeometry& geometry, const CellRange& range) {
  const CellGrid cells = basisCells(geometry, Basis::kBox);
  std::vector<std::uint8_t> seen(geometry.voxels(), kUnseen);
  const int side = raysPerSide(camera, geometry);
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t row) {
    for (int x = 0; x < camera.width(); ++x) {
      const std::uint8_t mark = silhouette[row * camera.width() + x] != 0 ? kInside : kOutside;
      for (int i = 0; i < side * side; ++i) {
        const Segment ray = camera.ray(x + (i % side + 0.5) / side,
                                       static_cast<double>(row) + (i / side + 0.5) / side);
        traverseCells(cells, range, ray, [&](const std::array<int, 3>& cell, double, double) {
          const std::size_t voxel =
              (static_cast<std::size_t>(cell[2]) * cells.count[1] + cell[1]) * cells.count[0] +
              cell[0];
          const std::atomic_ref<std::uint8_t> at(seen[voxel]);
          std::uint8_t old = at.load(std::memory_order_relaxed);
          while (old < mark && !at.compare_exchange_weak(old, mark, std::memory_order_relaxed)) {
          }
        });
      }
    }
  });
  return seen;
}

std::vector<std::uint8_t> dilated(std::span<const std::uint8_t> mask, int width, int height) {
  std::vector<std::uint8_t> wide(mask.size()), out(mask.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* row = mask.data() + static_cast<std::size_t>(y) * width;
      wide[static_cast<std::size_t>(y) * width + x] =
          row[x] | row[std::max(x - 1, 0)] | row[std::min(x + 1, width - 1)];
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      auto at = [&](int row) { return wide[static_cast<std::size_t>(row) * width + x]; };
      out[static_cast<std::size_t>(y) * width + x] =
          at(y) | at(std::max(y - 1, 0)) | at(std::min(y + 1, height - 1));
    }
  return out;
}

/// Light below this share of the brightest is no part of a silhouette.
constexpr double kDarkest = 0.002;

double brightestOf(const TomographyView& view) {
  float brightest = 0;
  for (std::size_t i = 0; i < view.radiance.pixels.size(); ++i) {
    const bool valid = view.weight.empty() || view.weight[i / view.radiance.channels] != 0;
    brightest = std::max(brightest, valid ? view.radiance.pixels[i] : 0);
  }
  return brightest;
}

/// Whether dark pixels hold the upper half of their noise alone, as integers do.
bool isCutOff(const Image& image) {
  constexpr double kMany = 0.15;
  std::size_t zeros = 0;
  for (const float value : image.pixels) {
    if (value < 0)
      return false;
    zeros += value == 0 ? 1 : 0;
  }
  return static_cast<double>(zeros) > kMany * static_cast<double>(image.pixels.size());
}

/// A tenth of a blurred picture's values below a limit are below this.
double lowestBelow(const TomographyView& view, const Image& blurred, double limit) {
  std::vector<float> dark;
  for (std::size_t i = 0; i < blurred.pixels.size(); ++i) {
    if (view.counts(i / blurred.channels) && blurred.pixels[i] < limit)
      dark.push_back(blurred.pixels[i]);
  }
  if (dark.empty())
    return 0;
  const auto tenth = dark.begin() + static_cast<std::ptrdiff_t>(dark.size() / 10);
  std::ranges::nth_element(dark, tenth);
  return *tenth;
}

/// Pixels that show the medium. Where noise decides, the means of 25 pixels are looked at: their
/// noise is a fifth. The mean of noise that is cut off at 0 is .4 of it; films smooth noise, which
/// leaves less of its differences, but all of that mean.
std::vector<std::uint8_t> litPixels(const TomographyView& view, std::optional<double> noiseSigma) {
  constexpr double kFifths = 5, kOfCutOff = 4;  // a box so wide leaves a fifth of the noise
  constexpr double kOfLowest = 3.5;             // 3.5 / kOfCutOff / (.4 - 1.28 * .58 / kFifths)
  const double darkest = kDarkest * brightestOf(view);
  double threshold = silhouetteThreshold(view, noiseSigma);
  const bool noisy = threshold > darkest;
  const Image image = noisy ? boxBlurred(view.radiance, kFifths) : view.radiance;
  if (noisy) {
    const double reached = isCutOff(view.radiance)
                               ? std::clamp(kOfLowest * lowestBelow(view, image, threshold),
                                            threshold / kOfCutOff, threshold)
                               : threshold / kFifths;
    threshold = std::max(reached, darkest);
  }
  std::vector<std::uint8_t> mask(image.pixels.size() / image.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (std::abs(image.pixels[i]) > threshold)
      mask[i / image.channels] = 1;
  }
  return mask;
}

}  // namespace

double noiseOf(const TomographyView& view) {
  const Image& image = view.radiance;
  std::vector<float> differences;
  float step = std::numeric_limits<float>::infinity();  // of stored integers; of floats next to 0
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x + 1 < image.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      if (!view.weight.empty() && (view.weight[pixel] == 0 || view.weight[pixel + 1] == 0))
        continue;
      for (int c = 0; c < image.channels; ++c) {
        differences.push_back(std::abs(image.at(x, y, c) - image.at(x + 1, y, c)));
        if (differences.back() > 0)
          step = std::min(step, differences.back());
      }
    }
  }
  if (differences.empty() || !std::isfinite(step))
    return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::ranges::nth_element(differences, middle);
  double median = *middle;
  // Of integers many differences are the same: they are spread over the step that they stand for.
  constexpr std::ptrdiff_t kOfSteps = 100;  // one of so many at least is a single step
  const auto near = [&](double value) {
    return std::ranges::count_if(differences, [&](float difference) {
      return std::abs(difference - value) < 0.5 * static_cast<double>(step);
    });
  };
  if (median < 4 * static_cast<double>(step) && kOfSteps * near(step) > std::ssize(differences)) {
    const double low = std::max(0.0, median - 0.5 * static_cast<double>(step));
    const auto below =
        std::ranges::count_if(differences, [&](float difference) { return difference <= low; });
    const auto counted = static_cast<double>(near(median)),
               all = static_cast<double>(differences.size());
    const double width = median > 0 ? step : 0.5 * static_cast<double>(step);
    median = low + width * (0.5 * all - static_cast<double>(median > 0 ? below : 0)) / counted;
  }
  constexpr double kSigmaOfMedian = 1.4826 / 1.41421356;  // of a difference of two
  constexpr double kWhole = 1.7;                          // times what is seen of it
  return kSigmaOfMedian * median * (isCutOff(image) ? kWhole : 1);
}

double silhouetteThreshold(const TomographyView& view, std::optional<double> noiseSigma) {
  return std::max(3.5 * noiseSigma.value_or(noiseOf(view)), kDarkest * brightestOf(view));
}

std::vector<std::uint8_t> dilatedSilhouette(const TomographyView& view,
                                            std::optional<double> noiseSigma) {
  const Image& image = view.radiance;
  std::vector<std::uint8_t> mask =
      view.silhouette.empty() ? litPixels(view, noiseSigma) : view.silhouette;
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = mask[i] != 0 ? 1 : 0;
  constexpr double kSigmas = 2;
  const int margin = 1 + static_cast<int>(std::lround(kSigmas * view.sightError));
  for (int k = 0; k < margin; ++k) mask = dilated(mask, image.width, image.height);
  for (std::size_t i = 0; i < view.weight.size(); ++i) {
    if (view.weight[i] == 0)
      mask[i] = 1;
  }
  return mask;
}

std::vector<std::uint8_t> visualHull(std::span<const TomographyView> views,
                                     std::span<const std::vector<std::uint8_t>> silhouettes,
                                     const VolumeGeometry& geometry) {
  std::vector<std::uint8_t> hull(geometry.voxels(), 1);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto seen =
        seenVoxels(views[v].camera, silhouettes[v], geometry, boxAround(geometry, hull));
    for (std::size_t i = 0; i < hull.size(); ++i) hull[i] &= seen[i] != kOutside ? 1 : 0;
  }
  return hull;
}

}  // namespace volute
