// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/render.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "volute/base/parallel.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/render/scaled_medium.hpp"

namespace volute {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

VolumeInfo volumeInfo(int x, int y, int z, int channels, Basis basis, const Box3& bounds) {
  VolumeInfo info;
  info.x = x, info.y = y, info.z = z;
  info.channels = channels;
  info.basis = basis;
  info.bounds = bounds;
  return info;
}

/// Random values in a ball, zero around it.
VoxelMedium cloud(int channels, Basis basis, double emission, double extinction,
                  const Vec3& at = Vec3::Zero()) {
  const VolumeInfo info =
      volumeInfo(19, 17, 23, channels, basis, {at - Vec3::Constant(0.5), at + Vec3::Constant(0.5)});
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> values(info.frameValues());
  for (std::size_t i = 0; i < info.voxels(); ++i) {
    const auto x = i % 19, y = i / 19 % 17, z = i / (19 * 17);
    const bool inside = std::hypot(x / 9.0 - 1, y / 8.0 - 1, z / 11.0 - 1) < 0.9;
    for (int c = 0; c < channels; ++c) values[i * channels + c] = inside ? uniform(random) : 0;
  }
  return {std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), emission, extinction};
}

/// A volume of one voxel of value 1.
AnyMedium block(const Box3& bounds, double emission, double extinction) {
  const VolumeInfo info = volumeInfo(1, 1, 1, 1, Basis::kBox, bounds);
  const std::vector<float> one{1};
  return AnyMedium(VoxelMedium(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, one)),
                               emission, extinction));
}

Image picture(const Camera& camera, std::span<const AnyMedium> media,
              const RenderOptions& options = {}, std::span<const float> opaque = {}) {
  Progress progress;
  auto image = render(camera, media, options, progress, nullptr, opaque);
  EXPECT_TRUE(image) << image.error().message;
  return image ? *std::move(image) : Image();
}

RenderOptions referenceOptions() {
  RenderOptions options;
  options.renderer = Renderer::kReference;
  return options;
}

/// The largest difference as a share of the brightest value of `a`.
double difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.pixels.size(), b.pixels.size());
  double worst = 0;
  double brightest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    brightest = std::max<double>(brightest, a.pixels[i]);
    const double error = std::abs(static_cast<double>(a.pixels[i]) - b.pixels[i]);
    if (!(error <= worst))
      worst = error;
  }
  return worst / brightest;
}

struct Case {
  std::string name;
  int channels;
  Basis basis;
  double extinction;
};

class RenderCases : public ::testing::TestWithParam<Case> {};

TEST_P(RenderCases, CpuAgreesWithTheReference) {
  const auto& [name, channels, basis, extinction] = GetParam();
  const AnyMedium medium(cloud(channels, basis, 2, extinction));
  const View3 oblique{Vec3(1.5, -2, 1), Vec3::Zero(), Vec3::UnitZ()};
  const View3 along{Vec3(0, -2, 0), Vec3::Zero(),
                    Vec3::UnitZ()};  // middle rays run in voxel planes
  const View3 inside{Vec3(0.1, 0.05, -0.1), Vec3(1, 1, 1), Vec3::UnitZ()};
  for (const Camera& camera :
       {Camera::pinhole(oblique, 35, 45, 37), Camera::pinhole(along, 35, 45, 37),
        Camera::pinhole(inside, 80, 33, 33), Camera::orthographic(oblique, 1.6, 35, 51),
        Camera::orthographic(along, 23.0 / 23, 19, 23), Camera::orthographic(along, 1, 46, 46),
        Camera::pinhole(oblique, 30, 1, 1)}) {
    const Image fast = picture(camera, {&medium, 1});
    const Image reference = picture(camera, {&medium, 1}, referenceOptions());
    EXPECT_LT(difference(reference, fast), 1e-5) << camera.width();
  }
}

