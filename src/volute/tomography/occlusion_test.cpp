// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/occlusion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

constexpr std::size_t kCovered = 2;
constexpr int kLeft = 21, kRight = 26;  // of a dark pole before view kCovered [pixels]

TestScene withPole(double noise, int right = kRight) {
  TestScene scene(8, noise);
  TomographyView& view = scene.views[kCovered];
  for (int y = 0; y < view.radiance.height; ++y)
    for (int x = kLeft; x < right; ++x)
      for (int c = 0; c < 3; ++c) view.radiance.at(x, y, c) = 0;
  return scene;
}

std::vector<float> solved(const TestScene& scene) {
  TomographyOptions options;
  options.regularization = Regularization::kTv;
  options.lambda = 1e-4;
  options.iterations = 80;
  Progress progress;
  const auto result = reconstruct(scene.views, scene.geometry, options, {}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? result->volume : std::vector<float>(scene.truth.size());
}

/// Relative L2 over the voxels that the pole hides from its view.
double errorBehindPole(const TestScene& scene, const std::vector<float>& volume) {
  const auto& n = scene.geometry.resolution;
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < scene.geometry.voxels(); ++i) {
    const Vec3 voxel(static_cast<double>(i % n[0]) + 0.5,
                     static_cast<double>(i / n[0] % n[1]) + 0.5,
                     static_cast<double>(i / n[0] / n[1]) + 0.5);
    const auto place = scene.views[kCovered].camera.project(
        scene.geometry.bounds.min + voxel.cwiseProduct(scene.geometry.voxelSize()));
    if (!place || place->x() < kLeft || place->x() > kRight)
      continue;
    for (std::size_t c = 0; c < 3; ++c) {
      difference += std::pow(static_cast<double>(volume[3 * i + c]) - scene.truth[3 * i + c], 2);
      size += std::pow(scene.truth[3 * i + c], 2);
    }
  }
  return std::sqrt(difference / size);
}

TEST(Occlusion, APoleCarvesNoHole) {
  TestScene scene = withPole(0);
  const double carved = errorBehindPole(scene, solved(scene));
  Progress progress;
  const auto found = findOcclusions(scene.views, scene.geometry, progress);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ((*found)[0].view, kCovered);
  leaveOut((*found)[0], scene.views[kCovered]);
  const double kept = errorBehindPole(scene, solved(scene));
  RecordProperty("carved", std::to_string(carved));
  RecordProperty("kept", std::to_string(kept));
  EXPECT_LT(kept, 0.4 * carved) << kept << " instead of " << carved;
  // Pixels of the pole alone, and one to each side.
  const auto& pixels = (*found)[0].pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int x = static_cast<int>(i % 48);
    if (pixels[i] != 0) {
      EXPECT_TRUE(x >= kLeft - 4 && x < kRight + 4) << x;
    }
  }
}

TEST(Occlusion, APoleMayHideMoreThanHalfOfTheLight) {
  TestScene scene = withPole(0, kLeft + 11);
  Progress progress;
  const auto found = findOcclusions(scene.views, scene.geometry, progress);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->size(), 1U);
  EXPECT_EQ((*found)[0].view, kCovered);
  EXPECT_TRUE((*found)[0].share > 0.5 && (*found)[0].share < 0.9) << (*found)[0].share;
}

TEST(Occlusion, NoneInCleanPictures) {
  for (const int cameras : {4, 5, 8}) {
    for (const double noise : {0.0, 0.02}) {
      const TestScene scene(cameras, noise);
      Progress progress;
      const auto found = findOcclusions(scene.views, scene.geometry, progress);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_TRUE(found->empty()) << cameras << " cameras, noise " << noise;
    }
  }
}

/// Columns of light: what three cameras see of them may be in the gaps that the fourth sees.
TEST(Occlusion, AGapThatOthersDoNotSeeIsNoObstacle) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    TestScene scene(4);
    std::mt19937 random(seed);
    const VolumeGeometry fine{scene.geometry.bounds, {40, 40, 40}};
    std::vector<float> volume(3 * fine.voxels());
    for (int column = 0; column < 8; ++column) {
      const std::size_t left = 4 + random() % 28, front = 4 + random() % 28, low = 4 + random() % 8;
      for (std::size_t z = low; z < low + 20; ++z)
        for (std::size_t y = front; y < front + 5; ++y)
          for (std::size_t x = left; x < left + 5; ++x)
            std::fill_n(&volume[3 * ((z * 40 + y) * 40 + x)], 3, 1.0F);
    }
    for (TomographyView& view : scene.views)
      view.radiance = projectVolume(volume, fine, Basis::kBox, view.camera, 4);
    Progress progress;
    const auto found = findOcclusions(scene.views, scene.geometry, progress);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(found->empty()) << "seed " << seed;
  }
}

TEST(Occlusion, ACameraThatDoesNotFitIsNotTakenForOne) {
  TestScene scene(5);
  CameraCorrection lens;
  lens.values[CameraCorrection::kLens] = 20;
  scene.views[3].camera = *corrected(scene.views[3].camera, lens);
  Progress progress;
  const auto found = findOcclusions(scene.views, scene.geometry, progress);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->empty());
}

TEST(Occlusion, OfFewViewsNoneIsFound) {
  TestScene scene = withPole(0);
  scene.views.erase(scene.views.begin() + 3, scene.views.end());
  Progress progress;
  const auto found = findOcclusions(scene.views, scene.geometry, progress);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->empty());
}

}  // namespace
}  // namespace volute
