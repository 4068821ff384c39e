// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/refined_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/grid/shaded_voxels.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr int kVoxelsASide = 21;

/// Waves of so many voxels, in the middle of the box.
std::shared_ptr<const BrickSlice> wavesOf(double length, int channels) {
  VolumeInfo info;
  info.x = info.y = info.z = kVoxelsASide;
  info.channels = channels;
  info.bounds = {Vec3(-1, 2, 0.5), Vec3(-1, 2, 0.5) + Vec3(2.1, 4.2, 2.1)};
  info.basis = Basis::kCubic;
  std::vector<float> values(info.frameValues());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto voxel = static_cast<int>(i) / channels;
    const Vec3 at(voxel % kVoxelsASide, voxel / kVoxelsASide % kVoxelsASide,
                  voxel / kVoxelsASide / kVoxelsASide);
    const double r = (at - Vec3::Constant(kVoxelsASide / 2)).norm();
    const double wave = 1 + std::cos(2 * M_PI / length * (at.x() + 0.7 * at.y() - 0.4 * at.z()));
    values[i] = static_cast<float>(std::max(0.0, 1 - r / 9) * wave *
                                   (1 + 0.5 * (static_cast<int>(i) % channels)));
  }
  return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, values));
}

std::vector<Segment> raysThrough(const Box3& bounds, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.2, 0.8), way(-1, 1);
  std::vector<Segment> rays;
  for (int i = 0; i < count; ++i) {
    const Vec3 at =
        bounds.min + bounds.size().cwiseProduct(Vec3(share(random), share(random), share(random)));
    const Vec3 direction = Vec3(way(random), way(random), way(random)).normalized();
    rays.push_back({at - 20 * direction, direction, 0, 40});
  }
  return rays;
}

TEST(RefinedSpline, HasTheSplinesBoundsSumAndSupport) {
  const auto spline = wavesOf(6, 1);
  const BrickSlice fine = refinedSpline(*spline), smooth = smoothedSpline(*spline);
  EXPECT_EQ(fine.x(), 2 * kVoxelsASide + 5);
  EXPECT_EQ(smooth.x(), kVoxelsASide + 2);
  const Box3 bounds = VoxelMedium(spline, 1, 1).bounds();
  const auto total = [](const BrickSlice& slice) {
    double sum = 0;
    for (const float value : slice.values()) sum += value;
    return sum;
  };
  for (const BrickSlice* slice : {&fine, &smooth}) {
    EXPECT_EQ(slice->basis(), Basis::kTrilinear);
    const VoxelMedium medium(std::make_shared<const BrickSlice>(*slice), 1, 1);
    EXPECT_LT((medium.bounds().min - bounds.min).norm(), 1e-12);
    EXPECT_LT((medium.bounds().max - bounds.max).norm(), 1e-12);
    for (const float value : slice->values()) EXPECT_GE(value, 0);
  }
  EXPECT_NEAR(total(fine) / total(*spline), 8, 1e-5);
  EXPECT_NEAR(total(smooth) / total(*spline), 1, 1e-5);
}

TEST(RefinedSpline, RaysSeeTheSpline) {
  for (const auto& [length, most] : {std::pair(6.0, 6e-3), std::pair(12.0, 3e-3)}) {
    const auto spline = wavesOf(length, 1);
    const VoxelMedium exact(spline, 1, 1);
    const VoxelMedium fine(std::make_shared<const BrickSlice>(refinedSpline(*spline)), 1, 1);
    const auto rays = raysThrough(exact.bounds(), 2000);
    std::vector<double> expected(rays.size()), got(rays.size());
    exact.opticalDepth(rays, expected);
    fine.opticalDepth(rays, got);
    const double brightest = *std::ranges::max_element(expected);
    for (std::size_t i = 0; i < rays.size(); ++i)
      EXPECT_NEAR(got[i], expected[i], most * brightest) << length;
  }
}

