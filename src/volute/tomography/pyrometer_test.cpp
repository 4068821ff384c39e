// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/pyrometer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "volute/tomography/soot_frames.hpp"
#include "volute/tomography/uncertainty.hpp"

namespace volute {
namespace {

/// Narrow channels; a black body of 2000 K has the value 100 in each.
CaptureSpectrum narrow() {
  CaptureSpectrum spectrum;
  const Rgb at(620, 540, 460);
  for (int c = 0; c < 3; ++c) {
    spectrum.lines.push_back({at[c], Rgb::Zero()});
    spectrum.lines.back().weight[c] = 1;
  }
  spectrum.scale = 100 / spectrum.blackBody(2000);
  return spectrum;
}

/// Soot that is hot above and cooler at its edge; what it sends, seen with exact absorption.
struct Flame {
  VolumeGeometry geometry{{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {20, 20, 20}};
  CaptureSpectrum spectrum = narrow();
  Pyrometer pyrometer{spectrum};
  double strength;
  std::vector<TomographyView> views;

  Flame(double extinction, double noise) : strength(extinction) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 6; ++i) {
      const double angle = std::numbers::pi * (i + 0.2) / 6;
      const Vec3 eye(5 * std::cos(angle), 5 * std::sin(angle), i % 2 == 0 ? -0.6 : 0.9);
      const Camera camera = Camera::pinhole({eye, Vec3::Zero()}, 30, 48, 44);
      Image image(48, 44);
      for (int y = 0; y < 44; ++y)
        for (int x = 0; x < 48; ++x) {
          const Rgb light = along(camera.ray(x + 0.5, y + 0.5));
          for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(light[c]);
        }
      const float top = *std::ranges::max_element(image.pixels);
      for (float& value : image.pixels) value += static_cast<float>(noise) * top * normal(random);
      views.push_back({fmt::format("c{}", i), camera, std::move(image)});
    }
  }

  Soot at(const Vec3& p) const {
    const double r = Vec3(p.x() / 0.6, p.y() / 0.5, p.z() / 0.8).squaredNorm();
    const double temperature = 1750 + 250 * p.z() - 250 * r;
    return {temperature, strength * std::pow(std::max(0.0, 1 - r), 1.5)};
  }

  Rgb along(const Segment& ray) const {
    constexpr int kSteps = 200;
    Rgb light = Rgb::Zero(), depth = Rgb::Zero();
    const double begin = 3.5, step = 3.0 / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      const Soot soot = at(ray.at(begin + (k + 0.5) * step));
      if (!(soot.extinction > 0))
        continue;
      const Rgb own = step * pyrometer.extinctionOf(soot);
      light += step * soot.extinction * spectrum.sootEmission(soot.temperature) *
               (-(depth + 0.5 * own)).exp();
      depth += own;
    }
    return light;
  }

  Vec3 centre(std::size_t voxel) const {
    const auto i = static_cast<int>(voxel);
    return geometry.bounds.min + Vec3(i % 20 + 0.5, i / 20 % 20 + 0.5, i / 400 + 0.5) * 0.1;
  }

  /// Root mean square of the relative error of the temperature in the hotter half of what shines.
  double error(std::span<const Soot> found) const {
    std::vector<std::pair<double, double>> all;  // truth, relative error
    double brightest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Soot truth = at(centre(i));
      brightest =
          std::max(brightest, truth.extinction * spectrum.sootEmission(truth.temperature)[0]);
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Soot truth = at(centre(i));
      if (truth.extinction * spectrum.sootEmission(truth.temperature)[0] > 0.05 * brightest)
        all.emplace_back(truth.temperature, found[i].temperature / truth.temperature - 1);
    }
    std::ranges::sort(all, std::greater<>());
    double sum = 0;
    const std::size_t half = all.size() / 2;
    for (std::size_t i = 0; i < half; ++i) sum += all[i].second * all[i].second;
    return std::sqrt(sum / static_cast<double>(half));
  }

  /// The soot of all voxels with a temperature, as a share of what is there.
  double amount(std::span<const Soot> found) const {
    double amount = 0, truth = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!(found[i].temperature > 0))
        continue;
      amount += found[i].extinction;
      truth += at(centre(i)).extinction;
    }
    return amount / truth;
  }
};

