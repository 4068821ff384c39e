// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/frame_edges.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/math/vec.hpp"

namespace volute {
namespace {

constexpr float kSame = 0.1F;   ///< of distances' logarithms: closer ones are of one surface
constexpr float kSky = 1e9F;    ///< [m]
constexpr int kReach = 2;       ///< [pixels] in which surfaces are looked for
constexpr double kMixed = 0.5;  ///< of a pixel's colour may not be between both surfaces'

float logOf(float depth) {
  return std::log(std::clamp(depth, 1e-3F, kSky));
}

/// What is known of a picture's pixels: the range of distances, as logarithms, and whether it is
/// that of one surface.
struct Ranges {
  int width = 0, height = 0;
  std::vector<float> near, far;
  std::vector<char> pure;

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }

  /// Calls with each pixel of the picture that is so close.
  template <class Visit>
  void around(int x, int y, int reach, Visit&& visit) const {
    for (int j = std::max(y - reach, 0); j <= std::min(y + reach, height - 1); ++j) {
      for (int i = std::max(x - reach, 0); i <= std::min(x + reach, width - 1); ++i) visit(i, j);
    }
  }
};

/// The mean colour of the pixels around one that show a surface at this distance alone.
std::optional<Rgb> colorAt(const Image& color, const Ranges& ranges, int x, int y, float distance) {
  Rgb sum = Rgb::Zero();
  double weights = 0;
  ranges.around(x, y, kReach, [&](int i, int j) {
    const std::size_t k = ranges.index(i, j);
    if (!ranges.pure[k] || std::abs(ranges.near[k] - distance) > kSame)
      return;
    const double weight = 1.0 / ((i - x) * (i - x) + (j - y) * (j - y) + 1);
    for (int c = 0; c < 3; ++c) sum[c] += weight * color.at(i, j, c);
    weights += weight;
  });
  if (weights > 0)
    return Rgb(sum / weights);
  return std::nullopt;
}

Rgb colorOf(const Image& color, int x, int y) {
  return {color.at(x, y, 0), color.at(x, y, 1), color.at(x, y, 2)};
}

void setColor(Image& color, int x, int y, const Rgb& value) {
  for (int c = 0; c < 3; ++c) color.at(x, y, c) = static_cast<float>(value[c]);
}

/// Pixels whose neighbours are at other distances are not pure.
Ranges rangesOf(const Image& color, std::span<const float> depth) {
  Ranges own{color.width, color.height, {}, {}, {}};
  for (const float d : depth) own.near.push_back(logOf(d));
  Ranges all = own;
  all.far = own.near;
  all.pure.assign(depth.size(), 1);
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < color.width; ++x) {
      const std::size_t k = all.index(x, y);
      own.around(x, y, 1, [&](int i, int j) {
        all.near[k] = std::min(all.near[k], own.near[own.index(i, j)]);
        all.far[k] = std::max(all.far[k], own.near[own.index(i, j)]);
      });
      all.pure[k] = all.far[k] - all.near[k] <= kSame;
    }
  });
  return all;
}

/// The colours of the two surfaces that a pixel shows, and the near one's share.
struct Mix {
  Rgb near, far;
  double share = 1;
};

std::optional<Mix> mixOf(const Image& color, const Ranges& ranges, int x, int y) {
  const std::size_t k = ranges.index(x, y);
  const auto near = colorAt(color, ranges, x, y, ranges.near[k]);
  const auto far = colorAt(color, ranges, x, y, ranges.far[k]);
  if (!near || !far)
    return std::nullopt;
  const Rgb between = *near - *far, shown = colorOf(color, x, y);
  const double contrast = between.matrix().squaredNorm();
  if (!(contrast > 0))
    return std::nullopt;
  Mix mix{*near, *far};
  mix.share = std::clamp((shown - *far).matrix().dot(between.matrix()) / contrast, 0.0, 1.0);
  const Rgb rest = shown - (mix.share * mix.near + (1 - mix.share) * mix.far);
  if (rest.matrix().squaredNorm() > kMixed * kMixed * contrast)
    return std::nullopt;
  mix.near += rest, mix.far += rest;
  return mix;
}

/// The distance of the pixel around one that is nearest to this one's logarithm.
float depthNear(std::span<const float> depth, const Ranges& ranges, int x, int y, float wanted) {
  float found = depth[ranges.index(x, y)], off = std::abs(logOf(found) - wanted);
  ranges.around(x, y, 1, [&](int i, int j) {
    const float here = depth[ranges.index(i, j)];
    if (std::abs(logOf(here) - wanted) < off)
      found = here, off = std::abs(logOf(here) - wanted);
  });
  return found;
}

}  // namespace

std::vector<FrameSample> samplesOf(const Image& color, std::vector<float> depth) {
  const Ranges ranges = rangesOf(color, depth);
  std::vector<FrameSample> samples(2, {color, std::move(depth), {}});
  FrameSample &near = samples[0], &far = samples[1];
  const std::vector<float> own = near.depth;
  near.weight.assign(own.size(), 1);
  far.weight.assign(own.size(), 0);
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < color.width; ++x) {
      const std::size_t k = ranges.index(x, y);
      const auto mix = ranges.pure[k] ? std::nullopt : mixOf(color, ranges, x, y);
      if (!mix)
        continue;
      setColor(near.color, x, y, mix->near);
      setColor(far.color, x, y, mix->far);
      near.depth[k] = depthNear(own, ranges, x, y, ranges.near[k]);
      far.depth[k] = depthNear(own, ranges, x, y, ranges.far[k]);
      near.weight[k] = static_cast<float>(mix->share);
      far.weight[k] = 1 - near.weight[k];
    }
  });
  if (std::ranges::all_of(far.weight, [](float weight) { return weight == 0; }))
    samples.pop_back();
  return samples;
}

std::vector<FrameSample> samplesOf(const Image& color, std::vector<std::vector<float>> depths) {
  Ranges ranges{color.width, color.height, {}, {}, {}};
  const std::size_t pixels = depths.front().size(), count = depths.size();
  ranges.near.resize(pixels), ranges.far.resize(pixels), ranges.pure.resize(pixels);
  for (std::size_t k = 0; k < pixels; ++k) {
    float near = depths[0][k], far = near;
    for (const auto& depth : depths) near = std::min(near, depth[k]), far = std::max(far, depth[k]);
    ranges.near[k] = logOf(near), ranges.far[k] = logOf(far);
    ranges.pure[k] = ranges.far[k] - ranges.near[k] <= kSame;
  }
  std::vector<FrameSample> samples;
  for (auto& depth : depths) {
    samples.push_back(
        {color, std::move(depth), std::vector<float>(pixels, 1 / static_cast<float>(count))});
  }
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < color.width; ++x) {
      const std::size_t k = ranges.index(x, y);
      if (ranges.pure[k])
        continue;
      Rgb rest = colorOf(color, x, y);
      std::vector<Rgb> found;
      for (const FrameSample& sample : samples) {
        const auto one = colorAt(color, ranges, x, y, logOf(sample.depth[k]));
        if (!one)
          break;
        found.push_back(*one);
        rest -= *one / static_cast<double>(count);
      }
      if (found.size() != count)
        continue;
      for (std::size_t i = 0; i < count; ++i) setColor(samples[i].color, x, y, found[i] + rest);
    }
  });
  return samples;
}

}  // namespace volute
