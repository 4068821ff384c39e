// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/background_drift.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Pixels that are looked at, of one channel.
struct Samples {
  std::vector<float> picture, background;
};

struct DriftLine {
  double gain = 1, offset = 0;

  double of(double background) const { return gain * background + offset; }
};

double middleOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Of noise of about a step of stored values, most of which are the same: by the mean of the
/// nearest nine tenths, which for noise of many steps is less than by the middle.
double spreadOfSteps(std::vector<float> off) {
  constexpr double kNormalOfMean = 1.2533;
  std::ranges::sort(off);
  off.resize(off.size() * 9 / 10);
  const double sum = std::accumulate(off.begin(), off.end(), 0.0);
  return kNormalOfMean * sum / static_cast<double>(std::max<std::size_t>(1, off.size()));
}

/// The median distance to the line, and the share of pixels within six times its spread of a normal
/// distribution.
struct Spread {
  double median = 0, share = 0;
};

Spread spreadAround(const Samples& samples, const DriftLine& line) {
  std::vector<float> off(samples.picture.size());
  for (std::size_t i = 0; i < off.size(); ++i)
    off[i] = static_cast<float>(std::abs(samples.picture[i] - line.of(samples.background[i])));
  std::vector<float> copy = off;
  const double median = middleOf(copy);
  constexpr double kWithin = 6 * 1.4826;
  const auto within = std::ranges::count_if(off, [&](float o) { return o <= kWithin * median; });
  return {median, static_cast<double>(within) / static_cast<double>(off.size())};
}

/// One step of reweighted least squares. The offset is held near 0 by as much as the background's
/// own variation leaves it open.
DriftLine refitted(const Samples& samples, const DriftLine& line, double spread) {
  constexpr double kTukey = 4.685, kHeld = 1e-2;
  double sum = 0, b = 0, p = 0, bb = 0, bp = 0;
  for (std::size_t i = 0; i < samples.picture.size(); ++i) {
    const double behind = samples.background[i], seen = samples.picture[i];
    const double u = (seen - line.of(behind)) / std::max(kTukey * spread, 1e-12);
    if (!(std::abs(u) < 1))
      continue;
    const double w = (1 - u * u) * (1 - u * u);
    sum += w;
    b += w * behind;
    p += w * seen;
    bb += w * behind * behind;
    bp += w * behind * seen;
  }
  const double held = kHeld * sum;  // of the offset: as many pixels that say 0
  const double determinant = bb * (sum + held) - b * b;
  if (!(bb > 0) || !(determinant > 1e-12 * bb * sum))
    return line;
  return {(bp * (sum + held) - b * p) / determinant, (bb * p - b * bp) / determinant};
}

/// Nothing where most pixels do not follow any such line.
std::optional<DriftLine> fitLine(const Samples& samples) {
  constexpr int kSteps = 12;
  constexpr double kNormal = 1.4826, kMax = 0.7;
  // From the median of the ratios, which half of the pixels may spoil.
  std::vector<float> ratios;
  for (std::size_t i = 0; i < samples.picture.size(); ++i) {
    if (samples.background[i] > 0)
      ratios.push_back(samples.picture[i] / samples.background[i]);
  }
  DriftLine line;
  if (2 * ratios.size() > samples.picture.size())
    line.gain = middleOf(ratios);
  for (int step = 0; step < kSteps; ++step)
    line = refitted(samples, line, kNormal * spreadAround(samples, line).median);
  const Spread spread = spreadAround(samples, line);
  if (spread.share < kMax)
    return std::nullopt;
  return line;
}

}  // namespace

Image BackgroundDrift::applied(const Image& background) const {
  Image now = background;
  for (std::size_t i = 0; i < now.pixels.size(); ++i)
    now.pixels[i] = static_cast<float>(gain[i % 3] * now.pixels[i] + offset[i % 3]);
  return now;
}

std::vector<std::uint8_t> pixelsBeside(const Camera& camera, const Box3& bounds) {
  constexpr int kApart = 2;
  const int width = camera.width(), height = camera.height();
  std::vector<std::uint8_t> beside(static_cast<std::size_t>(width) * height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      if (bounds.intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end}).empty())
        continue;
      for (int v = std::max(0, y - kApart); v <= std::min(height - 1, y + kApart); ++v) {
        for (int u = std::max(0, x - kApart); u <= std::min(width - 1, x + kApart); ++u)
          beside[static_cast<std::size_t>(v) * width + u] = 0;
      }
    }
  }
  return beside;
}