INSTANTIATE_TEST_SUITE_P(All, RenderCases,
                         ::testing::Values(Case{"boxGrey", 1, Basis::kBox, 0},
                                           Case{"boxGreyAbsorbing", 1, Basis::kBox, 3},
                                           Case{"boxRgb", 3, Basis::kBox, 0},
                                           Case{"boxRgbAbsorbing", 3, Basis::kBox, 3},
                                           Case{"trilinearGrey", 1, Basis::kTrilinear, 0},
                                           Case{"trilinearGreyAbsorbing", 1, Basis::kTrilinear, 3},
                                           Case{"trilinearRgb", 3, Basis::kTrilinear, 0},
                                           Case{"trilinearRgbAbsorbing", 3, Basis::kTrilinear, 3}),
                         [](const auto& info) { return info.param.name; });

TEST(Render, OneBlockIsAClosedForm) {
  const Box3 bounds{Vec3(-1, -0.5, -1), Vec3(1, 0.5, 1)};
  const AnyMedium medium = block(bounds, 3, 0.7);
  RenderOptions options;
  options.background = Rgb(0.1, 0.2, 0.4);
  for (const Camera& camera :
       {Camera::pinhole({Vec3(2, -3, 1), Vec3::Zero(), Vec3::UnitZ()}, 50, 40, 30),
        Camera::orthographic({Vec3(2, -3, 1), Vec3::Zero(), Vec3::UnitZ()}, 3, 40, 30)}) {
    const Image image = picture(camera, {&medium, 1}, options);
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        const Segment ray = camera.ray(x + 0.5, y + 0.5);
        const double passed = std::exp(-0.7 * bounds.intersect(ray.origin, ray.direction).length());
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(image.at(x, y, c), 3 / 0.7 * (1 - passed) + passed * options.background[c],
                      1e-5);
        }
      }
    }
  }
}

TEST(Render, AnOrthographicPictureHoldsAllTheLightOfTheVolume) {
  // Rays through the middle of each voxel see exactly its column; oblique ones all of it up to the
  // sampling.
  for (Basis basis : {Basis::kBox, Basis::kTrilinear}) {
    const VoxelMedium voxels = cloud(3, basis, 2, 0);
    const AnyMedium medium(voxels);
    Rgb total = Rgb::Zero();
    const auto values = voxels.coefficients();
    for (std::size_t i = 0; i < values.size(); ++i) total[i % 3] += 2 * values[i] / (19 * 17 * 23);
    const auto light = [&](const Camera& camera) {
      const Image image = picture(camera, {&medium, 1});
      Rgb sum = Rgb::Zero();
      for (std::size_t i = 0; i < image.pixels.size(); ++i) sum[i % 3] += image.pixels[i];
      return Rgb(sum * camera.pixelSize() * camera.pixelSize());
    };
    const Rgb oblique =
        light(Camera::orthographic({Vec3(1, -2, 0.7), Vec3::Zero(), Vec3::UnitZ()}, 2, 300, 300));
    EXPECT_LT((oblique / total - 1).abs().maxCoeff(), 2e-4);
    // Pixels of 1/(19 * 23) m: 23 across and 19 up each voxel, so that no face cuts a pixel of the
    // box basis.
    const Rgb straight = light(
        Camera::orthographic({Vec3(0, -2, 0), Vec3::Zero(), Vec3::UnitZ()}, 483.0 / 437, 483, 483));
    EXPECT_LT((straight / total - 1).abs().maxCoeff(), 1e-5);
  }
}

