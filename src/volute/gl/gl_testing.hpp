// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "volute/fog/fog_testing.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_renderer.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/gl/gl_volume.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/media/fog/lit_fog.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

// What the module's tests share: a context, media and views.

namespace volute::gltest {

inline constexpr int kWidth = 36, kHeight = 30;

/// One context for all tests of this file: making one costs more than a picture.
class GlRendererTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = HeadlessGl::create();
    if (made) {
      gl_ = std::make_unique<HeadlessGl>(std::move(*made));
      renderer_ = std::make_unique<GlRenderer>(GlRenderer::create().value());
    } else {
      missing_ = made.error().message;
    }
  }

  static void TearDownTestSuite() {
    renderer_.reset();
    gl_.reset();
  }

  void SetUp() override {
    if (!gl_)
      GTEST_SKIP() << missing_;
  }

  static inline std::unique_ptr<HeadlessGl> gl_;
  static inline std::unique_ptr<GlRenderer> renderer_;
  static inline std::string missing_;
  Progress quiet_;

  /// The largest difference as a share of the largest value; what is infinite must be so in both.
  static double difference(std::span<const float> found, std::span<const float> expected) {
    if (found.size() != expected.size())
      return INFINITY;
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (std::isinf(expected[i]) && found[i] == expected[i])
        continue;
      const double error = std::abs(double(found[i]) - expected[i]);
      worst = !(error <= worst) ? error : worst;
      largest = std::max(largest, std::abs(double(expected[i])));
    }
    EXPECT_GT(largest, 1e-3) << "the test's picture is black";
    return worst / largest;
  }

  /// The largest difference from the reference, as a share of its largest value.
  double errorOf(const Camera& camera, const GlScene& scene, std::span<const AnyMedium> media,
                 RenderOptions options, std::span<const float> opaque = {}) {
    const auto image = renderer_->render(camera, scene, options, quiet_, nullptr, opaque);
    EXPECT_TRUE(image) << image.error().message;
    if (!image)
      return INFINITY;
    options.renderer = Renderer::kReference;
    const Image expected = render(camera, media, options, quiet_, nullptr, opaque).value();
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
      largest = std::max<double>(largest, expected.pixels[i]);
      const double error = std::abs(double(image->pixels[i]) - expected.pixels[i]);
      worst = !(error <= worst) ? error : worst;
    }
    EXPECT_GT(largest, 1e-4) << "the test's picture is black";
    return worst / largest;
  }
};

/// GlFog::polar, of a table for any camera.
inline std::optional<PolarOptions> anyPolar(const Camera&) {
  return PolarOptions{};
}

inline constexpr double kBar = 5e-4;  // the contract says 2e-3

/// Blobs with holes between them, so that some bricks are empty; sizes that no brick divides.
inline VolumeInfo infoOf(int channels, Basis basis) {
  VolumeInfo info;
  info.frames = 1, info.x = 21, info.y = 17, info.z = 26, info.channels = channels;
  info.basis = basis;
  info.bounds = {Vec3(-1, 2, 0.5), Vec3(1.1, 3.7, 3.1)};
  return info;
}

inline std::vector<float> blobs(const VolumeInfo& info, int frame = 0) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> noise(0.5F, 1.0F);
  std::vector<float> values;
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x) {
        const float a = std::hypot(x - 5.0F - frame, y - 8.0F, z - 6.0F),
                    b = std::hypot(x - 16.0F, y - 9.0F, z - 20.0F);
        const float inside = std::max(0.0F, 1 - a / 5) + 2 * std::max(0.0F, 1 - b / 6);
        for (int c = 0; c < info.channels; ++c)
          values.push_back(inside * noise(random) * (1 + 0.4F * c));
      }
    }
  }
  return values;
}

inline std::shared_ptr<const BrickSlice> sliceOf(int channels, Basis basis) {
  const VolumeInfo info = infoOf(channels, basis);
  return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, blobs(info)));
}

/// Beside, inside, along an axis, orthographic, and through a lens.
inline std::vector<Camera> cameras(const Box3& bounds) {
  const Vec3 centre = bounds.centre();
  Calibration lens;
  lens.width = kWidth, lens.height = kHeight;
  lens.K = Mat3(32, 1.5, 17, 0, 30, 16, 0, 0, 1);
  lens.R = Mat3(1, 0, 0, 0, 0, -1, 0, 1, 0);
  lens.t = -lens.R * (centre + Vec3(0.1, -4, 0.2));
  lens.distortion.k1 = -0.1;
  return {Camera::framing(bounds, kWidth, kHeight),
          Camera::pinhole({centre + Vec3(0.05, 0.02, -0.3), centre + Vec3(1, 2, 0.5)}, 70, kWidth,
                          kHeight),
          Camera::pinhole({centre - Vec3(0, 5, 0), centre}, 30, kWidth + 1, kHeight + 1),
          Camera::orthographic({centre + Vec3(1, -1, 0.7), centre}, 3.5, kWidth, kHeight),
          Camera::calibrated(lens).value()};
}

/// A mesh, its smoke, and the same as the reference's medium.
struct Smoke {
  explicit Smoke(std::shared_ptr<const TetMesh> mesh, bool lit, double thick)
      : locator(std::make_shared<const TetLocator>(mesh)) {
    for (const Vec3& p : mesh->vertices()) {
      extinction.push_back(
          float(thick * std::max(0.0, std::sin(2 * p.x()) + std::cos(3 * p.y() + p.z()))));
      if (lit) {
        for (int c = 0; c < 3; ++c) source.push_back(float(0.6 + 0.4 * std::sin(c + p.z())));
      }
    }
  }

  std::shared_ptr<const GlPart> onDevice(GlSmokeMethod method = GlSmokeMethod::kMarch) const {
    return glPart(GlSmoke{locator, extinction, source, method});
  }

  AnyMedium medium() const { return AnyMedium(TetMedium(locator, extinction, source)); }

  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction, source;
};

}  // namespace volute::gltest
