// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/lamp_light.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "volute/grid/voxel_medium.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

/// Smoke of blobs that a lamp lights from +x, 20 m away, drawn on voxels of half the size.
struct LitScene : TestScene {
  static constexpr double kAway = 20, kArrives = 4;

  std::vector<float> smoke;  ///< [1/m], (z, y, x)
  CaptureLighting lighting;

  /// @param dense  extinction of what the blobs have as radiance per metre [1/m]
  explicit LitScene(double dense) : TestScene(7) {
    for (std::size_t i = 0; i < geometry.voxels(); ++i)
      smoke.push_back(static_cast<float>(dense * truth[3 * i]));
    lighting.lamps = {{.sun = false,
                       .position = Vec3(kAway, 0, 0),
                       .light = Rgb::Constant(kArrives * kAway * kAway)}};
    lighting.albedo = Rgb::Constant(0.9);
    VolumeInfo info;
    info.frames = 1;
    info.x = info.y = info.z = 2 * kSide;
    info.channels = 1;
    info.bounds = geometry.bounds;
    const VolumeGeometry fine{geometry.bounds, {info.x, info.y, info.z}};
    const auto colours = blobs(fine, 0);
    std::vector<float> values;
    for (std::size_t i = 0; i < fine.voxels(); ++i)
      values.push_back(static_cast<float>(dense * colours[3 * i]));
    info.basis = Basis::kTrilinear;
    const VoxelMedium medium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), 0,
                             1);
    for (TomographyView& view : views) {
      for (int y = 0; y < view.camera.height(); ++y)
        for (int x = 0; x < view.camera.width(); ++x) {
          const Rgb seen = scattered(medium, view.camera.ray(x + 0.5, y + 0.5));
          for (int c = 0; c < 3; ++c) view.radiance.at(x, y, c) = static_cast<float>(seen[c]);
        }
    }
  }

  /// What a ray sees, by steps of a quarter of a voxel and exact optical depths.
  Rgb scattered(const VoxelMedium& medium, const Segment& ray) const {
    const Interval part = medium.bounds().intersect(ray.origin, ray.direction);
    if (part.empty())
      return Rgb::Zero();
    constexpr int kSteps = 120;
    const double length = (part.end - part.begin) / kSteps;
    std::vector<Segment> ways;
    std::vector<double> sends;
    for (int k = 0; k < kSteps; ++k) {
      const double t = part.begin + (k + 0.5) * length;
      const Vec3 point = ray.at(t), way = lighting.lamps[0].position - point;
      const double distance = way.norm(), smoke = medium.extinction(point);
      if (smoke == 0)
        continue;
      ways.push_back({point, way / distance, 0, distance});
      ways.push_back({ray.origin, ray.direction, part.begin, t});
      sends.push_back(smoke * length / (4 * std::numbers::pi * distance * distance));
    }
    std::vector<double> depths(ways.size());
    medium.opticalDepth(ways, depths);
    Rgb sum = Rgb::Zero();
    for (std::size_t k = 0; k < sends.size(); ++k)
      sum += sends[k] * std::exp(-depths[2 * k] - depths[2 * k + 1]) * lighting.albedo *
             lighting.lamps[0].light;
    return sum;
  }

  /// Relative L2 of extinction, times a factor.
  double smokeError(std::span<const float> found, double factor = 1) const {
    double off = 0, size = 0;
    for (std::size_t i = 0; i < smoke.size(); ++i) {
      off += std::pow(factor * found[i] - smoke[i], 2);
      size += std::pow(smoke[i], 2);
    }
    return std::sqrt(off / size);
  }
};

TEST(LampLight, LitSmokeIsFoundBetterThanByConstantLight) {
  for (const double dense : {0.4, 0.7}) {
    LitScene scene(dense);
    TomographyOptions options;
    options.regularization = Regularization::kNone;
    options.iterations = 40;
    options.raysPerPixel = 1;
    Progress progress;
    const auto constant = reconstruct(scene.views, scene.geometry, options, {}, progress);
    ASSERT_TRUE(constant) << constant.error().message;
    std::vector<float> grey;
    double product = 0, square = 0;
    for (std::size_t i = 0; i < scene.smoke.size(); ++i) {
      grey.push_back(constant->volume[3 * i]);
      product += static_cast<double>(grey[i]) * scene.smoke[i];
      square += std::pow(grey[i], 2);
    }
    const double before = scene.smokeError(grey, product / square);  // by the best of all factors
    const std::vector<std::size_t> all{0, 1, 2, 3, 4, 5, 6};
    const auto lit =
        reconstructLit(scene.views, all, scene.geometry, options, scene.lighting, progress);
    ASSERT_TRUE(lit) << lit.error().message;
    const double after = scene.smokeError(lit->extinction);
    RecordProperty(fmt::format("constant at {}", dense), fmt::format("{:.3f}", before));
    RecordProperty(fmt::format("lit at {}", dense), fmt::format("{:.3f}", after));
    EXPECT_LT(after, 0.6 * before) << after << " instead of " << before << " at " << dense;
  }
}

TEST(LampLight, NeedsLamps) {
  TestScene scene(3);
  const std::vector<std::size_t> all{0, 1, 2};
  Progress progress;
  const auto lit = reconstructLit(scene.views, all, scene.geometry, {}, {}, progress);
  ASSERT_FALSE(lit);
  EXPECT_NE(lit.error().message.find("no lamps"), std::string::npos);
}

TEST(LampLight, ASunFallsOffWithDepth) {
  const VolumeGeometry geometry{{Vec3(0, 0, 0), Vec3(2, 1, 1)}, {40, 8, 8}};
  const std::vector<float> even(geometry.voxels(), 0.7F);
  CaptureLighting lighting;
  lighting.lamps = {{.direction = Vec3::UnitX(), .light = Rgb(4, 2, 1)}};
  lighting.albedo = Rgb(0.5, 1, 1);
  const auto source = lampSource(lighting, geometry, even);
  for (const int x : {3, 20, 36}) {
    const std::size_t voxel = (4 * 8 + 4) * 40 + static_cast<std::size_t>(x);
    const double depth = 0.7 * (x + 0.5) * 0.05;
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected = lighting.albedo[c] * lighting.lamps[0].light[c] /
                              (4 * std::numbers::pi) * std::exp(-depth);
      EXPECT_NEAR(source[3 * voxel + c] / expected, 1, 0.02) << x;
    }
  }
}

TEST(LampLight, ExtinctionIsFoundFromTheLightItSends) {
  const TestScene scene(1);
  std::vector<float> smoke;
  for (std::size_t i = 0; i < scene.geometry.voxels(); ++i)
    smoke.push_back(1.5F * scene.truth[3 * i]);
  CaptureLighting lighting;
  lighting.lamps = {{.direction = Vec3(1, 0.5, -0.2).normalized(), .light = Rgb(3, 3, 2)},
                    {.sun = false, .position = Vec3(0, 0, -3), .light = Rgb(5, 6, 7)}};
  auto emission = lampSource(lighting, scene.geometry, smoke);
  for (std::size_t i = 0; i < emission.size(); ++i) emission[i] *= smoke[i / 3];
  const auto found = litExtinction(lighting, scene.geometry, emission);
  double off = 0, size = 0;
  for (std::size_t i = 0; i < smoke.size(); ++i) {
    off += std::pow(found[i] - smoke[i], 2);
    size += std::pow(smoke[i], 2);
  }
  EXPECT_LT(std::sqrt(off / size), 0.02);
}

}  // namespace
}  // namespace volute
