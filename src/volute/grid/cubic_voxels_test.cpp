// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/cubic_voxels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/grid/shaded_voxels.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

VolumeInfo cubicInfo(int side, int channels = 1) {
  VolumeInfo info;
  info.x = info.y = info.z = side;
  info.channels = channels;
  info.bounds = {Vec3::Zero(), Vec3::Constant(side)};
  info.basis = Basis::kCubic;
  return info;
}

VoxelMedium cubicMedium(const VolumeInfo& info, std::span<const float> values, double emission = 1,
                        double extinction = 1) {
  return {std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), emission, extinction};
}

/// A B-spline of degree n with knots at 0, 1, .., n + 1, by the recursion of Cox and de Boor.
double coxDeBoor(int degree, double t) {
  if (degree == 0)
    return t >= 0 && t < 1 ? 1 : 0;
  return t / degree * coxDeBoor(degree - 1, t) +
         (degree + 1 - t) / degree * coxDeBoor(degree - 1, t - 1);
}

TEST(CubicVoxels, IsASumOfBSplinesAtVoxelCentres) {
  const VolumeInfo info = cubicInfo(9);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> values(info.frameValues());
  for (float& value : values) value = std::max(0.0F, uniform(random) - 0.5F);
  const VoxelMedium medium = cubicMedium(info, values);
  EXPECT_EQ(medium.bounds().min, Vec3::Constant(-1.5));
  EXPECT_EQ(medium.bounds().max, Vec3::Constant(10.5));
  std::uniform_real_distribution<double> place(-1.5, 10.5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point(place(random), place(random), place(random));
    double sum = 0;
    for (int z = 0, v = 0; z < 9; ++z) {
      for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 9; ++x, ++v) {
          double product = values[static_cast<std::size_t>(v)];
          const int voxel[3] = {x, y, z};
          for (int axis = 0; axis < 3; ++axis)
            product *= coxDeBoor(3, point[axis] - voxel[axis] - 0.5 + 2);
          sum += product;
        }
      }
    }
    EXPECT_NEAR(medium.extinction(point), sum, 1e-12);
  }
}

TEST(CubicVoxels, StaysWithinTheRangeOfItsValues) {
  // A plane between 0 and 1, where an interpolating spline would overshoot.
  const VolumeInfo info = cubicInfo(16);
  std::vector<float> values(info.frameValues());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 16 < 8 ? 0.25F : 1;
  const VoxelMedium medium = cubicMedium(info, values);
  double last = 0.25;
  for (double x = 4; x < 12; x += 0.05) {
    const double value = medium.extinction({x, 8, 8});
    EXPECT_GE(value, last - 1e-12);
    EXPECT_LE(value, 1 + 1e-12);
    last = value;
  }
}

TEST(CubicVoxels, HasNoEdgesInItsSlope) {
  const VolumeInfo info = cubicInfo(8);
  std::vector<float> values(info.frameValues(), 0);
  values[(4 * 8 + 4) * 8 + 4] = 1;
  const VoxelMedium medium = cubicMedium(info, values);
  const double h = 1e-4;
  const auto second = [&](double x) {
    const auto at = [&](double there) { return medium.extinction({there, 4.5, 4.5}); };
    return (at(x + h) - 2 * at(x) + at(x - h)) / (h * h);
  };
  for (double knot : {2.5, 3.5, 4.5, 5.5, 6.5})
    EXPECT_NEAR(second(knot - 2 * h), second(knot + 2 * h), 1e-3);
}

TEST(CubicVoxels, MarchInFloatIsWithinItsErrorOfThePieces) {
  for (const int channels : {1, 3}) {
    VolumeInfo info = cubicInfo(20, channels);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<float> values(info.frameValues());
    for (float& value : values) value = std::max(0.0F, uniform(random) - 0.7F);
    for (const double extinction : {0.0, 1.0, 8.0, 60.0}) {
      const VoxelMedium medium = cubicMedium(info, values, 2, extinction);
      std::uniform_real_distribution<double> across(0, 20);
      std::vector<Segment> rays;
      for (int i = 0; i < 100; ++i) {
        const Vec3 from(-5, across(random), across(random)), to(25, across(random), across(random));
        rays.push_back({from, (to - from).normalized(), 0, 60});
      }
      std::vector<Radiance> fast(rays.size()), exact(rays.size());
      medium.radiance(rays, fast);
      radianceByPieces(medium, rays, exact);
      double brightest = 0;
      for (const Radiance& one : exact) brightest = std::max(brightest, one.emitted.maxCoeff());
      for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_LE((fast[i].emitted - exact[i].emitted).abs().maxCoeff(), 1e-5 * brightest)
            << channels << " channels, " << extinction;
        EXPECT_NEAR(fast[i].transmittance, exact[i].transmittance, 5e-6);
      }
    }
  }
}

TEST(CubicVoxels, ScatteredLightIsThatOfTheSplineTimesTheLight) {
  // A round cloud in light that falls by e^-.3 a voxel.
  const VolumeInfo info = cubicInfo(24);
  std::vector<float> values(info.frameValues(), 0);
  for (int z = 0, i = 0; z < 24; ++z) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 24; ++x, ++i) {
        const double r = (Vec3(x, y, z) - Vec3::Constant(11.5)).squaredNorm() / 30;
        values[static_cast<std::size_t>(i)] = static_cast<float>(std::exp(-r));
      }
    }
  }
  const ShadedVoxels dark(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
  const auto lightAt = [](const Vec3& p) { return std::exp(-0.3 * p.x()); };
  std::vector<VoxelLight> light;
  for (const Vec3& p : dark.lightPoints())
    light.push_back(VoxelLight::Constant(static_cast<float>(lightAt(p))));
  const ShadedVoxels lit = dark.withLight(dark.forMeans(light, Vec3::Constant(1)));
  double plain = 0, corrected = 0, largest = 0;
  for (double x = 4; x < 20; x += 0.37) {
    const Vec3 p(x, 11.2, 12.9);
    const double asked = lit.extinction(p) * lightAt(p);
    largest = std::max(largest, asked);
    corrected = std::max(corrected, std::abs(lit.emission(p)[0] - asked));
    // What products at the voxels' centres alone would give.
    plain = std::max(
        plain, std::abs(lit.extinction(p) * lightAt(p) * (0.09 / 6 + 0.3 * 2 * (x - 12) / 30 / 3)));
  }
  EXPECT_LE(corrected, 2e-3 * largest);
  EXPECT_GT(plain, 5 * corrected);
}

}  // namespace
}  // namespace volute
