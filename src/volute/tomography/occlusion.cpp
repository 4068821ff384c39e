// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/occlusion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/reduced_view.hpp"

namespace volute {
namespace {

constexpr std::size_t kFewestOccluders = 4;
constexpr double kBrightShare = 0.5;  // of a usual brightness

double greyAt(const Image& image, std::size_t pixel) {
  double sum = 0;
  for (int c = 0; c < image.channels; ++c) sum += image.pixels[pixel * image.channels + c];
  return sum / image.channels;
}

/// A view on coarse voxels.
struct CoarseView {
  TomographyView view;
  int factor = 1;
  std::vector<std::uint8_t> silhouette;  // dilated
  std::vector<std::uint8_t> inside;      // (z, y, x), as one view's hull
  double usual = 0;                      // the median brightness of what shows light
};

CoarseView coarsened(const TomographyView& view, const VolumeGeometry& geometry) {
  constexpr double kPixels = 1.8;
  const int factor =
      std::clamp(static_cast<int>(voxelInPixels(view.camera, geometry) / kPixels), 1,
                 std::max(1, std::min(view.camera.width(), view.camera.height()) / 8));
  CoarseView coarse{reducedView(view, factor), factor, {}, {}};
  coarse.silhouette = dilatedSilhouette(coarse.view, {});
  coarse.inside = visualHull({&coarse.view, 1}, {&coarse.silhouette, 1}, geometry);
  const double threshold = silhouetteThreshold(coarse.view, {});
  std::vector<double> lit;
  for (std::size_t i = 0; i < coarse.silhouette.size(); ++i) {
    const double grey = greyAt(coarse.view.radiance, i);
    if (coarse.view.counts(i) && grey > threshold)
      lit.push_back(grey);
  }
  if (!lit.empty()) {
    const auto middle = lit.begin() + static_cast<std::ptrdiff_t>(lit.size() / 2);
    std::ranges::nth_element(lit, middle);
    coarse.usual = *middle;
  }
  return coarse;
}

/// Whether a camera sees usual light where a point is.
bool seesLight(const CoarseView& coarse, const Vec3& point) {
  const auto place = coarse.view.camera.project(point);
  if (!place)
    return false;
  const int width = coarse.view.camera.width(), height = coarse.view.camera.height();
  const int x = static_cast<int>(std::floor(place->x())),
            y = static_cast<int>(std::floor(place->y()));
  if (x < 0 || y < 0 || x >= width || y >= height)
    return false;
  const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
  return coarse.view.counts(pixel) &&
         greyAt(coarse.view.radiance, pixel) > kBrightShare * coarse.usual;
}

/// For each view, the voxels that it alone calls empty and that all others see amid their light.
std::vector<std::size_t> contestedVoxels(std::span<const CoarseView> views,
                                         const VolumeGeometry& geometry) {
  std::vector<std::size_t> contested(views.size());
  const auto& n = geometry.resolution;
  for (std::size_t i = 0; i < geometry.voxels(); ++i) {
    std::optional<std::size_t> only;
    std::size_t against = 0;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (views[v].inside[i] == 0) {
        only = v;
        ++against;
      }
    }
    if (against != 1)
      continue;
    const Vec3 voxel(static_cast<double>(i % n[0]) + 0.5,
                     static_cast<double>(i / n[0] % n[1]) + 0.5,
                     static_cast<double>(i / n[0] / n[1]) + 0.5);
    const Vec3 point = geometry.bounds.min + voxel.cwiseProduct(geometry.voxelSize());
    bool all = true;
    for (std::size_t v = 0; v < views.size() && all; ++v)
      all = v == *only || seesLight(views[v], point);
    contested[*only] += all ? 1 : 0;
  }
  return contested;
}

/// The squared misfit of a volume in all pixels but some of one view.
double misfitBeside(std::span<const CoarseView> views, std::size_t view,
                    std::span<const std::size_t> left, std::span<const float> volume,
                    const VolumeGeometry& geometry, Basis basis) {
  double sum = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const TomographyView& own = views[v].view;
    const Image seen = projectVolume(volume, geometry, basis, own.camera, 1);
    for (std::size_t i = 0; i < views[v].silhouette.size(); ++i) {
      if (!own.counts(i) || (v == view && std::ranges::binary_search(left, i)))
        continue;
      const double off = greyAt(seen, i) - greyAt(own.radiance, i);
      sum += off * off;
    }
  }
  return sum;
}

