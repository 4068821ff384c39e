// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "volute/base/parallel.hpp"
#include "volute/fog/fog_testing.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

constexpr int kWidth = 36, kHeight = 30;

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

constexpr double kBar = 5e-4;  // the contract says 2e-3

/// Blobs with holes between them, so that some bricks are empty; sizes that no brick divides.
VolumeInfo infoOf(int channels, Basis basis) {
  VolumeInfo info;
  info.frames = 1, info.x = 21, info.y = 17, info.z = 26, info.channels = channels;
  info.basis = basis;
  info.bounds = {Vec3(-1, 2, 0.5), Vec3(1.1, 3.7, 3.1)};
  return info;
}

std::vector<float> blobs(const VolumeInfo& info, int frame = 0) {
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

std::shared_ptr<const BrickSlice> sliceOf(int channels, Basis basis) {
  const VolumeInfo info = infoOf(channels, basis);
  return std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, blobs(info)));
}

/// Beside, inside, along an axis, orthographic, and through a lens.
std::vector<Camera> cameras(const Box3& bounds) {
  const Vec3 centre = bounds.centre();
  Calibration lens;
  lens.width = kWidth, lens.height = kHeight;
  lens.K << 32, 1.5, 17, 0, 30, 16, 0, 0, 1;
  lens.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  lens.t = -lens.R * (centre + Vec3(0.1, -4, 0.2));
  lens.distortion.k1 = -0.1;
  return {Camera::framing(bounds, kWidth, kHeight),
          Camera::pinhole({centre + Vec3(0.05, 0.02, -0.3), centre + Vec3(1, 2, 0.5)}, 70, kWidth,
                          kHeight),
          Camera::pinhole({centre - Vec3(0, 5, 0), centre}, 30, kWidth + 1, kHeight + 1),
          Camera::orthographic({centre + Vec3(1, -1, 0.7), centre}, 3.5, kWidth, kHeight),
          Camera::calibrated(lens).value()};
}

TEST_F(GlRendererTest, VolumesAreThoseOfTheReference) {
  int pictures = 0;
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    for (const int channels : {1, 3}) {
      for (const double extinction : {0.0, 1.5, 40.0}) {
        const auto slice = sliceOf(channels, basis);
        const AnyMedium medium(VoxelMedium(slice, 1.3, extinction));
        const GlScene scene{.volumes = {{slice, 1.3, extinction}}};
        const auto views = cameras(medium.bounds());
        for (const Camera& camera : views) {
          if (++pictures % 3 != 0 && &camera != &views[0])
            continue;  // every camera comes with every basis, but not with everything
          const double error =
              errorOf(camera, scene, {&medium, 1}, {.background = Rgb(0.1, 0.2, 0.3)});
          EXPECT_LE(error, kBar) << "basis " << int(basis) << ", channels " << channels
                                 << ", extinction " << extinction;
        }
      }
    }
  }
}

TEST_F(GlRendererTest, OpticalDepthsAreThoseOfTheReference) {
  const auto slice = sliceOf(3, Basis::kTrilinear);
  const AnyMedium medium(VoxelMedium(slice, 1, 30));
  const Camera camera = Camera::framing(medium.bounds(), kWidth, kHeight);
  for (const Aov aov : {Aov::kOpticalDepth, Aov::kTransmittance})
    EXPECT_LE(errorOf(camera, {.volumes = {{slice, 1, 30}}}, {&medium, 1}, {.aov = aov}), 1e-4);
}

TEST_F(GlRendererTest, OpaqueSurfacesHideWhatIsBehindThem) {
  const auto slice = sliceOf(1, Basis::kTrilinear);
  const AnyMedium medium(VoxelMedium(slice, 1, 2));
  const Camera camera = Camera::framing(medium.bounds(), kWidth, kHeight);
  std::vector<float> depth(kWidth * kHeight, INFINITY);
  const auto middle = float((medium.bounds().centre() - camera.eye()).norm());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x)
      depth[y * kWidth + x] = middle + 0.02F * float(y - kHeight / 2);
  }
  const RenderOptions options{.background = Rgb(0.5, 0.4, 0.3)};
  EXPECT_LE(errorOf(camera, {.volumes = {{slice, 1, 2}}}, {&medium, 1}, options, depth), kBar);
  Image behind(kWidth, kHeight);
  for (std::size_t i = 0; i < behind.pixels.size(); ++i) behind.pixels[i] = 0.001F * float(i % 97);
  EXPECT_LE(errorOf(camera, {.volumes = {{slice, 1, 2}}}, {&medium, 1}, {.behind = &behind}, depth),
            kBar);
}

