// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/frame_edges.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"
#include "volute/math/vec.hpp"

namespace volute {
namespace {

constexpr float kSame = 0.1F;     ///< of distances' logarithms: closer ones are of one surface
constexpr float kSky = 1e9F;      ///< [m]
constexpr int kReach = 2;         ///< [pixels] in which surfaces are looked for
constexpr double kMixed = 0.5;    ///< of a pixel's colour may not be between both surfaces'
constexpr float kFlat = 0.05F;    ///< of logarithms: a neighbour's distance from that of a plane
constexpr double kClearly = 0.5;  ///< of a rest: another explanation is better

/// By which a pixel's distance alone tells the shares of its surfaces wrongly, squared: exactly
/// right in about half of the pixels at a border, off by 0 to 0.5 in the others.
constexpr double kUncovered = 0.04;

float logOf(float depth) {
  return std::log(std::clamp(depth, 1e-3F, kSky));
}

/// What is known of a picture's pixels: the logarithm of the distance, and whether only one surface
/// is seen in and beside the pixel.
struct Surroundings {
  int width = 0, height = 0;
  std::vector<float> logs;
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

Rgb colorOf(const Image& color, int x, int y) {
  return {color.at(x, y, 0), color.at(x, y, 1), color.at(x, y, 2)};
}

/// The colours of the pixels around one that show a surface at one distance alone.
struct NearbyColor {
  Rgb mean = Rgb::Zero();
  Mat3 spread = Mat3::Zero();  ///< covariance
  int pixels = 0;
};

std::optional<NearbyColor> colorAt(const Image& color, const Surroundings& all, int x, int y,
                                   float distance) {
  NearbyColor found;
  Mat3 squares = Mat3::Zero();
  double weights = 0;
  all.around(x, y, kReach, [&](int i, int j) {
    const std::size_t k = all.index(i, j);
    if (!all.pure[k] || std::abs(all.logs[k] - distance) > kSame)
      return;
    const double weight = 1.0 / ((i - x) * (i - x) + (j - y) * (j - y) + 1);
    const Rgb value = colorOf(color, i, j);
    // Welford's: differences of large squares would be noise of their own.
    weights += weight;
    const Rgb before = value - found.mean;
    found.mean += before * (weight / weights);
    squares += weight * outerProduct(before.matrix(), (value - found.mean).matrix());
    ++found.pixels;
  });
  if (found.pixels == 0)
    return std::nullopt;
  if (found.pixels > 1)
    found.spread = squares * (found.pixels / (weights * (found.pixels - 1)));
  return found;
}

void setColor(Image& color, int x, int y, const Rgb& value) {
  for (int c = 0; c < 3; ++c) color.at(x, y, c) = static_cast<float>(value[c]);
}

/// A pixel and its neighbours are at about one distance, or on a plane: 1 / z is linear over the
/// picture of one, however fast it recedes to the horizon.
bool isPure(const Surroundings& all, int x, int y) {
  const float own = all.logs[all.index(x, y)];
  float near = own, far = own;
  all.around(x, y, 1, [&](int i, int j) {
    near = std::min(near, all.logs[all.index(i, j)]);
    far = std::max(far, all.logs[all.index(i, j)]);
  });
  if (far - near <= kSame)
    return true;
  if (x == 0 || y == 0 || x == all.width - 1 || y == all.height - 1)
    return false;
  constexpr std::pair<int, int> kHalfWay[] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  return std::ranges::all_of(kHalfWay, [&](const auto& step) {
    const auto& [i, j] = step;
    const float one = all.logs[all.index(x + i, y + j)], other = all.logs[all.index(x - i, y - j)];
    return std::abs(std::log((std::exp(own - one) + std::exp(own - other)) / 2)) <= kFlat;
  });
}

Surroundings surroundingsOf(const Image& color, std::span<const float> depth) {
  Surroundings all{color.width, color.height, {}, {}};
  for (const float d : depth) all.logs.push_back(logOf(d));
  all.pure.assign(depth.size(), 1);
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < color.width; ++x) all.pure[all.index(x, y)] = isPure(all, x, y);
  });
  return all;
}

/// What is seen in or beside a pixel.
struct SeenSurface {
  std::size_t pixel = 0;  ///< whose distance it has
  float distance = 0;     ///< its logarithm
  std::optional<NearbyColor> color;
};

