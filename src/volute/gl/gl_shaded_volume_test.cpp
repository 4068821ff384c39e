// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_shaded_volume.hpp"

#include <fmt/format.h>

#include "volute/gl/gl_part.hpp"
#include "volute/gl/gl_snapshot.hpp"
#include "volute/gl/gl_testing.hpp"
#include "volute/grid/voxel_march.hpp"
#include "volute/math/rotation.hpp"
#include "volute/media/volume/volume_medium.hpp"
#include "volute/medium/affine_medium.hpp"
#include "volute/render/scaled_medium.hpp"

// Volumes that are lit or burn, against the CPU.

namespace volute {

using namespace gltest;

namespace {

/// gltest::blobs with these channels: extinction, and what burns near one of the blobs.
ShadedVoxels voxels(bool burns, double thick) {
  VolumeInfo info = infoOf(1, Basis::kTrilinear);
  const std::vector<float> density = blobs(info);
  info.channels = burns ? 4 : 1;
  std::vector<float> values;
  for (std::size_t i = 0; i < density.size(); ++i) {
    values.push_back(static_cast<float>(thick) * density[i]);
    const float flame = density[i] > 0.8F ? density[i] : 0;
    if (burns)
      values.insert(values.end(), {3 * flame, 1.5F * flame, 0.4F * flame * flame});
  }
  return ShadedVoxels(std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)));
}

VolumeLighting lighting() {
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.5, 0.3, -0.8).normalized();
  sun.intensity = Rgb(2, 1.8, 1.4);
  Lamp point;
  point.position = Vec3(-1.4, 1.2, 2.3);
  point.intensity = Rgb(3, 4, 6);
  VolumeLighting all;
  all.albedo = Rgb(0.9, 0.8, 0.7), all.asymmetry = 0.3;
  all.lamps = {sun, point};
  all.surrounding = Rgb(0.05, 0.08, 0.1);
  return all;
}

class GlShadedVolumeTest : public GlRendererTest {
 protected:
  void TearDown() override { RecordProperty("largest difference", fmt::format("{:.2g}", worst_)); }

  /// The largest difference from the CPU, as a share of its brightest.
  double difference(const Camera& camera, const VolumeLight& light, double factor,
                    const RenderOptions& options, std::span<const float> opaque) {
    const AffineMap& place = light.lighting().place;
    const GlScene scene{
        {glPart(GlShadedVolume{[&](const Camera& at) { return seenFrom(light, at); },
                               {},
                               factor,
                               place.linear(),
                               place.toWorld(Vec3::Zero())})}};
    const AnyMedium medium =
        scaledBy(factor, AnyMedium(AffineMedium(AnyMedium(seenFrom(light, camera)), place)));
    const Image found = renderer_->render(camera, scene, options, quiet_, nullptr, opaque).value();
    const Image expected = render(camera, {&medium, 1}, options, quiet_, nullptr, opaque).value();
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
      const double error = std::abs(double(found.pixels[i]) - expected.pixels[i]);
      worst = !(error <= worst) ? error : worst;
      largest = std::max<double>(largest, expected.pixels[i]);
    }
    EXPECT_GT(largest, 1e-3) << "the test's picture is black";
    worst_ = std::max(worst_, worst / largest);
    return worst / largest;
  }

 private:
  double worst_ = 0;
};

constexpr double kAgreement = 2e-3;

