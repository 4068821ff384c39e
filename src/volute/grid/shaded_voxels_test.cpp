// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/shaded_voxels.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>

#include "volute/grid/bricks.hpp"
#include "volute/grid/voxel_march.hpp"
#include "volute/medium/conformance.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

/// Some voxels of 0..1, others empty, in two bricks and a bit on each axis.
ShadedVoxels shadedMedium(int channels, bool lit, bool grey = false,
                          Basis basis = Basis::kTrilinear) {
  VolumeInfo info;
  info.x = 18, info.y = 17, info.z = 9;
  info.channels = channels;
  info.bounds = {Vec3(-1, 0.5, 2), Vec3(1, 2, 3)};
  info.basis = basis;
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> values(info.frameValues());
  for (float& value : values) value = 4 * std::max(0.0F, uniform(random));
  const ShadedVoxels dark(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
  if (!lit)
    return dark;
  std::vector<VoxelLight> light;
  for (const Vec3& p : dark.lightPoints()) {
    const double a = std::exp(p.x()), b = 1 + std::sin(3 * p.y());
    light.push_back((grey ? Rgb(a * Rgb(1, 0.5, 0.25)) : Rgb(a, b, 0.3)).cast<float>());
  }
  return dark.withLight(light);
}

conformance::MediumUnderTest shadedUnderTest(int channels, bool lit, bool grey = false,
                                             Basis basis = Basis::kTrilinear) {
  const ShadedVoxels medium = shadedMedium(channels, lit, grey, basis);
  conformance::Traits traits;
  const BrickSlice& slice = medium.slice();
  const std::array<int, 3> count{slice.x(), slice.y(), slice.z()};
  for (int axis = 0; axis < 3; ++axis) {
    const double voxel = slice.bounds().size()[axis] / count[static_cast<std::size_t>(axis)];
    const int cells = count[static_cast<std::size_t>(axis)] + (basis == Basis::kCubic ? 2 : 0);
    for (int i = 0; i < cells; ++i)
      traits.planes[static_cast<std::size_t>(axis)].push_back(medium.bounds().min[axis] +
                                                              (i + 1) * voxel);
  }
  traits.tolerance.closedForm = 1e-3;  // of the fast path, as it says
  return conformance::underTest(medium, traits);
}

/// A tile of 32^3 voxels, and a leaf of others beside it.
std::shared_ptr<const BrickSlice> tileAndLeaf() {
  VolumeInfo info;
  info.x = 52, info.y = 44, info.z = 44;
  info.bounds = {Vec3(-1, 0.5, 2), Vec3(1, 2, 3)};
  info.basis = Basis::kTrilinear;
  Bricks bricks;
  bricks.addTile({{8, 8, 0}, 32, true, {1.5F, 0, 0}});
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0, 2);
  BrickMask all;
  all.fill(~std::uint64_t{0});
  for (float& value : bricks.addLeaf({{40, 16, 16}, all, all})) value = uniform(random);
  bricks.sort();
  return std::make_shared<const BrickSlice>(BrickSlice::fromBricks(info, bricks));
}

conformance::MediumUnderTest tilesUnderTest() {
  const ShadedVoxels dark = ShadedVoxels::withTiles(tileAndLeaf(), 1);
  EXPECT_FALSE(dark.march());
  std::vector<VoxelLight> light;
  for (const Vec3& p : dark.lightPoints())
    light.push_back(Rgb(std::exp(p.x()), 1 + 0.2 * p.y(), 0.3).cast<float>());
  const ShadedVoxels medium = dark.withLight(light);
  conformance::Traits traits;
  const std::array<int, 3> count{52, 44, 44};
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < count[static_cast<std::size_t>(axis)]; ++i)
      traits.planes[static_cast<std::size_t>(axis)].push_back(
          medium.bounds().min[axis] +
          (i + 1) * medium.slice().bounds().size()[axis] / count[static_cast<std::size_t>(axis)]);
  }
  traits.tolerance.closedForm = 1e-3;  // of the fast path, as it says
  return conformance::underTest(medium, traits);
}

VOLUTE_CONFORMANCE(ShadedTiles, tilesUnderTest());
VOLUTE_CONFORMANCE(ShadedGlowing, shadedUnderTest(4, false));
VOLUTE_CONFORMANCE(ShadedLit, shadedUnderTest(1, true));
VOLUTE_CONFORMANCE(ShadedGlowingAndLit, shadedUnderTest(4, true));
VOLUTE_CONFORMANCE(ShadedLitInOneColour, shadedUnderTest(1, true, true));
VOLUTE_CONFORMANCE(ShadedCubicGlowing, shadedUnderTest(4, false, false, Basis::kCubic));
VOLUTE_CONFORMANCE(ShadedCubicLit, shadedUnderTest(1, true, false, Basis::kCubic));
VOLUTE_CONFORMANCE(ShadedCubicGlowingAndLit, shadedUnderTest(4, true, false, Basis::kCubic));