TEST(Render, OverlappingMediaAdd) {
  const Box3 bounds{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  const Box3 back{Vec3(-1, 0, -1), Vec3(1, 1, 1)};
  const AnyMedium both[] = {block(bounds, 3, 0.7), block(back, 1, 0.3)};
  const Camera camera =
      Camera::orthographic({Vec3(0, -3, 0), Vec3::Zero(), Vec3::UnitZ()}, 1, 9, 9);
  const double front = 3 / 0.7 * (1 - std::exp(-0.7));
  const double behind = 4 / 1.0 * (1 - std::exp(-1.0));
  const Image image = picture(camera, both);
  EXPECT_NEAR(image.at(4, 4), front + std::exp(-0.7) * behind, 1e-5);
  EXPECT_LT(difference(picture(camera, both, referenceOptions()), image), 1e-5);
}

/// A block whose extinction depends on where a segment ends.
struct EndingBlock {
  AnyMedium block;

  Box3 bounds() const { return block.bounds(); }

  double extinction(const Vec3& point) const { return block.extinction(point); }

  Rgb emission(const Vec3& point) const { return block.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    block.opticalDepth(segments, depths);
    for (std::size_t i = 0; i < segments.size(); ++i) depths[i] *= segments[i].end;
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    block.pieces(segments, pieces);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (Piece& piece : pieces[i]) piece.extinction = piece.extinction * segments[i].end;
    }
  }

  bool dependsOnEnd() const { return true; }
};

TEST(Render, RaysAreCutWhereMediaBeginUnlessTheirEndDecides) {
  // What overlaps is a tenth of the long one.
  const Box3 along{Vec3(-1, -5, -1), Vec3(1, 5, 1)}, in{Vec3(-1, 0, -1), Vec3(1, 1, 1)};
  const Camera camera =
      Camera::orthographic({Vec3(0, -6, 0), Vec3::Zero(), Vec3::UnitZ()}, 1, 9, 9);
  const AnyMedium cut[] = {block(along, 3, 0.1), block(in, 1, 0.3)};
  EXPECT_LT(difference(picture(camera, cut, referenceOptions()), picture(camera, cut)), 1e-5);
  const AnyMedium whole[] = {AnyMedium(EndingBlock{block(along, 3, 0.01)}), block(in, 1, 0.3)};
  EXPECT_TRUE(whole[0].dependsOnEnd());
  EXPECT_FALSE(whole[1].dependsOnEnd());
  EXPECT_TRUE(scaledBy(2, whole[0]).dependsOnEnd());
  const std::vector<float> surfaces(81, 8.0F);
  EXPECT_LT(difference(picture(camera, whole, referenceOptions(), surfaces),
                       picture(camera, whole, {}, surfaces)),
            1e-5);
}

TEST(Render, MediaApartAreTakenInTheOrderOfTheRayWhateverTheList) {
  const AnyMedium near(cloud(3, Basis::kBox, 2, 3, Vec3(0, -2, 0)));
  const AnyMedium far(cloud(3, Basis::kTrilinear, 1, 5, Vec3(0, 2, 0.3)));
  const AnyMedium touching = block({Vec3(-0.5, -1.5, -0.5), Vec3(0.5, -0.5, 0.5)}, 1, 1);
  const AnyMedium one[] = {near, far, touching};
  const AnyMedium other[] = {far, touching, near};
  const Camera camera =
      Camera::pinhole({Vec3(0.2, -5, 0.5), Vec3::Zero(), Vec3::UnitZ()}, 30, 40, 40);
  RenderOptions options;
  options.background = Rgb::Ones();
  const Image image = picture(camera, one, options);
  EXPECT_EQ(image.pixels, picture(camera, other, options).pixels);
  RenderOptions reference = referenceOptions();
  reference.background = Rgb::Ones();
  EXPECT_LT(difference(picture(camera, one, reference), image), 1e-5);
}