/// The pixel's own first, then those of its neighbours, the closest pixels first.
std::vector<SeenSurface> surfacesAt(const Image& color, const Surroundings& all, int x, int y) {
  constexpr std::pair<int, int> kNeighbours[] = {{0, 0},  {-1, 0}, {1, 0},   {0, -1}, {0, 1},
                                                 {-1, 1}, {1, 1},  {-1, -1}, {1, -1}};
  std::vector<SeenSurface> surfaces;
  for (const auto& [i, j] : kNeighbours) {
    if (x + i < 0 || y + j < 0 || x + i >= all.width || y + j >= all.height)
      continue;
    const std::size_t pixel = all.index(x + i, y + j);
    const float distance = all.logs[pixel];
    const bool known = std::ranges::any_of(surfaces, [&](const SeenSurface& other) {
      return std::abs(other.distance - distance) <= kSame;
    });
    if (!known)
      surfaces.push_back({pixel, distance, colorAt(color, all, x, y, distance)});
  }
  return surfaces;
}

/// The two surfaces that a pixel shows and the near one's share.
struct Mix {
  Rgb near, far;
  double share = 1, rest = 0;  ///< rest: of the pixel's colour, squared
  std::size_t nearPixel = 0, farPixel = 0;
};

/// Of a stored colour, in each channel: the variance.
Rgb roundingOf(const Rgb& color, FrameSteps steps) {
  return color.abs().unaryExpr([&](double value) {
    if (steps == FrameSteps::kHalf) {
      const double step = value / 1024;
      return step * step / 12;
    }
    const double shade = srgbEncode(value),
                 next = steps == FrameSteps::kSrgb8 ? 1.0 / 255 : 1.0 / 65535;
    const double step = shade + next <= 1 ? srgbDecode(shade + next) - srgbDecode(shade)
                                          : srgbDecode(shade) - srgbDecode(shade - next);
    return step * step / 4;  // dithered, at most
  });
}

/// The variance of a share that a pixel's colour tells: by the noise and the texture of the
/// surfaces' colours and by their rounding, along the difference of both.
double uncertaintyOf(const NearbyColor& near, const NearbyColor& far, double share,
                     FrameSteps steps) {
  const Vec3 between = (near.mean - far.mean).matrix();
  const auto along = [&](const NearbyColor& color) {
    return between.dot((color.pixels > 1 ? color : &color == &near ? far : near).spread * between);
  };
  const Vec3 rounding = roundingOf(near.mean.abs().max(far.mean.abs()), steps).matrix();
  const double contrast = between.squaredNorm();
  return (share * share * along(near) + (1 - share) * (1 - share) * along(far) +
          rounding.dot(between.cwiseProduct(between))) /
         (contrast * contrast);
}

/// @param ownShare  the near surface's share by the pixel's distance alone
std::optional<Mix> mixOf(const Rgb& shown, const SeenSurface& near, const SeenSurface& far,
                         double ownShare, FrameSteps steps) {
  Mix mix{near.color->mean, far.color->mean};
  const Rgb between = mix.near - mix.far;
  const double contrast = between.matrix().squaredNorm();
  if (!(contrast > 0))
    return std::nullopt;
  const double told =
      std::clamp((shown - mix.far).matrix().dot(between.matrix()) / contrast, 0.0, 1.0);
  const auto restAt = [&](double share) {
    return shown - (share * mix.near + (1 - share) * mix.far);
  };
  mix.rest = restAt(told).matrix().squaredNorm();
  if (mix.rest > kMixed * kMixed * contrast)
    return std::nullopt;
  // Colours that hardly differ tell less than the distance does.
  const double doubt = uncertaintyOf(*near.color, *far.color, (told + ownShare) / 2, steps);
  mix.share = ownShare + (told - ownShare) * kUncovered / (kUncovered + doubt);
  const Rgb rest = restAt(mix.share);
  mix.near += rest, mix.far += rest;
  mix.nearPixel = near.pixel, mix.farPixel = far.pixel;
  return mix;
}

/// The near surface's share if the pixel's distance is the mean of both, as renderers write it that
/// filter depths.
double shareOf(const SeenSurface& own, const SeenSurface& near, const SeenSurface& far) {
  const double first = std::exp(near.distance), last = std::exp(far.distance);
  return std::clamp((last - std::exp(own.distance)) / (last - first), 0.0, 1.0);
}

