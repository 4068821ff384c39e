// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/match.hpp"

#include <algorithm>
#include <cmath>

#include "volute/tomography/box_blur.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/reduced_view.hpp"

namespace volute {
namespace {

double squaredSum(const Image& image) {
  double sum = 0;
  for (const float value : image.pixels) sum += static_cast<double>(value) * value;
  return sum;
}

/// Whether each pixel counts, is not saturated, and sees the volume.
std::vector<char> comparable(const TomographyView& view, const Box3& bounds) {
  const Image& image = view.radiance;
  std::vector<char> is(image.pixels.size() / 3);
  for (std::size_t i = 0; i < is.size(); ++i) {
    if (!view.counts(i))
      continue;
    const Segment ray = view.camera.ray(static_cast<double>(i % image.width) + 0.5,
                                        static_cast<double>(i / image.width) + 0.5);
    is[i] =
        bounds.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end}).empty() ? 0 : 1;
  }
  return is;
}

void findMisfit(const TomographyView& view, const Image& projected, const VolumeGeometry& geometry,
                double sigma, ViewMatch& match) {
  constexpr double kCompared = 2, kUnresolved = 1.5;  // voxels
  const double voxel = voxelInPixels(view.camera, geometry);
  const std::vector<char> is = comparable(view, geometry.bounds);
  Image given(projected.width, projected.height), off = given;
  for (std::size_t i = 0; i < given.pixels.size(); ++i) {
    if (is[i / 3] == 0)
      continue;
    given.pixels[i] = view.radiance.pixels[i];
    off.pixels[i] = projected.pixels[i] - view.radiance.pixels[i];
  }
  Image fine = given;
  const Image coarse = boxBlurred(given, kUnresolved * voxel);
  for (std::size_t i = 0; i < fine.pixels.size(); ++i) fine.pixels[i] -= coarse.pixels[i];
  const double width = kCompared * voxel;
  double squares = 0;
  for (const float weight : boxWeights(width)) squares += static_cast<double>(weight) * weight;
  const double noise =
      sigma * sigma * squares * squares * 3 * static_cast<double>(std::ranges::count(is, 1));
  const double all = squaredSum(boxBlurred(given, width));
  const double light = std::max(all - noise, 1e-6 * all);
  if (!(light > 0))
    return;
  const double pixelNoise = sigma * sigma * 3 * static_cast<double>(std::ranges::count(is, 1));
  const double whole = squaredSum(given);
  match.fine = std::sqrt(std::max(squaredSum(fine) - pixelNoise, 0.0) /
                         std::max(whole - pixelNoise, 1e-6 * whole));
  match.misfit = std::sqrt(std::max(squaredSum(boxBlurred(off, width)) - noise, 0.0) / light);
  match.unresolved = std::sqrt(squaredSum(boxBlurred(fine, width)) / light);
}

}  // namespace

ViewMatch matchOf(const TomographyView& view, const Image& inColour, const VolumeGeometry& geometry,
                  std::optional<double> noiseSigma) {
  ViewMatch match;
  const Image projected = asSeenBy(view, inColour);
  double difference = 0, light = 0, both = 0, shown = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < projected.pixels.size(); ++i) {
    if (!view.counts(i / 3))
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
    match.residual = std::sqrt(std::max(difference - noise, 0.0) / signal);
  if (both > 0)
    match.gain = shown / both;
  findMisfit(view, projected, geometry, sigma, match);
  return match;
}

}  // namespace volute
