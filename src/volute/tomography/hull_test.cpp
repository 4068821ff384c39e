// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "volute/image/srgb.hpp"
#include "volute/tomography/box_blur.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

std::vector<std::vector<std::uint8_t>> silhouettesOf(const TestScene& scene) {
  std::vector<std::vector<std::uint8_t>> out;
  for (const TomographyView& view : scene.views) out.push_back(dilatedSilhouette(view, {}));
  return out;
}

TEST(Noise, IsEstimatedFromNeighbours) {
  const TestScene scene(3, 0.05);
  for (const TomographyView& view : scene.views) EXPECT_NEAR(noiseOf(view), 0.05, 0.01);
  const TestScene clean(3);
  EXPECT_LT(noiseOf(clean.views[0]), 1e-3);
}

/// Stored as integers, whose steps and whose end at 0 hide most of the noise in the dark.
TEST(Noise, OfIntegersIsFound) {
  constexpr float kStep = 1 / 255.0F;
  for (const double noise : {0.4, 0.8, 1.2, 2.0}) {
    TestScene scene(1, 0, 0, 96, 88);
    TomographyView& view = scene.views[0];
    const float scale = 0.9F / *std::ranges::max_element(view.radiance.pixels);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const auto lit = [](const std::vector<std::uint8_t>& mask) {
      return static_cast<double>(std::ranges::count(mask, 1)) / static_cast<double>(mask.size());
    };
    for (float& value : view.radiance.pixels) value *= scale;
    const double before = lit(dilatedSilhouette(view, {}));
    for (float& value : view.radiance.pixels)
      value = kStep *
              static_cast<float>(std::max(0.0, std::round(value / kStep + noise * normal(random))));
    EXPECT_GT(noiseOf(view), 0.5 * noise * kStep) << noise;
    EXPECT_LT(noiseOf(view), 1.5 * std::hypot(noise, 0.29) * kStep) << noise;
    EXPECT_LT(lit(dilatedSilhouette(view, {})), before + 0.1) << noise;
  }
}

/// Films smooth noise, whose mean stays, and leave fewer zeros of it.
TEST(Noise, OfFilmsLightsNoPixels) {
  TestScene scene(1, 0, 0, 96, 88);
  TomographyView& view = scene.views[0];
  const float scale = 0.9F / *std::ranges::max_element(view.radiance.pixels);
  for (float& value : view.radiance.pixels) value *= scale;
  const auto lit = [&] {
    const auto mask = dilatedSilhouette(view, {});
    return static_cast<double>(std::ranges::count(mask, 1)) / static_cast<double>(mask.size());
  };
  const double before = lit();
  Image noise(view.radiance.width, view.radiance.height);
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (float& value : noise.pixels) value = std::max(0.0F, 0.003F * normal(random));
  noise = boxBlurred(noise, 1.07);
  for (std::size_t i = 0; i < noise.pixels.size(); ++i) {
    float& value = view.radiance.pixels[i];
    const double stored = std::round(255 * srgbEncode(value + noise.pixels[i])) / 255;
    value = static_cast<float>(srgbDecode(stored));
  }
  EXPECT_LT(lit(), before + 0.1);
}

TEST(Silhouette, IsDilatedByOnePixel) {
  TomographyView view{"c", Camera::pinhole({}, 30, 9, 7), Image(9, 7)};
  view.radiance.at(4, 3, 1) = -1;  // darker than the background counts too
  view.radiance.at(8, 0, 0) = 1;
  const auto mask = dilatedSilhouette(view, 0.0);
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x) {
      const bool lit = (std::abs(x - 4) <= 1 && std::abs(y - 3) <= 1) || (x >= 7 && y <= 1);
      EXPECT_EQ(mask[y * 9 + x], lit) << x << ' ' << y;
    }
}

TEST(Silhouette, IsUnknownWherePixelsDoNotCount) {
  TomographyView view{"c", Camera::pinhole({}, 30, 4, 1), Image(4, 1)};
  view.weight = {1, 0, 1, 1};
  const auto mask = dilatedSilhouette(view, {});
  EXPECT_EQ(mask, (std::vector<std::uint8_t>{0, 1, 0, 0}));
}