TEST(ShadedVoxels, AsksForLightOnceAtEachCornerThatNeedsIt) {
  VolumeInfo info;
  info.x = info.y = info.z = 24;
  info.bounds = {Vec3::Zero(), Vec3::Constant(24)};
  info.basis = Basis::kTrilinear;
  std::vector<float> values(info.frameValues(), 0);
  // In four bricks of cells, and at the volume's corner.
  for (const auto& [x, y, z] : {std::array{7, 7, 3}, std::array{23, 23, 23}})
    values[(static_cast<std::size_t>(z) * 24 + y) * 24 + x] = 1;
  const ShadedVoxels medium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
  const auto& points = medium.lightPoints();
  EXPECT_EQ(points.size(), 54U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double near = std::min((points[i] - Vec3(7.5, 7.5, 3.5)).cwiseAbs().maxCoeff(),
                                 (points[i] - Vec3::Constant(23.5)).cwiseAbs().maxCoeff());
    EXPECT_LE(near, 1 + 1e-9);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((points[i] - points[j]).norm(), 0.5);
  }
}

TEST(ShadedVoxels, FastPathIsWithinItsErrorWhereLightIsLost) {
  const ShadedVoxels medium = shadedMedium(4, true);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  std::vector<Segment> rays;
  for (int i = 0; i < 500; ++i) {
    const Vec3 from(-3, 1 + uniform(random), 2.5 + uniform(random));
    const Vec3 to(3, 1 + uniform(random), 2.5 + uniform(random));
    rays.push_back({from, (to - from).normalized(), 0, 10});
  }
  std::vector<Radiance> fast(rays.size()), exact(rays.size());
  medium.radiance(rays, fast);
  radianceByPieces(medium, rays, exact);
  double brightest = 0;
  for (const Radiance& one : exact) brightest = std::max(brightest, one.emitted.maxCoeff());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_LE((fast[i].emitted - exact[i].emitted).abs().maxCoeff(), 1e-3 * brightest);
    EXPECT_NEAR(fast[i].transmittance, exact[i].transmittance, 1e-3);
  }
}

TEST(ShadedVoxels, EveryTargetGivesTheSameBits) {
  std::vector<Segment> rays;
  for (int i = 0; i < 50; ++i)
    rays.push_back({Vec3(-3, 0.6 + 0.027 * i, 2.1), Vec3(1, 0.02, 0.1).normalized(), 0, 10});
  for (const auto& [channels, grey] : {std::pair{1, false}, {4, false}, {1, true}, {4, true}}) {
    const ShadedVoxels medium = shadedMedium(channels, true, grey);
    ASSERT_EQ(medium.march()->oneColor, grey);
    std::vector<Radiance> first(rays.size()), other(rays.size());
    medium.radiance(rays, first);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      medium.radiance(rays, other);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE((first[i].emitted == other[i].emitted).all()) << hwy::TargetName(target);
        ASSERT_EQ(first[i].transmittance, other[i].transmittance) << hwy::TargetName(target);
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
}

/// Its light is what lies beside its extinction.
TEST(ShadedVoxels, LightLiesBesideExtinction) {
  const ShadedVoxels medium = shadedMedium(1, true);
  const auto dark = shadedMedium(1, false).march(), lit = medium.march();
  ASSERT_EQ(lit->stride[0], 2);
  ASSERT_EQ(lit->stored, dark->stored);
  for (std::int32_t brick = 0; brick < lit->stored; ++brick) {
    for (int i = 0; i < 9 * 9 * 9; ++i)
      ASSERT_EQ(lit->values[brick * lit->brickStride + 2 * i],
                dark->values[brick * dark->brickStride + i]);
  }
}

/// Light of one colour is kept as it is, and is as exact as the pieces.
TEST(ShadedVoxels, LightOfOneColourIsAsExactAsFloats) {
  std::vector<Segment> rays;
  for (int i = 0; i < 50; ++i)
    rays.push_back({Vec3(-3, 0.6 + 0.027 * i, 2.1), Vec3(1, 0.02, 0.1).normalized(), 0, 10});
  std::vector<Radiance> fast(rays.size()), exact(rays.size());
  for (const int channels : {1, 4}) {
    const ShadedVoxels medium = shadedMedium(channels, true, true);
    medium.radiance(rays, fast);
    radianceByPieces(medium, rays, exact);
    double brightest = 0, worst = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      brightest = std::max(brightest, exact[i].emitted.maxCoeff());
      worst = std::max(worst, (fast[i].emitted - exact[i].emitted).abs().maxCoeff());
    }
    EXPECT_LE(worst, 2e-4 * brightest);
  }
}

