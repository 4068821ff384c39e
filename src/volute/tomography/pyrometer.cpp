// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/pyrometer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/tomography/lamp_light.hpp"

namespace volute {
namespace {

constexpr double kColdest = 700, kHottest = 4000, kStep = 25;

}  // namespace

Pyrometer::Pyrometer(const CaptureSpectrum& spectrum) {
  for (double temperature = kColdest; temperature <= kHottest; temperature += kStep) {
    const Rgb sent = spectrum.sootEmission(temperature);
    rows_.push_back({temperature, sent.log(), sent / spectrum.blackBody(temperature)});
  }
}

Pyrometer::Row Pyrometer::at(double temperature) const {
  const double place = std::clamp((temperature - kColdest) / kStep, 0.0,
                                  static_cast<double>(rows_.size() - 1) - 1e-9);
  const auto i = static_cast<std::size_t>(place);
  // In 1/T logarithms are nearly straight.
  const Row &a = rows_[i], &b = rows_[i + 1];
  const double share =
      (1 / temperature - 1 / a.temperature) / (1 / b.temperature - 1 / a.temperature);
  return {temperature, a.emission + share * (b.emission - a.emission),
          a.extinction + share * (b.extinction - a.extinction)};
}

Soot Pyrometer::sootOf(const Rgb& emission, const Around& around) const {
  // Of a channel: calibration and shape are off by shares of it, noise by a share of the brightest.
  constexpr double kShare = 0.02, kOfBrightest = 0.02, kDarkest = 1e-3;
  const double brightest = emission.maxCoeff();
  if (!(brightest > 0))
    return {};
  Rgb weight = Rgb::Zero(), logarithm = Rgb::Zero();
  int channels = 0;
  for (int c = 0; c < 3; ++c) {
    if (!(emission[c] > kDarkest * brightest))
      continue;
    const double noise = std::max(around.noise, kOfBrightest * brightest);
    weight[c] = 1 / (kShare * kShare + std::pow(noise / emission[c], 2));
    logarithm[c] = std::log(emission[c]);
    ++channels;
  }
  if (channels < 2)
    return {};
  const double weights = weight.sum();
  const auto misfit = [&](const Row& row, double& extinction) {
    const Rgb difference = logarithm - row.emission;
    extinction = (weight * difference).sum() / weights;
    const double unusual =
        around.temperature > 0 ? (row.temperature / around.temperature - 1) / around.spread : 0;
    return (weight * (difference - extinction).square()).sum() + unusual * unusual;
  };
  std::size_t best = 0;
  double least = 0, extinction = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (const double now = misfit(rows_[i], extinction); i == 0 || now < least) {
      least = now;
      best = i;
    }
  }
  if (best == 0 || best + 1 == rows_.size())
    return {};
  double low = rows_[best - 1].temperature, high = rows_[best + 1].temperature;
  constexpr double kGolden = 0.6180339887498949, kExact = 0.05;
  while (high - low > kExact) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    double unused = 0;
    if (misfit(at(a), unused) < misfit(at(b), unused))
      high = b;
    else
      low = a;
  }
  const double temperature = 0.5 * (low + high);
  misfit(at(temperature), extinction);
  return {temperature, std::exp(extinction)};
}

Soot Pyrometer::uncertainty(const Rgb& emission, const Soot& soot, const Rgb& relative,
                            double correlation) const {
  constexpr double kChange = 0.02;
  if (!(soot.temperature > 0))
    return {};
  Rgb temperature = Rgb::Zero(), extinction = Rgb::Zero();  // by a channel's logarithm
  for (int c = 0; c < 3; ++c) {
    Rgb more = emission;
    more[c] *= 1 + kChange;
    const Soot changed = sootOf(more);
    if (!(changed.temperature > 0))
      continue;
    temperature[c] = std::log(changed.temperature / soot.temperature) / std::log1p(kChange);
    extinction[c] = std::log(changed.extinction / soot.extinction) / std::log1p(kChange);
  }
  const auto spread = [&](const Rgb& by) {
    const Rgb parts = by * relative;
    const double apart = parts.square().sum(), together = std::pow(parts.sum(), 2);
    return std::sqrt((1 - correlation) * apart + correlation * together);
  };
  return {spread(temperature), spread(extinction)};
}

Rgb Pyrometer::extinctionOf(const Soot& soot) const {
  return soot.temperature > 0 ? Rgb(soot.extinction * at(soot.temperature).extinction)
                              : Rgb(Rgb::Zero());
}

std::vector<float> meansAround(const std::array<int, 3>& resolution,
                               std::span<const float> emission) {
  const auto& n = resolution;
  std::vector<float> means(emission.begin(), emission.end()), along(emission.size());
  // An axis after another: of what is inside the volume.
  std::size_t stride = 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto size = static_cast<std::size_t>(n[axis]);
    std::swap(means, along);
    parallelRanges(means.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t place = i / stride % size;
        float sum = along[i];
        int count = 1;
        if (place > 0)
          sum += along[i - stride], ++count;
        if (place + 1 < size)
          sum += along[i + stride], ++count;
        means[i] = sum / static_cast<float>(count);
      }
    });
    stride *= size;
  }
  return means;
}