TEST(Planck, HasTheRadianceOfABlackBody) {
  // Wien's law: the largest spectral radiance is at 2897.77 um K.
  const double peak = 2897771.955 / 3000;
  EXPECT_GT(planck(peak, 3000), planck(peak - 3, 3000));
  EXPECT_GT(planck(peak, 3000), planck(peak + 3, 3000));
  // Stefan and Boltzmann: sigma T^4 / pi.
  double sum = 0;
  for (double nm = 100; nm < 100000; nm += 2) sum += 2 * planck(nm, 1500);
  EXPECT_NEAR(sum / (5.670374e-8 * std::pow(1500, 4) / std::numbers::pi), 1, 5e-3);
}

TEST(Pyrometer, FindsSootOfAnyTemperature) {
  const CaptureSpectrum spectrum = narrow();
  const Pyrometer pyrometer(spectrum);
  for (const double temperature : {900.0, 1234.0, 1800.0, 2500.0, 3500.0}) {
    const Soot soot = pyrometer.sootOf(0.37 * spectrum.sootEmission(temperature));
    EXPECT_NEAR(soot.temperature, temperature, 1);
    EXPECT_NEAR(soot.extinction, 0.37, 4e-3);
  }
  EXPECT_EQ(pyrometer.sootOf(Rgb(0, 0, 0)).temperature, 0);
  EXPECT_EQ(pyrometer.sootOf(Rgb(1, 0, 0)).temperature, 0);      // one channel tells nothing
  EXPECT_EQ(pyrometer.sootOf(Rgb(0.1, 0.5, 4)).temperature, 0);  // bluer than any soot
  const Soot two = pyrometer.sootOf(spectrum.sootEmission(1500) * Rgb(1, 1, 0));
  EXPECT_NEAR(two.temperature, 1500, 1);
}

TEST(Pyrometer, AThickFlameIsABlackBody) {
  // Emission over extinction is Planck's radiance at every wavelength.
  const CaptureSpectrum spectrum = narrow();
  const Pyrometer pyrometer(spectrum);
  const Soot soot{1700, 3};
  const Rgb black = soot.extinction * spectrum.sootEmission(1700) / pyrometer.extinctionOf(soot);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(black[c] / spectrum.blackBody(1700)[c], 1, 2e-3);
}

TEST(Pyrometer, UncertaintyFollowsWhatDiffersBetweenChannels) {
  const CaptureSpectrum spectrum = narrow();
  const Pyrometer pyrometer(spectrum);
  const Rgb light = 0.5 * spectrum.sootEmission(1700), relative(0.1, 0.1, 0.1);
  const Soot soot = pyrometer.sootOf(light);
  const Soot apart = pyrometer.uncertainty(light, soot, relative, 0);
  const Soot together = pyrometer.uncertainty(light, soot, relative, 1);
  EXPECT_GT(apart.temperature, 0.01);
  EXPECT_LT(together.temperature, 0.05 * apart.temperature);
  EXPECT_NEAR(together.extinction, 0.1, 0.01);  // a flame brighter by a tenth has a tenth more soot
}

TEST(Pyrometer, AVoxelWithoutLightOfItsOwnHasTheDeviationOfThatAround) {
  const CaptureSpectrum spectrum = narrow();
  const Pyrometer pyrometer(spectrum);
  const Rgb light = 0.5 * spectrum.sootEmission(1700);
  const KnownLight around{light, 0.1 * light};
  const auto known = [&](double share) {
    return deviationOf(pyrometer, {1700, 0.5 * share}, {share * light, 0.06 * light}, around, 0.2);
  };
  const Soot dark = known(0);
  EXPECT_NEAR(dark.extinction, 0.03, 1e-3);
  EXPECT_TRUE(dark.temperature > 0.05 * 1700 && dark.temperature < 0.2 * 1700) << dark.temperature;
  // One channel alone tells no temperature either.
  const Soot red = deviationOf(pyrometer, {1700, 0.1},
                               {light * Rgb(0.5, 0, 0), 0.06 * light * Rgb(1, 0, 0)}, around, 0.2);
  EXPECT_TRUE(red.extinction > 0.01 && red.extinction < 0.1) << red.extinction;
  EXPECT_EQ(deviationOf(pyrometer, {}, {light, light}, around, 0.2).extinction, 0);
}