TEST_F(GlRendererTest, TheTreeIsWalkedInPlace) {
  for (const int channels : {1, 3}) {
    VolumeInfo info = infoOf(channels, Basis::kBox);
    info.frames = 3;
    info.fillDefaults();
    Sequence sequence{info, {}};
    for (int t = 0; t < info.frames; ++t) {
      const auto values = blobs(info, t);
      sequence.values.insert(sequence.values.end(), values.begin(), values.end());
    }
    SequenceSource source(sequence);
    const auto tree = std::make_shared<const Tree4d>(
        Tree4d::build(source, {.relativeRms = 2e-3}, quiet_).value());
    for (const Basis basis : {channels == 1 ? Basis::kBox : Basis::kTrilinear}) {
      for (int frame = 0; frame < info.frames; frame += 2) {
        BrickSlice slice = tree->extractSlice(frame);
        slice.setBasis(basis);
        const AnyMedium medium(
            VoxelMedium(std::make_shared<const BrickSlice>(std::move(slice)), 1, 1.5));
        const GlScene scene{.trees = {{tree, frame, basis, info.bounds, 1, 1.5}}};
        EXPECT_LE(errorOf(Camera::framing(info.bounds, kWidth, kHeight), scene, {&medium, 1}, {}),
                  kBar)
            << "channels " << channels << ", basis " << int(basis) << ", frame " << frame;
      }
    }
  }
}

TEST_F(GlRendererTest, FogIsThatOfTheReference) {
  int cases = 0;
  const SplineGrid map = fogtest::map(9, 8);
  for (int degree = 0; degree <= 3; ++degree) {
    for (const auto& [name, profile] : fogtest::profiles()) {
      for (const double mu : {1.0, 0.5}) {
        if (++cases % 3 != 0)
          continue;  // a shader of its own for each takes its time; every value comes with several
                     // others
        const FogMedium fog = fogtest::fog(map, profile,
                                           {.degree = degree,
                                            .levels = mu < 1 ? 2 : 0,
                                            .detail = {.mu = mu},
                                            .color = Rgb(0.8, 0.9, 1)});
        const AnyMedium medium(fog);
        const Camera camera =
            Camera::pinhole({Vec3(-4, -3, 3), Vec3(8, 9, 1.5)}, 70, kWidth, kHeight);
        EXPECT_LE(
            errorOf(camera, {.fogs = {fog}}, {&medium, 1}, {.background = Rgb(0.2, 0.1, 0.4)}),
            kBar)
            << "degree " << degree << ", " << name << ", mu " << mu;
      }
    }
  }
}

TEST_F(GlRendererTest, FogFromParallelRays) {
  const FogMedium fog =
      fogtest::fog(fogtest::map(15, 12), fogtest::profiles()[1].profile, {.degree = 2});
  const AnyMedium medium(fog);
  const Camera camera = Camera::orthographic({Vec3(6, 9, 3), Vec3(10, 14, 1)}, 12, kWidth, kHeight);
  EXPECT_LE(errorOf(camera, {.fogs = {fog}}, {&medium, 1}, {}), kBar);
}

/// Two volumes and two fogs that overlap, and a wall's depth through them.
TEST_F(GlRendererTest, MediaThatOverlapAreCompositedAsTheReferenceDoes) {
  for (const Basis basis : {Basis::kTrilinear}) {
    const auto fire = sliceOf(3, basis);
    VolumeInfo info = infoOf(1, Basis::kTrilinear);
    info.bounds = {Vec3(-0.5, 2.5, 0), Vec3(1.8, 4.5, 2)};
    const auto smoke = std::make_shared<const BrickSlice>(BrickSlice::fromDense(info, blobs(info)));
    const FogMedium ground = fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile,
                                          {.degree = 2, .color = Rgb(0.7, 0.8, 0.9)}, 0.9, 0.6);
    const FogMedium layer = fogtest::fog(fogtest::map(8, 8, 4), fogtest::profiles()[2].profile,
                                         {.degree = 1, .color = Rgb(0.9, 0.5, 0.2)}, 0.5, 0.7);
    const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(fire, 2, 3)),
                                       AnyMedium(VoxelMedium(smoke, 0.2, 4)), AnyMedium(ground),
                                       AnyMedium(layer)};
    const GlScene scene{.volumes = {{fire, 2, 3}, {smoke, 0.2, 4}}, .fogs = {ground, layer}};
    const Camera camera =
        Camera::pinhole({Vec3(0.2, -1, 2.6), Vec3(0.3, 3.2, 1.2)}, 50, kWidth, kHeight);
    std::vector<float> wall(kWidth * kHeight, INFINITY);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Segment ray = camera.ray(x + 0.5, y + 0.5);
        const double s = (3.3 - ray.origin.y() - 0.3 * ray.origin.x()) /
                         (ray.direction.y() + 0.3 * ray.direction.x());
        if (x < 2 * kWidth / 3 && s > 0)
          wall[y * kWidth + x] = float(s);
      }
    }
    EXPECT_LE(errorOf(camera, scene, media, {.background = Rgb(0.1, 0.2, 0.5)}, wall), kBar);
    EXPECT_LE(errorOf(camera, scene, media, {.aov = Aov::kOpticalDepth}, wall), 1e-4);
  }
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

  GlSmoke onDevice() const { return {locator, extinction, source}; }

  AnyMedium medium() const { return AnyMedium(TetMedium(locator, extinction, source)); }

  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction, source;
};