std::vector<Soot> sootOf(const Pyrometer& pyrometer, const std::array<int, 3>& resolution,
                         std::span<const float> emission) {
  constexpr double kDarkest = 0.02, kNoise = 0.02;
  const double brightest = emission.empty() ? 0 : *std::ranges::max_element(emission);
  Rgb whole = Rgb::Zero();
  for (std::size_t i = 0; i < emission.size(); ++i) whole[static_cast<int>(i % 3)] += emission[i];
  const Pyrometer::Around around{kNoise * brightest, pyrometer.sootOf(whole).temperature};
  const std::vector<float> means = meansAround(resolution, emission);
  std::vector<Soot> soot(emission.size() / 3);
  parallelRanges(soot.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float *nearby = &means[3 * i], *own = &emission[3 * i];
      const Rgb light(nearby[0], nearby[1], nearby[2]);
      if (!(light.maxCoeff() > kDarkest * brightest))
        continue;
      soot[i] = pyrometer.sootOf(light, around);
      // Its own light, by colours that may differ from those around it.
      const double usual = soot[i].temperature;
      const Soot alone =
          pyrometer.sootOf(Rgb(own[0], own[1], own[2]), {around.noise, usual, kNearSoot});
      if (usual > 0 && alone.temperature > 0)
        soot[i] = alone;
      else
        soot[i].extinction *= (own[0] + own[1] + own[2]) / light.sum();
    }
  });
  return soot;
}

Soot deviationOf(const Pyrometer& pyrometer, const Soot& soot, const KnownLight& own,
                 const KnownLight& around, double correlation) {
  constexpr double kAround = 27;
  if (!(soot.temperature > 0))
    return {};
  const auto spreadOf = [&](const KnownLight& known, double count, const Soot& of) {
    Rgb relative = Rgb::Zero();
    for (int c = 0; c < 3; ++c) {
      if (known.light[c] > 0)
        relative[c] = std::min(known.deviation[c] / known.light[c], 1.0) / std::sqrt(count);
    }
    return pyrometer.uncertainty(known.light, of, relative, correlation);
  };
  // The voxel's own colours, kept near those around it, whose errors are apart.
  const Soot alone = spreadOf(own, 1, soot);
  if (alone.temperature > 0) {
    const double kept = 1 / std::hypot(1 / alone.temperature, 1 / kNearSoot),
                 temperature = std::hypot(kept, spreadOf(around, kAround, soot).temperature);
    return {temperature * soot.temperature,
            alone.extinction * temperature / alone.temperature * soot.extinction};
  }
  // Its own colours tell nothing: the soot is that around it, by the voxel's share of the light.
  Soot nearby = pyrometer.sootOf(around.light);
  if (!(nearby.temperature > 0))
    nearby = {soot.temperature, around.light.sum() / pyrometer.sootColours(soot.temperature).sum()};
  const Soot spread = spreadOf(around, kAround, nearby);
  return {std::hypot(kNearSoot, spread.temperature) * soot.temperature,
          std::hypot(spread.extinction * soot.extinction,
                     nearby.extinction * own.deviation.sum() / around.light.sum())};
}

std::vector<float> sootAttenuation(const Pyrometer& pyrometer, std::span<const Soot> soot,
                                   const Camera& camera, const VolumeGeometry& geometry,
                                   std::span<const float> emission) {
  const std::size_t voxels = geometry.voxels();
  std::array<std::vector<float>, 3> takes, sends;
  for (std::size_t c = 0; c < 3; ++c) {
    takes[c].resize(voxels);
    sends[c].resize(3 * voxels);
  }
  for (std::size_t i = 0; i < voxels; ++i) {
    const Rgb extinction = pyrometer.extinctionOf(soot[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      takes[c][i] = static_cast<float>(extinction[static_cast<int>(c)]);
      sends[c][3 * i] = emission[3 * i + c];
    }
  }
  std::vector<float> factors(3 * static_cast<std::size_t>(camera.width()) * camera.height());
  for (std::size_t c = 0; c < 3; ++c) {
    const auto own = selfAttenuation(camera, geometry, takes[c], sends[c]);
    for (std::size_t i = 0; i < own.size(); ++i) factors[3 * i + c] = own[i];
  }
  return factors;
}

Result<Reconstruction> reconstructFlame(std::span<TomographyView> views,
                                        std::span<const std::size_t> fitted,
                                        const VolumeGeometry& geometry,
                                        const TomographyOptions& options,
                                        const Pyrometer& pyrometer,
                                        std::span<const float> warmStart, Progress& progress) {
  constexpr int kRounds = 4;
  constexpr double kThin = 0.003;
  std::vector<Image> given;
  for (const TomographyView& view : views) given.push_back(view.radiance);
  TomographyOptions now = options;
  Reconstruction flame;
  flame.volume.assign(warmStart.begin(), warmStart.end());
  for (int round = 0;; ++round) {
    std::vector<TomographyView> some;
    for (const std::size_t v : fitted) some.push_back(views[v]);
    VOLUTE_ASSIGN(flame, reconstruct(some, geometry, now, flame.volume, progress));
    if (round == kRounds)
      return flame;
    if (flame.choice)
      now.choice = flame.choice;
    double change = 0;
    const auto soot = sootOf(pyrometer, geometry.resolution, flame.volume);
    for (std::size_t v = 0; v < views.size(); ++v) {
      const auto factors =
          sootAttenuation(pyrometer, soot, views[v].camera, geometry, flame.volume);
      for (std::size_t i = 0; i < factors.size(); ++i) {
        const float next = factors[i] * given[v].pixels[i];
        const double light = std::abs(given[v].pixels[i]);
        if (light > 0)
          change = std::max(change, std::abs(next - views[v].radiance.pixels[i]) / light);
        views[v].radiance.pixels[i] = next;
      }
    }
    if (change < kThin)
      return flame;
  }
}

}  // namespace volute
