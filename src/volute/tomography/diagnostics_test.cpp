// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::StartsWith;

TomographyDiagnosis diagnosed(const TestScene& scene, const TomographyOptions& options = {}) {
  Progress progress;
  const auto result = reconstruct(scene.views, scene.geometry, options, {}, progress);
  EXPECT_TRUE(result);
  if (!result)
    return {};
  const auto diagnosis = diagnose(scene.views, scene.geometry, options, *result, progress);
  EXPECT_TRUE(diagnosis);
  return diagnosis ? *diagnosis : TomographyDiagnosis{};
}

/// Sentences on cameras, with their names, and on all.
std::vector<std::string> warningsOf(const TestScene& scene, const TomographyDiagnosis& found) {
  std::vector<std::string> all = found.warnings;
  for (std::size_t v = 0; v < found.cameras.size(); ++v) {
    const CameraDiagnosis& camera = found.cameras[v];
    EXPECT_EQ(camera.warning.empty(), !camera.outOfStep && !camera.gainDrift) << v;
    if (!camera.warning.empty())
      all.push_back("camera " + scene.views[v].name + " " + camera.warning);
  }
  return all;
}

std::vector<std::string> warningsOf(const TestScene& scene, const TomographyOptions& options = {}) {
  return warningsOf(scene, diagnosed(scene, options));
}

/// The camera with its principal point moved and another lens.
Camera recalibrated(const Camera& camera, const Vec2& moved, const Distortion& lens) {
  Mat3 k = camera.intrinsics();
  k(0, 2) += moved.x(), k(1, 2) += moved.y();
  const auto made = Camera::calibrated({camera.width(), camera.height(), k, camera.rotation(),
                                        -(camera.rotation() * camera.eye()), lens, 0.5});
  EXPECT_TRUE(made);
  return *made;
}

/// The camera with R transposed, as if it were the way from the camera to the world.
Camera turned(const Camera& camera) {
  const auto made = Camera::calibrated({camera.width(),
                                        camera.height(),
                                        camera.intrinsics(),
                                        camera.rotation().transpose(),
                                        -(camera.rotation() * camera.eye()),
                                        {},
                                        0.5});
  EXPECT_TRUE(made);
  return *made;
}

TEST(Diagnose, ConsistentDataWarnOfNothing) {
  for (const double noise : {0.0, 0.02})
    EXPECT_THAT(warningsOf(TestScene(7, noise)), IsEmpty()) << noise;
  TestScene coarse(7);
  coarse.geometry.resolution = {10, 10, 10};
  EXPECT_THAT(warningsOf(coarse), IsEmpty());
  TomographyOptions hasty;
  hasty.regularization = Regularization::kNone;
  hasty.iterations = 3;
  EXPECT_THAT(warningsOf(TestScene(7), hasty), IsEmpty());
  TomographyOptions strong;
  strong.lambda = 0.1;
  EXPECT_THAT(warningsOf(TestScene(7), strong), IsEmpty());
}

TEST(Diagnose, AFullHullIsAFaultWhereLightIsBesideTheVolume) {
  for (const float background : {0.0F, 0.3F}) {
    TestScene scene(7);
    for (TomographyView& view : scene.views)
      for (float& value : view.radiance.pixels) value += background;
    Progress progress;
    auto result = reconstruct(scene.views, scene.geometry, {}, {}, progress);
    ASSERT_TRUE(result);
    result->hullShare = 0.99;
    const auto found = diagnose(scene.views, scene.geometry, {}, *result, progress);
    ASSERT_TRUE(found);
    const auto warned = testing::Contains(HasSubstr("backgrounds to subtract"));
    if (background == 0)
      EXPECT_THAT(found->warnings, testing::Not(warned));
    else
      EXPECT_THAT(found->warnings, warned);
  }
}

TEST(Diagnose, NamesTheCameraOutOfStep) {
  TestScene scene(7);
  scene.views[4].radiance = TestScene(7, 0, 0.4).views[4].radiance;
  EXPECT_THAT(warningsOf(scene), ElementsAre(StartsWith("camera c4 does not fit the others")));
}

TEST(Diagnose, NamesTheCameraWithADriftedGain) {
  TestScene scene(7);
  for (float& value : scene.views[2].radiance.pixels) value *= 1.1F;
  const TomographyDiagnosis diagnosis = diagnosed(scene);
  EXPECT_NEAR(diagnosis.cameras[2].gain, 1 / 1.1, 0.02);
  EXPECT_THAT(warningsOf(scene, diagnosis),
              ElementsAre(MatchesRegex("camera c2 1[01] % too bright: its radiance times 0.9.*")));
}