TEST(Silhouette, OwnMaskWins) {
  TomographyView view{"c", Camera::pinhole({}, 30, 5, 1), Image(5, 1)};
  view.radiance.at(0, 0) = 1;
  view.silhouette = {0, 0, 0, 0, 7};
  EXPECT_EQ(dilatedSilhouette(view, {}), (std::vector<std::uint8_t>{0, 0, 0, 1, 1}));
}

class HullTest : public testing::TestWithParam<double> {};

TEST_P(HullTest, LosesNoLightAndIsTight) {
  const TestScene scene(8, GetParam());
  const auto hull = visualHull(scene.views, silhouettesOf(scene), scene.geometry);
  double lost = 0, all = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const double light = scene.truth[3 * i];
    all += light;
    lost += hull[i] ? 0 : light;
  }
  EXPECT_LE(lost, 0.002 * all);
  const auto lit = std::ranges::count_if(hull, [](auto v) { return v != 0; });
  EXPECT_LT(static_cast<double>(lit), 0.4 * static_cast<double>(hull.size()));
}

INSTANTIATE_TEST_SUITE_P(Noise, HullTest, testing::Values(0.0, 0.02));

/// The scene in pictures in which half a degree is 4.5 pixels, on fine voxels.
struct FineScene : TestScene {
  static constexpr int kFine = 60;
  VolumeGeometry fine{geometry.bounds, {kFine, kFine, kFine}};
  std::vector<float> light;

  FineScene() : TestScene(8, 0, 0, 288, 264), light(blobs(fine, 0)) {}

  std::vector<std::uint8_t> hull() const { return visualHull(views, silhouettesOf(*this), fine); }

  /// The share of voxels with light that the hull has not.
  double lost(std::span<const std::uint8_t> hull) const {
    double lost = 0, all = 0;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      all += light[3 * i] > 0 ? 1 : 0;
      lost += light[3 * i] > 0 && hull[i] == 0 ? 1 : 0;
    }
    return lost / all;
  }
};

TEST(Hull, ErrorOfSightsCarvesNoLight) {
  FineScene scene;
  const Camera right = scene.views[2].camera;
  const Camera wrong = right.turned(right.eye(), right.down(), 0.5 * std::numbers::pi / 180);
  const auto clean = scene.hull();
  scene.views[2].camera = wrong;
  const double carved = scene.lost(scene.hull());
  scene.views[2].sightError = 2.25;  // it is 4.5 pixels: two standard deviations
  const double kept = scene.lost(scene.hull());
  RecordProperty("carved", std::to_string(carved));
  RecordProperty("kept", std::to_string(kept));
  EXPECT_GT(carved, 3e-4);
  EXPECT_LT(kept, 0.1 * carved);
  // Of a camera that is right the hull grows by less than a voxel on the mean.
  scene.views[2].camera = right;
  const auto grown = std::ranges::count(scene.hull(), 1), before = std::ranges::count(clean, 1);
  EXPECT_GE(grown, before);
  EXPECT_LT(static_cast<double>(grown), 1.08 * static_cast<double>(before));
}

TEST(Hull, VoxelThatNoCameraSeesStays) {
  const VolumeGeometry geometry{{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, {4, 4, 4}};
  // A narrow view of the middle, in which nothing is lit.
  const TomographyView view{"c", Camera::orthographic({Vec3(0, -5, 0), Vec3::Zero()}, 1, 16, 16),
                            Image(16, 16)};
  const std::vector<std::vector<std::uint8_t>> dark{dilatedSilhouette(view, {})};
  const auto hull = visualHull({&view, 1}, dark, geometry);
  auto at = [&](int x, int y, int z) { return hull[(z * 4 + y) * 4 + x]; };
  EXPECT_EQ(at(1, 2, 1), 0);
  EXPECT_EQ(at(0, 2, 1), 1);
  EXPECT_EQ(at(1, 0, 3), 1);
}

}  // namespace
}  // namespace volute