std::optional<BackgroundDrift> findBackgroundDrift(const Image& picture, const Image& background,
                                                   std::span<const std::uint8_t> pixels) {
  VOLUTE_ASSERT(picture.channels == 3 && picture.pixels.size() == background.pixels.size() &&
                3 * pixels.size() == picture.pixels.size());
  constexpr std::size_t kFewest = 100;
  constexpr double kPays = 0.9;
  BackgroundDrift drift;
  bool pays = false;
  for (std::size_t c = 0; c < 3; ++c) {
    Samples samples;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const float seen = picture.pixels[3 * i + c], behind = background.pixels[3 * i + c];
      if (pixels[i] == 0 || !std::isfinite(seen) || !std::isfinite(behind))
        continue;
      samples.picture.push_back(seen);
      samples.background.push_back(behind);
    }
    if (samples.picture.size() < kFewest)
      return std::nullopt;
    const auto line = fitLine(samples);
    if (!line || !(line->gain > 0))
      return std::nullopt;
    const double before = spreadAround(samples, {}).median;
    pays |= spreadAround(samples, *line).median < kPays * before;
    drift.gain[c] = line->gain;
    drift.offset[c] = line->offset;
  }
  return pays ? std::optional(drift) : std::nullopt;
}

std::optional<Rgb> findPedestal(const Image& picture, std::span<const std::uint8_t> pixels) {
  VOLUTE_ASSERT(picture.channels == 3 && 3 * pixels.size() == picture.pixels.size());
  constexpr std::size_t kFewest = 100, kFewestOfAHalf = 30;
  constexpr double kNormal = 1.4826, kSigmas = 2.5, kEven = 0.1, kOfBrightest = 4e-4;
  constexpr double kWithin = 6 * kNormal, kMax = 0.85;
  const float brightest = *std::ranges::max_element(picture.pixels);
  const auto valuesWhere = [&](std::size_t channel, auto&& where) {
    std::vector<float> values;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i] != 0 && where(i) && std::isfinite(picture.pixels[3 * i + channel]))
        values.push_back(picture.pixels[3 * i + channel]);
    }
    return values;
  };
  const auto width = static_cast<std::size_t>(picture.width);
  // The middle of the pixels, whose halves are compared.
  std::vector<float> columns, rows;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] != 0) {
      columns.push_back(static_cast<float>(i % width));
      const std::size_t row = i / width;
      rows.push_back(static_cast<float>(row));
    }
  }
  if (columns.size() < kFewest)
    return std::nullopt;
  const auto middleX = static_cast<std::size_t>(middleOf(columns));
  const auto middleY = static_cast<std::size_t>(middleOf(rows));
  Rgb pedestal = Rgb::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    auto values = valuesWhere(c, [](std::size_t) { return true; });
    if (values.size() < kFewest)
      return std::nullopt;
    const double middle = middleOf(values);
    for (float& value : values) value = static_cast<float>(std::abs(value - middle));
    const double spread = std::max(kNormal * middleOf(values), spreadOfSteps(values));
    // Noise that is cut off at 0 stands above it by less than its spread.
    if (!(middle > kOfBrightest * brightest) || !(middle > kSigmas * spread))
      continue;
    // Noise has no side, a background that is not even has one.
    const double floor = std::max(spread, 1e-3 * middle);
    const auto within =
        std::ranges::count_if(values, [&](float off) { return off <= kWithin * floor; });
    if (static_cast<double>(within) < kMax * static_cast<double>(values.size()))
      return std::nullopt;
    for (int half = 0; half < 4; ++half) {
      auto part = valuesWhere(c, [&](std::size_t i) {
        const bool first = half < 2 ? i % width < middleX : i / width < middleY;
        return first == (half % 2 == 0);
      });
      const double uncertain = kSigmas * spread / std::sqrt(static_cast<double>(part.size() + 1));
      if (part.size() >= kFewestOfAHalf &&
          std::abs(middleOf(part) - middle) > kEven * middle + uncertain)
        return std::nullopt;
    }
    pedestal[c] = middle;
  }
  return pedestal.maxCoeff() > 0 ? std::optional(pedestal) : std::nullopt;
}

}  // namespace volute