/// A block of 6^3 voxels of soot of 1600 to 1900 K in 10^3.
std::vector<float> block(const CaptureSpectrum& spectrum, double extinction) {
  std::vector<float> emission(3000);
  for (std::size_t i = 0; i < 1000; ++i) {
    const std::size_t x = i % 10, y = i / 10 % 10, z = i / 100;
    if (std::min({x, y, z}) < 2 || std::max({x, y, z}) > 7)
      continue;
    const Rgb sent = extinction * spectrum.sootEmission(1500 + 50 * static_cast<double>(z));
    for (std::size_t c = 0; c < 3; ++c)
      emission[3 * i + c] = static_cast<float>(sent[static_cast<int>(c)]);
  }
  return emission;
}

std::string doubtOf(const CaptureSpectrum& spectrum, std::span<const float> emission) {
  const Pyrometer pyrometer(spectrum);
  SootSummary summary(pyrometer);
  summary.add({{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {10, 10, 10}}, emission);
  const auto doubts = summary.doubts();
  EXPECT_LE(doubts.size(), 1U);
  return doubts.empty() ? "" : doubts.front();
}

TEST(Soot, IsDoubtedWhereTheSpectrumIsNotThatOfThePictures) {
  using testing::HasSubstr;
  const CaptureSpectrum spectrum = narrow();
  const auto emission = block(spectrum, 0.5);
  EXPECT_EQ(doubtOf(spectrum, emission), "");
  EXPECT_EQ(doubtOf(spectrum, block(spectrum, 3)), "");
  EXPECT_EQ(doubtOf(spectrum, std::vector<float>(3000)), "");
  CaptureSpectrum wrong = spectrum;  // blue first
  wrong.scale = spectrum.scale * Rgb(0.025, 1, 40);
  EXPECT_THAT(doubtOf(wrong, emission), HasSubstr("explains the colours of 100 % of the light"));
  wrong.scale = spectrum.scale * Rgb(1, 1 / 1.45, 1);
  EXPECT_THAT(doubtOf(wrong, emission), HasSubstr("red and green tell"));
  wrong.scale = spectrum.scale / 1000;  // pictures are divided by their exposure, it is not
  EXPECT_THAT(doubtOf(wrong, emission), HasSubstr("\"exposure\""));
  wrong.scale = spectrum.scale * 65535;  // in counts
  EXPECT_THAT(doubtOf(wrong, emission), HasSubstr("optical depth is 9"));
}

class FlameOf : public testing::TestWithParam<double> {};

TEST_P(FlameOf, HasItsTemperatureInTheHotHalf) {
  Flame flame(GetParam(), 0.01);
  const std::vector<std::size_t> fitted{0, 1, 2, 3, 4, 5};
  Progress progress;
  const auto found =
      reconstructFlame(flame.views, fitted, flame.geometry, {}, flame.pyrometer, {}, progress);
  ASSERT_TRUE(found) << found.error().message;
  const auto soot = sootOf(flame.pyrometer, flame.geometry.resolution, found->volume);
  EXPECT_LT(flame.error(soot), 0.03);
  EXPECT_NEAR(flame.amount(soot), 1, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Extinctions, FlameOf, testing::Values(0.05, 1.5));

TEST(Pyrometer, WithoutSelfAbsorptionAThickFlameHasWrongTemperatures) {
  Flame flame(1.5, 0.01);
  Progress progress;
  const auto thin = reconstruct(flame.views, flame.geometry, {}, {}, progress);
  ASSERT_TRUE(thin);
  const std::vector<std::size_t> fitted{0, 1, 2, 3, 4, 5};
  const auto thick =
      reconstructFlame(flame.views, fitted, flame.geometry, {}, flame.pyrometer, {}, progress);
  ASSERT_TRUE(thick);
  const auto errorOf = [&](const Reconstruction& of) {
    return flame.error(sootOf(flame.pyrometer, flame.geometry.resolution, of.volume));
  };
  EXPECT_GT(errorOf(*thin), 1.5 * errorOf(*thick));
}

}  // namespace
}  // namespace volute