TEST(Diagnose, AGainThatExplainsLittleIsNoGain) {
  TestScene scene(7);
  scene.views[1].camera = turned(scene.views[1].camera);
  EXPECT_THAT(warningsOf(scene), ElementsAre(StartsWith("camera c1 does not fit the others")));
}

TEST(Diagnose, NamesTheCameraWhosePrincipalPointIsWrong) {
  TestScene scene(7);
  scene.views[3].camera = recalibrated(scene.views[3].camera, Vec2(2.5, -1.5), {});
  EXPECT_THAT(warningsOf(scene), ElementsAre(StartsWith("camera c3 does not fit the others")));
}

TEST(Diagnose, NamesTheCameraWhoseLensIsLeftOut) {
  TestScene scene(7);
  const VolumeGeometry fine{scene.geometry.bounds, {40, 40, 40}};
  const Camera bent = recalibrated(scene.views[5].camera, Vec2::Zero(), {.k1 = 5});
  scene.views[5].radiance = projectVolume(TestScene::blobs(fine, 0), fine, Basis::kBox, bent, 4);
  EXPECT_THAT(warningsOf(scene), ElementsAre(StartsWith("camera c5 does not fit the others")));
}

TEST(Diagnose, NamesTwoCamerasAndNoThird) {
  TestScene scene(9);
  scene.views[3].camera = recalibrated(scene.views[3].camera, Vec2(4, -3), {});
  for (float& value : scene.views[6].radiance.pixels) value *= 1.3F;
  EXPECT_THAT(warningsOf(scene), ElementsAre(StartsWith("camera c3 does not fit the others"),
                                             MatchesRegex("camera c6 (29|3[0-3]) % too bright.*")));
}

TEST(Diagnose, TellsThatAllCamerasDisagree) {
  const auto disagree = ElementsAre(
      AllOf(StartsWith("the cameras disagree"), HasSubstr("pixel centres"), HasSubstr("lens")));
  TestScene shifted(7);
  for (TomographyView& view : shifted.views)
    view.camera = recalibrated(view.camera, Vec2(1, 1), {});
  EXPECT_THAT(warningsOf(shifted), disagree);
  TestScene exchanged(7);
  std::swap(exchanged.views[0].radiance, exchanged.views[3].radiance);
  std::swap(exchanged.views[1].radiance, exchanged.views[5].radiance);
  std::swap(exchanged.views[2].radiance, exchanged.views[4].radiance);
  EXPECT_THAT(warningsOf(exchanged), disagree);
}

TEST(Diagnose, AdvisesAgainstOppositeCameras) {
  std::vector<std::string> names;
  std::vector<Camera> cameras;
  for (int i = 0; i < 4; ++i) {
    const double angle = std::numbers::pi / 2 * i;
    names.push_back(fmt::format("c{}", i));
    cameras.push_back(Camera::pinhole(
        {Vec3(5 * std::cos(angle), 5 * std::sin(angle), 0), Vec3::Zero()}, 30, 8, 8));
  }
  const auto angles = sightAngles(cameras, Vec3::Zero());
  ASSERT_EQ(angles.size(), 6U);
  EXPECT_NEAR(angles[0].degrees, 90, 1e-9);
  EXPECT_NEAR(angles[1].degrees, 0, 1e-5);
  const auto advice = layoutAdvice(names, angles);
  ASSERT_TRUE(advice);
  EXPECT_THAT(advice->sentence, HasSubstr("c0 and c2 (0), c1 and c3 (0) degrees"));
  EXPECT_FALSE(layoutAdvice(names, std::span(angles).first(1)));
}

TEST(Diagnose, TellsOfCamerasThatAllLookFromOneSide) {
  const std::vector<std::string> names{"a", "b", "c"};
  const auto advice = [&](double widest) {
    const std::vector<SightAngle> angles{{0, 1, 8}, {0, 2, widest}, {1, 2, widest - 8}};
    return layoutAdvice(names, angles)->sentence;
  };
  EXPECT_THAT(advice(20), HasSubstr("all cameras look along lines within 20 degrees"));
  EXPECT_THAT(advice(40), HasSubstr("a and b (8) degrees"));
  EXPECT_FALSE(layoutAdvice(std::span(names).first(1), {}));
}

}  // namespace
}  // namespace volute