/// Whether some volume explains the dark pixels of a view with everything else: then nothing has to
/// be in front of it.
Result<bool> explained(std::span<const CoarseView> views, std::size_t view,
                       std::span<const std::size_t> dark, const VolumeGeometry& geometry,
                       const TomographyOptions& options, Progress& progress) {
  constexpr double kWorse = 1.5;
  std::vector<TomographyView> all;
  for (const CoarseView& one : views) all.push_back(one.view);
  VOLUTE_ASSIGN(const auto with, reconstruct(all, geometry, options, {}, progress));
  TomographyView& own = all[view];
  if (own.weight.empty())
    own.weight.assign(views[view].silhouette.size(), 1);
  for (const std::size_t pixel : dark) own.weight[pixel] = 0;
  VOLUTE_ASSIGN(const auto without, reconstruct(all, geometry, options, {}, progress));
  return misfitBeside(views, view, dark, with.volume, geometry, options.basis) <
         kWorse * misfitBeside(views, view, dark, without.volume, geometry, options.basis);
}

}  // namespace

Result<std::vector<Occlusion>> findOcclusions(std::span<const TomographyView> views,
                                              const VolumeGeometry& geometry, Progress& progress) {
  constexpr int kLongest = 24, kIterations = 30;
  constexpr std::size_t kFewestVoxels = 3, kFewestPixels = 3;
  constexpr double kAsAWhole = 0.9, kFits = 0.3;
  std::vector<Occlusion> found;
  if (views.size() < kFewestOccluders)
    return found;
  for (const TomographyView& view : views) {
    if (view.opticalDepth || view.camera.isOrthographic())
      return found;
  }
  const int longest = *std::ranges::max_element(geometry.resolution);
  const VolumeGeometry coarse = coarserGeometry(geometry, (longest + kLongest - 1) / kLongest);
  std::vector<CoarseView> reduced;
  for (const TomographyView& view : views) reduced.push_back(coarsened(view, coarse));
  const auto contested = contestedVoxels(reduced, coarse);
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (contested[v] < kFewestVoxels)
      continue;
    std::vector<TomographyView> others;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (i != v)
        others.push_back(reduced[i].view);
    }
    TomographyOptions options;
    options.regularization = Regularization::kNone;
    options.iterations = kIterations;
    options.raysPerPixel = 1;
    const auto fit = reconstruct(others, coarse, options, {}, progress);
    if (!fit) {
      if (fit.error().code == ErrorCode::kCancelled)
        return tl::unexpected<Error>(fit.error());
      continue;  // why the others do not go together is told elsewhere
    }
    const CoarseView& own = reduced[v];
    const Image predicted = projectVolume(fit->volume, coarse, options.basis, own.view.camera, 1);
    const double threshold = silhouetteThreshold(own.view, {});
    const int width = own.view.camera.width(), height = own.view.camera.height();
    std::vector<std::size_t> dark;
    std::size_t light = 0;
    double off = 0, size = 0;  // of the other pixels
    for (std::size_t i = 0; i < own.silhouette.size(); ++i) {
      if (!own.view.counts(i))
        continue;
      const double told = greyAt(predicted, i), seen = greyAt(own.view.radiance, i);
      const bool bright = told > kBrightShare * own.usual;
      light += bright ? 1 : 0;
      if (bright && std::abs(seen) <= std::max(threshold, 0.05 * told)) {
        dark.push_back(i);
        continue;
      }
      off += (told - seen) * (told - seen);
      size += seen * seen;
    }
    const double share =
        static_cast<double>(dark.size()) / static_cast<double>(std::max<std::size_t>(1, light));
    if (dark.size() < kFewestPixels || share > kAsAWhole || off > kFits * kFits * size)
      continue;
    const auto needless = explained(reduced, v, dark, coarse, options, progress);
    if (!needless && needless.error().code == ErrorCode::kCancelled)
      return tl::unexpected<Error>(needless.error());
    if (needless && *needless)
      continue;
    // Pixels at the rim of what is in the way are half covered.
    Occlusion occlusion{
        v, std::vector<std::uint8_t>(views[v].radiance.pixels.size() / views[v].radiance.channels),
        share};
    const int fullWidth = views[v].camera.width();
    for (const std::size_t pixel : dark) {
      const int x = static_cast<int>(pixel) % width, y = static_cast<int>(pixel) / width;
      for (int row = std::max(y - 1, 0) * own.factor; row < std::min(y + 2, height) * own.factor;
           ++row)
        for (int column = std::max(x - 1, 0) * own.factor;
             column < std::min(x + 2, width) * own.factor; ++column)
          occlusion.pixels[static_cast<std::size_t>(row) * fullWidth + column] = 1;
    }
    found.push_back(std::move(occlusion));
  }
  return found;
}

void leaveOut(const Occlusion& occlusion, TomographyView& view) {
  if (view.weight.empty())
    view.weight.assign(occlusion.pixels.size(), 1);
  for (std::size_t i = 0; i < occlusion.pixels.size(); ++i) {
    if (occlusion.pixels[i] == 0)
      continue;
    view.weight[i] = 0;
    if (!view.atLeast.empty())
      view.atLeast[i] = 0;
  }
}

}  // namespace volute