TEST(Render, OpaqueSurfacesHideWhatIsBehind) {
  const AnyMedium medium = block({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 3, 0.5);
  const Camera camera =
      Camera::orthographic({Vec3(0, -3, 0), Vec3::Zero(), Vec3::UnitZ()}, 1, 2, 2);
  const std::vector<float> depth{1, 2.5F, kInfinity, 100};
  for (RenderOptions options : {RenderOptions{}, referenceOptions()}) {
    options.background = Rgb::Ones();
    const Image image = picture(camera, {&medium, 1}, options, depth);
    const auto light = [](double length) { return 6 * (1 - std::exp(-0.5 * length)); };
    EXPECT_EQ(image.at(0, 0), 0);
    EXPECT_NEAR(image.at(1, 0), light(0.5), 1e-5);
    EXPECT_NEAR(image.at(0, 1), light(2) + std::exp(-1.0), 1e-5);
    EXPECT_NEAR(image.at(1, 1), light(2), 1e-5);
  }
  Progress progress;
  EXPECT_FALSE(render(camera, {&medium, 1}, {}, progress, nullptr, std::span(depth).first(3)));
}

TEST(Render, OneChannelOfOpticalDepthOrTransmittance) {
  const AnyMedium media[] = {block({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 3, 0.5),
                             block({Vec3(-1, 0, -1), Vec3(1, 1, 1)}, 0, 0.25)};
  const Camera camera =
      Camera::orthographic({Vec3(0, -3, 0), Vec3::Zero(), Vec3::UnitZ()}, 1, 3, 3);
  RenderOptions options;
  options.aov = Aov::kOpticalDepth;
  const Image depth = picture(camera, media, options);
  EXPECT_EQ(depth.channels, 1);
  EXPECT_FLOAT_EQ(depth.at(1, 1), 1.25F);
  options.aov = Aov::kTransmittance;
  EXPECT_FLOAT_EQ(picture(camera, media, options).at(1, 1), std::exp(-1.25F));
}

TEST(Render, ASceneWithoutMediaIsItsBackground) {
  RenderOptions options;
  options.background = Rgb(1, 2, 3);
  const Image image = picture(Camera::framing(Box3{}, 5, 3), {}, options);
  EXPECT_EQ(image.at(4, 2, 2), 3);
}

TEST(Render, SamePictureForAnyNumberOfThreads) {
  const AnyMedium media[] = {AnyMedium(cloud(3, Basis::kTrilinear, 2, 3)),
                             AnyMedium(cloud(1, Basis::kBox, 2, 3, Vec3(0.9, 0.2, 0)))};
  const Camera camera = Camera::framing({Vec3::Constant(-0.5), Vec3(1.4, 0.5, 0.5)}, 70, 50);
  const Image image = picture(camera, media);
  for (int threads : {1, 2, 5}) {
    const ThreadLimit limit(threads);
    EXPECT_EQ(picture(camera, media).pixels, image.pixels);
  }
}

TEST(Render, MediaThatFillAPartOfThePictureAreWhole) {
  const AnyMedium media[] = {block({Vec3(0.2, -0.1, 0), Vec3(0.5, 0.3, 0.2)}, 3, 5),
                             block({Vec3(-0.4, 0.5, -0.3), Vec3(-0.3, 0.7, 0.1)}, 1, 2)};
  const View3 from{Vec3(0.3, -2, 0.4), Vec3::Zero(), Vec3::UnitZ()};
  for (const Camera& camera :
       {Camera::pinhole(from, 40, 150, 110), Camera::pinhole(from, 110, 150, 110),
        Camera::pinhole({Vec3(0.3, -0.6, 0.4), Vec3(0.4, 2, 0), Vec3::UnitZ()}, 90, 150, 110),
        Camera::pinhole({Vec3(0.3, 0.1, 0.1), Vec3(1, 2, 0), Vec3::UnitZ()}, 60, 150, 110),
        Camera::orthographic(from, 2, 150, 110),
        Camera::pinhole(from, 40, 150, 110).shifted(40.3, -20.6)}) {
    RenderOptions options;
    options.background = Rgb(0.3, 0.2, 0.1);
    const Image image = picture(camera, {&media[0], 1}, options);
    const Image both = picture(camera, media, options);
    options.aov = Aov::kOpticalDepth;
    const Image depths = picture(camera, {&media[0], 1}, options);
    int touched = 0;
    for (int y = 0; y < 110; ++y) {
      for (int x = 0; x < 150; ++x) {
        const Segment ray = camera.ray(x + 0.5, y + 0.5);
        Radiance light[2];
        for (int m = 0; m < 2; ++m) media[m].radiance({&ray, 1}, {&light[m], 1});
        double depth = 0;
        media[0].opticalDepth({&ray, 1}, {&depth, 1});
        touched += depth > 0;
        const Rgb color = light[0].emitted + light[0].transmittance * options.background;
        EXPECT_EQ(image.at(x, y, 1), static_cast<float>(color[1])) << x << ", " << y;
        EXPECT_EQ(depths.at(x, y), static_cast<float>(depth)) << x << ", " << y;
        const double passed = light[0].transmittance * light[1].transmittance;
        if (passed == 1)
          EXPECT_EQ(both.at(x, y, 0), static_cast<float>(options.background[0]));
        else
          EXPECT_NE(both.at(x, y, 0), static_cast<float>(options.background[0]));
      }
    }
    EXPECT_GT(touched, 10);
  }
}

TEST(Render, CountsWhatItDid) {
  const AnyMedium medium = block({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 3, 0.5);
  const Camera camera =
      Camera::orthographic({Vec3(0, -3, 0), Vec3::Zero(), Vec3::UnitZ()}, 1, 13, 7);
  Progress progress;
  RenderStats stats;
  ASSERT_TRUE(render(camera, {&medium, 1}, referenceOptions(), progress, &stats));
  EXPECT_EQ(stats.rays, 13u * 7);
  EXPECT_EQ(stats.segments, 13u * 7);
  EXPECT_EQ(stats.pieces, 13u * 7);
  EXPECT_GT(stats.milliseconds, 0);
}

TEST(Render, StopsWhenAsked) {
  class Stop : public Progress {
    bool cancelled() const override { return true; }
  } stop;

  const AnyMedium medium = block({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 3, 0.5);
  const auto image = render(Camera::framing(medium.bounds(), 200, 200), {&medium, 1}, {}, stop);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, ErrorCode::kCancelled);
}

TEST(Render, ChoosesAmongPixels) {
  const AnyMedium medium(cloud(3, Basis::kTrilinear, 1, 2));
  const Camera camera = Camera::framing(medium.bounds(), 40, 30);
  const Image whole = picture(camera, {&medium, 1});
  std::vector<std::uint8_t> only(40 * 30);
  for (std::size_t i = 0; i < only.size(); ++i) only[i] = i % 3 == 0;
  RenderOptions options;
  options.only = only;
  const Image some = picture(camera, {&medium, 1}, options);
  for (std::size_t i = 0; i < some.pixels.size(); ++i)
    EXPECT_EQ(some.pixels[i], only[i / 3] ? whole.pixels[i] : 0);
  options.only = std::span(only).first(7);
  Progress progress;
  EXPECT_FALSE(render(camera, {&medium, 1}, options, progress));
}

TEST(ScaledMedium, TakesAndSendsMore) {
  const AnyMedium one = block({Vec3(0, 0, 0), Vec3(2, 1, 1)}, 0.5, 0.25);
  const ScaledMedium more(one, 3);
  const Segment ray{Vec3(-1, 0.5, 0.5), Vec3::UnitX(), 0, 10};
  double depth = 0;
  more.opticalDepth({&ray, 1}, {&depth, 1});
  EXPECT_NEAR(depth, 1.5, 1e-6);
  Radiance light;
  AnyMedium(more).radiance({&ray, 1}, {&light, 1});
  EXPECT_NEAR(light.transmittance, std::exp(-1.5), 1e-6);
  EXPECT_NEAR(light.emitted[0], 2 * (1 - std::exp(-1.5)), 1e-6);
  EXPECT_NEAR(more.extinction(Vec3(1, 0.5, 0.5)), 0.75, 1e-6);
  EXPECT_NEAR(more.emission(Vec3(1, 0.5, 0.5))[1], 1.5, 1e-6);
}

}  // namespace
}  // namespace volute