TEST(ShadedVoxels, PackedLightIsWithinItsBits) {
  for (double share = 0; share <= 1; share += 0.001) {
    const Rgb back = unpackLight(packLight({share, share * share, 1 - share}));
    EXPECT_NEAR(back[0], share, std::sqrt(share) / 2047 + 1e-6);
    EXPECT_NEAR(back[1], share * share, share / 2047 + 1e-6);
    EXPECT_NEAR(back[2], 1 - share, std::sqrt(1 - share) / 1023 + 1e-6);
  }
}

TEST(ShadedVoxels, LightForMeansHasTheMeansOfExponentials) {
  // Light that falls by e^-.5 a voxel along x, as in thick smoke.
  VolumeInfo info;
  info.x = info.y = info.z = 16;
  info.bounds = {Vec3::Zero(), Vec3::Constant(16)};
  info.basis = Basis::kTrilinear;
  const std::vector<float> values(info.frameValues(), 1);
  const ShadedVoxels medium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
  std::vector<VoxelLight> light;
  for (const Vec3& p : medium.lightPoints())
    light.push_back(VoxelLight::Constant(static_cast<float>(std::exp(-0.5 * p.x()))));
  const auto mean = [&](const std::vector<VoxelLight>& values) {
    double sum = 0;  // over the cell from 7.5 to 8.5
    const ShadedVoxels lit = medium.withLight(values);
    for (int i = 0; i < 100; ++i) sum += lit.emission({7.5 + (i + 0.5) / 100, 8, 8})[0] / 100;
    return sum;
  };
  const double exact = (std::exp(-0.5 * 7.5) - std::exp(-0.5 * 8.5)) / 0.5;
  EXPECT_GT(mean(light), 1.015 * exact);
  EXPECT_NEAR(mean(medium.forMeans(light, Vec3::Constant(1))), exact, 1e-3 * exact);
}

TEST(ShadedVoxels, LightBesideTheSmokeDoesNotShineOnItsShadow) {
  // A block of 8^3 voxels, one per voxel of optical depth, in a sun from above: its sides are dark
  // below, although the voxels beside them are in the sun.
  VolumeInfo info;
  info.x = info.y = info.z = 16;
  info.bounds = {Vec3::Zero(), Vec3::Constant(16)};
  info.basis = Basis::kTrilinear;
  std::vector<float> values(info.frameValues(), 0);
  for (int z = 4; z < 12; ++z)
    for (int y = 4; y < 12; ++y)
      for (int x = 4; x < 12; ++x) values[(z * 16 + y) * 16 + x] = 1;
  const ShadedVoxels medium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
  const auto isInside = [](double at) { return at > 4 && at < 12; };
  std::vector<VoxelLight> light;
  for (const Vec3& p : medium.lightPoints()) {
    const bool shaded = isInside(p.x()) && isInside(p.y());
    const double depth = shaded ? std::clamp(12 - p.z(), 0.0, 8.0) : 0;
    light.push_back(VoxelLight::Constant(static_cast<float>(std::exp(-depth))));
  }
  const ShadedVoxels lit = medium.withLight(medium.forMeans(light, Vec3::Constant(1)));
  const auto seen = [&](const ShadedVoxels& from, const Vec3& at) { return from.emission(at)[0]; };
  for (const Vec3& side : {Vec3(3.8, 8, 5), Vec3(8, 12.2, 5), Vec3(3.8, 3.8, 5)}) {
    EXPECT_GT(seen(medium.withLight(light), side), 0.05) << side.x();
    EXPECT_LT(seen(lit, side), 0.02) << side.x();
  }
  // What is lit stays so: 1 - e^-.5 over the first ramp.
  double sum = 0;
  for (int i = 0; i < 100; ++i) sum += seen(lit, {8, 8, 11.5 + (i + 0.5) / 100}) / 100;
  EXPECT_NEAR(sum, 0.37, 0.03);
}

}  // namespace
}  // namespace volute