TEST_F(GlShadedVolumeTest, SmokeAndFireLookAsOnTheCpuFromAllSides) {
  const Mat3 turn = turnAbout(Vec3(1, 2, -1).normalized(), 0.7);
  Mat3 shear;
  shear = Mat3(1, 0.4, 0, 0, 1.2, 0.2, 0, 0, 0.7);
  const Vec3 centre = infoOf(1, Basis::kTrilinear).bounds.centre();
  const auto about = [&](const Mat3& linear) {
    return AffineMap(linear, centre - linear * centre + Vec3(0.05, -0.1, 0.02));
  };
  for (const bool burns : {false, true}) {
    for (const double thick : {3.0, 60.0}) {  // also far more than 1 of depth in a cell
      for (const AffineMap& place : {AffineMap(), about(turn), about(turn * shear)}) {
        VolumeLighting inPlace = lighting();
        inPlace.place = place;
        const VolumeLight light(voxels(burns, thick), inPlace);
        int view = 0;
        for (const Camera& camera : cameras(infoOf(1, Basis::kTrilinear).bounds)) {
          EXPECT_LE(difference(camera, light, 1, {}, {}), kAgreement)
              << "burns " << burns << ", thick " << thick << ", view " << view << ", place "
              << place.linear();
          ++view;
        }
      }
    }
  }
}

/// Its light is not packed on the CPU, and is for OpenGL.
TEST_F(GlShadedVolumeTest, LightOfOneColourDoesToo) {
  VolumeLighting sunlit = lighting();
  sunlit.lamps.resize(1);
  sunlit.surrounding = Rgb::Zero(), sunlit.ownFire = false;
  for (const bool burns : {false, true}) {
    const VolumeLight light(voxels(burns, 5), sunlit);
    for (const Camera& camera : cameras(infoOf(1, Basis::kTrilinear).bounds)) {
      ASSERT_TRUE(light.seenFrom({false, camera.eye()}).march()->oneColor);
      EXPECT_LE(difference(camera, light, 1, {}, {}), kAgreement) << "burns " << burns;
    }
  }
}

TEST_F(GlShadedVolumeTest, FireWithoutLightAndBlackSmokeDoToo) {
  const Camera camera = cameras(infoOf(1, Basis::kTrilinear).bounds)[0];
  const VolumeLight fire(voxels(true, 5), {});
  EXPECT_LE(difference(camera, fire, 1, {}, {}), kAgreement);
  const VolumeLight smoke(voxels(false, 5), {});
  RenderOptions options;
  options.background = Rgb(0.2, 0.5, 0.9);
  EXPECT_LE(difference(camera, smoke, 1, options, {}), kAgreement);
}

TEST_F(GlShadedVolumeTest, SurfacesAndTheLawOfThePictureCount) {
  const VolumeLight light(voxels(true, 8), lighting());
  const auto views = cameras(infoOf(1, Basis::kTrilinear).bounds);
  std::vector<float> opaque(std::size_t{kWidth} * kHeight, INFINITY);
  const auto middle = static_cast<float>((views[0].eye() - Vec3(0, 3, 1.8)).norm());
  std::fill_n(opaque.begin(), opaque.size() / 2, middle);
  EXPECT_LE(difference(views[0], light, 0.375, {}, opaque), kAgreement);
  for (const Aov aov : {Aov::kOpticalDepth, Aov::kTransmittance})
    EXPECT_LE(difference(views[0], light, 2, {.aov = aov}, opaque), kAgreement);
}

TEST_F(GlShadedVolumeTest, LightIsUploadedAgainOnlyWhereItDiffers) {
  const auto uploads = [&](double asymmetry) {
    VolumeLighting around = lighting();
    around.asymmetry = asymmetry;
    const VolumeLight light(voxels(true, 3), around);
    const auto views = cameras(infoOf(1, Basis::kTrilinear).bounds);
    renderer_->takePasses();
    const GlScene scene{
        {glPart(GlShadedVolume{[&](const Camera& at) { return seenFrom(light, at); }})}};
    for (const std::size_t view : {0u, 0u, 1u})
      EXPECT_TRUE(renderer_->render(views[view], scene, {}, quiet_));
    std::int64_t times = 0;
    for (const GlPassTime& pass : renderer_->takePasses()) {
      if (pass.name == "upload")
        times += pass.times;
    }
    return times;
  };
  EXPECT_EQ(uploads(0.3), 3) << "values once, light for two views";
  EXPECT_EQ(uploads(0), 2);
}

}  // namespace
}  // namespace volute