TEST(SplineThrough, KeepsSumSignAndWhatIsEmpty) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> value(0, 1);
  VolumeInfo info;
  info.x = 19, info.y = 12, info.z = 17, info.channels = 2;
  info.bounds = {Vec3::Zero(), Vec3(19, 12, 17)};
  std::vector<float> values(info.frameValues());
  for (float& voxel : values) voxel = value(random) < 0.4F ? 0 : value(random);
  const BrickSlice slice = BrickSlice::fromDense(info, values), made = splineThrough(slice);
  EXPECT_EQ(made.basis(), Basis::kCubic);
  double sum[2]{}, before[2]{};
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x) {
        for (int c = 0; c < 2; ++c) {
          const float coefficient = made.value(x, y, z, c), own = slice.value(x, y, z, c);
          ASSERT_GE(coefficient, 0);
          ASSERT_TRUE(own != 0 || coefficient == 0);
          sum[c] += coefficient, before[c] += own;
        }
      }
    }
  }
  for (int c = 0; c < 2; ++c) EXPECT_NEAR(sum[c] / before[c], 1, 1e-6);
}

TEST(SplineThrough, PassesThroughWhatIsSmooth) {
  auto waves = wavesOf(9, 1);
  BrickSlice blurred(*waves);
  blurred.setBasis(Basis::kCubic);
  const VoxelMedium through(std::make_shared<const BrickSlice>(splineThrough(*waves)), 1, 1);
  const VoxelMedium soft(std::make_shared<const BrickSlice>(blurred), 1, 1);
  double missed = 0, softly = 0;
  const Vec3 voxel = waves->bounds().size() / kVoxelsASide;
  for (int i = 0; i < kVoxelsASide * kVoxelsASide * kVoxelsASide; ++i) {
    const std::array<int, 3> at{i % kVoxelsASide, i / kVoxelsASide % kVoxelsASide,
                                i / kVoxelsASide / kVoxelsASide};
    const Vec3 centre =
        waves->bounds().min + voxel.cwiseProduct(Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5));
    const double own = waves->value(at[0], at[1], at[2]);
    missed += std::pow(through.extinction(centre) - own, 2);
    softly += std::pow(soft.extinction(centre) - own, 2);
  }
  // Troughs that are empty and a kink included.
  EXPECT_LT(std::sqrt(missed), 0.3 * std::sqrt(softly));
}

TEST(SplineThrough, AnEdgeOfDenseSmokeHasNoRim) {
  VolumeInfo info;
  info.x = info.y = info.z = 16;
  info.bounds = {Vec3::Zero(), Vec3::Constant(16)};
  std::vector<float> values(info.frameValues());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 16 > 3 && i % 16 < 12 ? 2 : 0;
  const BrickSlice made = splineThrough(BrickSlice::fromDense(info, values));
  for (int x = 0; x < 16; ++x) EXPECT_EQ(made.value(x, 8, 8), values[static_cast<std::size_t>(x)]);
}

/// What the exact spline scatters and sends, from the same light.
TEST(RefinedSpline, IsLitAsTheSplineIs) {
  for (const int channels : {1, 4}) {
    const auto spline = wavesOf(9, channels);
    const ShadedVoxels exact(spline), refining = ShadedVoxels::refining(spline);
    const auto lightOf = [](const ShadedVoxels& volume) {
      std::vector<VoxelLight> light;
      for (const Vec3& point : volume.lightPoints()) {
        const auto share = static_cast<float>(0.5 + 0.4 * std::sin(2 * point.x() + point.z()));
        light.push_back(VoxelLight(share, 0.5F * share, 0.2F));
      }
      return volume.withLight(volume.forMeans(light, Vec3::Constant(1)));
    };
    const auto rays = raysThrough(exact.bounds(), 500);
    for (const bool lit : {true, false}) {
      const ShadedVoxels one = lit ? lightOf(exact) : exact;
      const ShadedVoxels other = lit ? lightOf(refining) : refining.drawn();
      ASSERT_TRUE(other.march());  // OpenGL draws it
      EXPECT_EQ(other.drawnBytes(), 0);
      EXPECT_GT(refining.drawnBytes(), 0);
      std::vector<Radiance> expected(rays.size()), got(rays.size());
      one.radiance(rays, expected);
      other.radiance(rays, got);
      double brightest = 1e-9;
      for (const Radiance& ray : expected) brightest = std::max(brightest, ray.emitted.maxCoeff());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_LT((got[i].emitted - expected[i].emitted).abs().maxCoeff(), 2e-3 * brightest);
        EXPECT_NEAR(got[i].transmittance, expected[i].transmittance, 2e-3);
      }
    }
  }
}

}  // namespace
}  // namespace volute