TEST_F(GlRendererTest, SmokeIsThatOfTheReference) {
  const auto box = boxMesh({Vec3(0, 0, 0), Vec3(2, 1.5, 1)}, {6, 5, 4}, 0.3, 5);
  for (const bool lit : {false, true}) {
    for (const double thick : {0.8, 25.0}) {
      const Smoke smoke(box, lit, thick);
      const AnyMedium medium = smoke.medium();
      for (const Camera& camera : cameras(medium.bounds())) {
        EXPECT_LE(errorOf(camera, {.smokes = {smoke.onDevice()}}, {&medium, 1},
                          {.background = Rgb(0.3, 0.5, 0.1)}),
                  kBar)
            << "lit " << lit << ", thick " << thick << ", eye " << camera.eye().transpose();
      }
    }
  }
}

TEST_F(GlRendererTest, SmokeInAHallThatRaysLeaveAndReEnter) {
  const Smoke smoke(hallMesh(2.5, 3), true, 0.1);
  const AnyMedium medium = smoke.medium();
  const Box3 hall = medium.bounds();
  const Camera outside = Camera::framing(hall, kWidth, kHeight);
  const Camera inside = Camera::pinhole({hall.min + Vec3(2.3, 6.1, 1.7), hall.max - Vec3(1, 4, 3)},
                                        60, kWidth, kHeight);
  std::vector<float> wall(kWidth * kHeight, 9.0F);
  for (const Camera& camera : {outside, inside}) {
    EXPECT_LE(errorOf(camera, {.smokes = {smoke.onDevice()}}, {&medium, 1}, {}), kBar);
    EXPECT_LE(
        errorOf(camera, {.smokes = {smoke.onDevice()}}, {&medium, 1}, {.aov = Aov::kOpticalDepth}),
        kBar);
  }
  EXPECT_LE(errorOf(inside, {.smokes = {smoke.onDevice()}}, {&medium, 1}, {}, wall), kBar);
}

TEST_F(GlRendererTest, SmokeVolumeAndFogOverlap) {
  const Smoke smoke(boxMesh({Vec3(-0.8, 2.2, 0.6), Vec3(1, 3.5, 2.9)}, {4, 4, 5}, 0.2, 2), true,
                    1.5);
  const auto fire = sliceOf(3, Basis::kTrilinear);
  const FogMedium fog =
      fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[1].profile, {.degree = 1}, 0.9, 0.6);
  const std::vector<AnyMedium> media{AnyMedium(VoxelMedium(fire, 2, 3)), AnyMedium(fog),
                                     smoke.medium()};
  const GlScene scene{.volumes = {{fire, 2, 3}}, .fogs = {fog}, .smokes = {smoke.onDevice()}};
  const Camera camera =
      Camera::pinhole({Vec3(0.2, -1, 2.6), Vec3(0.3, 3.2, 1.2)}, 50, kWidth, kHeight);
  EXPECT_LE(errorOf(camera, scene, media, {.background = Rgb(0.1, 0.2, 0.5)}), kBar);
}

TEST_F(GlRendererTest, RefusesWhatItCannotRender) {
  const FogMedium fog = fogtest::fog(fogtest::map(9, 9), fogtest::profiles()[0].profile,
                                     {.levels = 2, .detail = {.cellAngle = 0.01}});
  const Camera camera = Camera::framing({Vec3(0, 0, 0), Vec3(1, 1, 1)}, 16, 16);
  const auto image = renderer_->render(camera, {.fogs = {fog}}, {}, quiet_);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kUnsupported);
  const std::vector<float> wrong(5, 1.0F);
  EXPECT_EQ(renderer_->render(camera, {}, {}, quiet_, nullptr, wrong).error().code,
            ErrorCode::kInvalidArgument);
}

TEST_F(GlRendererTest, AnEmptySceneIsItsBackground) {
  const VolumeInfo info = infoOf(1, Basis::kBox);
  const auto nothing = std::make_shared<const BrickSlice>(info);
  const Camera camera = Camera::framing(info.bounds, 16, 16);
  for (const GlScene& scene : {GlScene{}, GlScene{.volumes = {{nothing, 1, 1}}}}) {
    const Image image =
        renderer_->render(camera, scene, {.background = Rgb(0.25, 0.5, 1)}, quiet_).value();
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) EXPECT_EQ(image.pixels[i], 0.25F);
  }
}

}  // namespace
}  // namespace volute