/// The pixel's distance is the mean of those of a mix.
bool isMean(const SeenSurface& own, const SeenSurface& near, const SeenSurface& far, double share) {
  const double mean = share * std::exp(near.distance) + (1 - share) * std::exp(far.distance);
  return std::abs(std::log(mean) - own.distance) <= 2 * kSame;
}

/// Of the pixel's own surface and another beside it, those whose colours explain its own best.
std::optional<Mix> mixOf(const Image& color, const Surroundings& all, int x, int y,
                         FrameSteps steps) {
  const std::vector<SeenSurface> surfaces = surfacesAt(color, all, x, y);
  const Rgb shown = colorOf(color, x, y);
  const SeenSurface& own = surfaces.front();
  std::optional<Mix> best;
  for (const SeenSurface& one : surfaces) {
    for (const SeenSurface& other : surfaces) {
      if (one.distance >= other.distance || !one.color || !other.color)
        continue;
      const bool isOwn = &one == &own || &other == &own;
      const auto mix = isOwn || !own.color
                           ? mixOf(shown, one, other, shareOf(own, one, other), steps)
                           : std::nullopt;
      if (mix && (isOwn || isMean(own, one, other, mix->share)) &&
          (!best || mix->rest < kClearly * best->rest))
        best = mix;
    }
  }
  return best;
}

}  // namespace

std::vector<FrameSample> samplesOf(const Image& color, std::vector<float> depth, FrameSteps steps) {
  const Surroundings all = surroundingsOf(color, depth);
  std::vector<FrameSample> samples(2, {color, std::move(depth), {}});
  FrameSample &near = samples[0], &far = samples[1];
  const std::vector<float> own = near.depth;
  near.weight.assign(own.size(), 1);
  far.weight.assign(own.size(), 0);
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < color.width; ++x) {
      const std::size_t k = all.index(x, y);
      const auto mix = all.pure[k] ? std::nullopt : mixOf(color, all, x, y, steps);
      if (!mix)
        continue;
      setColor(near.color, x, y, mix->near);
      setColor(far.color, x, y, mix->far);
      near.depth[k] = own[mix->nearPixel];
      far.depth[k] = own[mix->farPixel];
      near.weight[k] = static_cast<float>(mix->share);
      far.weight[k] = 1 - near.weight[k];
    }
  });
  if (std::ranges::all_of(far.weight, [](float weight) { return weight == 0; }))
    samples.pop_back();
  return samples;
}

std::vector<FrameSample> samplesOf(const Image& color, std::vector<std::vector<float>> depths) {
  Surroundings all{color.width, color.height, {}, {}};
  const std::size_t pixels = depths.front().size(), count = depths.size();
  all.logs.resize(pixels), all.pure.resize(pixels);
  for (std::size_t k = 0; k < pixels; ++k) {
    float near = depths[0][k], far = near;
    for (const auto& depth : depths) near = std::min(near, depth[k]), far = std::max(far, depth[k]);
    all.logs[k] = logOf(near);
    all.pure[k] = logOf(far) - all.logs[k] <= kSame;
  }
  std::vector<FrameSample> samples;
  for (auto& depth : depths) {
    samples.push_back(
        {color, std::move(depth), std::vector<float>(pixels, 1 / static_cast<float>(count))});
  }
  parallelFor(static_cast<std::size_t>(color.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    std::vector<std::optional<Rgb>> found(count);
    for (int x = 0; x < color.width; ++x) {
      const std::size_t k = all.index(x, y);
      if (all.pure[k])
        continue;
      Rgb rest = colorOf(color, x, y);
      std::size_t unknown = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto nearby = colorAt(color, all, x, y, logOf(samples[i].depth[k]));
        found[i] = nearby ? std::optional(nearby->mean) : std::nullopt;
        if (found[i])
          rest -= *found[i] / static_cast<double>(count);
        else
          ++unknown;
      }
      // What is thinner than a pixel has no colour of its own anywhere: it has what the others
      // leave.
      for (std::size_t i = 0; i < count && unknown < count; ++i) {
        if (unknown == 0)
          setColor(samples[i].color, x, y, *found[i] + rest);
        else
          setColor(samples[i].color, x, y,
                   found[i] ? *found[i] : Rgb(rest * (double(count) / double(unknown))));
      }
    }
  });
  return samples;
}

}  // namespace volute
