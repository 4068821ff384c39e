// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reduced_view.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

Camera reducedCamera(const Camera& camera, int factor) {
  Mat3 k = camera.intrinsics();
  for (int column = 0; column < 3; ++column) k(0, column) /= factor, k(1, column) /= factor;
  auto reduced =
      Camera::calibrated({camera.width() / factor, camera.height() / factor, k, camera.rotation(),
                          -(camera.rotation() * camera.eye()), camera.distortion(), 0.5});
  // A lens that could be undone along the border of the picture can be within it.
  VOLUTE_ASSERT(reduced);
  return *reduced;
}

}  // namespace

double voxelInPixels(const Camera& camera, const VolumeGeometry& geometry) {
  const double x = 0.5 * camera.width(), y = 0.5 * camera.height();
  const Segment middle = camera.ray(x, y), beside = camera.ray(x + 1, y);
  const double distance = (geometry.bounds.centre() - middle.origin).dot(middle.direction);
  const double pixel = (beside.at(distance) - middle.at(distance)).norm();
  return pixel > 0 ? std::max(1.0, geometry.voxelSize().maxCoeff() / pixel) : 1;
}

TomographyView reducedView(const TomographyView& view, int factor) {
  VOLUTE_ASSERT(factor >= 1 && factor <= std::min(view.camera.width(), view.camera.height()));
  if (factor == 1)
    return view;
  TomographyView reduced{view.name, reducedCamera(view.camera, factor), {}};
  reduced.opticalDepth = view.opticalDepth;
  reduced.grey = view.grey;
  reduced.sightError = view.sightError / factor;
  const Image& image = view.radiance;
  const int width = reduced.camera.width(), height = reduced.camera.height();
  reduced.radiance = Image(width, height, image.channels);
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  const bool someDoNotCount = !view.weight.empty() || !view.atLeast.empty();
  if (someDoNotCount)
    reduced.weight.assign(pixels, 0);
  if (!view.silhouette.empty())
    reduced.silhouette.assign(pixels, 0);
  std::vector<double> sum(static_cast<std::size_t>(image.channels));
  for (std::size_t i = 0; i < pixels; ++i) {
    const int left = static_cast<int>(i % width) * factor,
              top = static_cast<int>(i / width) * factor;
    std::ranges::fill(sum, 0);
    double weight = 0;
    int counted = 0;
    for (int y = top; y < top + factor; ++y) {
      for (int x = left; x < left + factor; ++x) {
        const std::size_t from = static_cast<std::size_t>(y) * image.width + x;
        if (!view.silhouette.empty() && view.silhouette[from] != 0)
          reduced.silhouette[i] = 1;
        if (!view.counts(from) || view.isSaturated(from))
          continue;
        const double own = view.weight.empty() ? 1 : view.weight[from];
        weight += own;
        ++counted;
        for (int c = 0; c < image.channels; ++c)
          sum[static_cast<std::size_t>(c)] += own * image.at(x, y, c);
      }
    }
    if (weight > 0) {
      for (int c = 0; c < image.channels; ++c)
        reduced.radiance.pixels[i * image.channels + c] =
            static_cast<float>(sum[static_cast<std::size_t>(c)] / weight);
    }
    // Half a block and more stands for all of it.
    if (someDoNotCount && 2 * counted >= factor * factor)
      reduced.weight[i] = static_cast<float>(weight / (factor * factor));
  }
  return reduced;
}

VolumeGeometry coarserGeometry(VolumeGeometry geometry, int factor) {
  for (int& n : geometry.resolution) n = std::max(1, (n + factor - 1) / factor);
  return geometry;
}

}  // namespace volute
