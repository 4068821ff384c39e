// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruct.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/capture/optical_depth.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Reconstruction solved(const TestScene& scene, const TomographyOptions& options,
                      std::span<const float> start = {}) {
  Progress progress;
  auto result = reconstruct(scene.views, scene.geometry, options, start, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? *result : Reconstruction{};
}

std::string failure(std::span<const TomographyView> views, const VolumeGeometry& geometry,
                    const TomographyOptions& options, ErrorCode code) {
  Progress progress;
  const auto result = reconstruct(views, geometry, options, {}, progress);
  EXPECT_FALSE(result);
  if (result)
    return {};
  EXPECT_EQ(result.error().code, code);
  return result.error().message;
}

struct Method {
  const char* name;
  TomographyOptions options;
  double error;  ///< relative L2 of the volume that it must reach
};

TomographyOptions method(TomographySolver solver, Regularization regularization, double lambda,
                         Basis basis = Basis::kTrilinear) {
  TomographyOptions options;
  options.solver = solver;
  options.regularization = regularization;
  options.lambda = lambda;
  options.basis = basis;
  options.raysPerPixel = 1;
  options.iterations = 100;
  return options;
}

class MethodTest : public testing::TestWithParam<Method> {};

TEST_P(MethodTest, FindsTheVolume) {
  const TestScene scene(9);
  const Reconstruction result = solved(scene, GetParam().options);
  EXPECT_LT(scene.error(result.volume), GetParam().error);
  for (float value : result.volume) EXPECT_GE(value, 0);
  ASSERT_EQ(result.residual.size(), 9U);
  for (double residual : result.residual) EXPECT_LT(residual, 0.1);
}

const auto kNone = Regularization::kNone;
INSTANTIATE_TEST_SUITE_P(
    All, MethodTest,
    testing::Values(
        Method{"Apg", method(TomographySolver::kApg, kNone, 0), 0.12},
        Method{"ApgBox", method(TomographySolver::kApg, kNone, 0, Basis::kBox), 0.25},
        Method{"Mlem", method(TomographySolver::kMlem, kNone, 0), 0.17},
        Method{"Sirt", method(TomographySolver::kSirt, kNone, 0), 0.17},
        Method{"Cgls", method(TomographySolver::kCgls, kNone, 0), 0.25},
        Method{"Tv", method(TomographySolver::kApg, Regularization::kTv, 1e-4), 0.1},
        Method{"Smooth", method(TomographySolver::kApg, Regularization::kSmooth, 1e-5), 0.12},
        Method{"Wavelet", method(TomographySolver::kApg, Regularization::kWavelet, 1e-4), 0.12}),
    [](const auto& info) { return info.param.name; });

TEST(Reconstruct, AutomaticIsNearTheBestStrength) {
  for (double noise : {0.0, 0.03}) {
    const TestScene scene(9, noise);
    TomographyOptions options;
    const Reconstruction automatic = solved(scene, options);
    ASSERT_TRUE(automatic.choice);
    EXPECT_GT(automatic.heldOutError, 0);
    double best = 1;
    options.regularization = Regularization::kTv;
    for (double lambda : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {
      options.lambda = lambda;
      best = std::min(best, scene.error(solved(scene, options).volume));
    }
    EXPECT_LT(scene.error(automatic.volume), 1.4 * best) << "noise " << noise;
  }
}

TEST(Reconstruct, StopsByDiscrepancyBeforeItFitsTheNoise) {
  const TestScene scene(7, 0.03);
  TomographyOptions options;
  options.regularization = kNone;
  options.noiseSigma = 0.03;
  const Reconstruction stopped = solved(scene, options);
  EXPECT_EQ(stopped.stoppedBy, "discrepancy");
  options.iterations = 300;
  EXPECT_LT(scene.error(stopped.volume), scene.error(solved(scene, options).volume));
}

TEST(Reconstruct, StopsByHeldOutPixelsWhenTheNoiseIsUnknown) {
  const TestScene scene(7, 0.03);
  TomographyOptions options;
  options.regularization = kNone;
  const Reconstruction stopped = solved(scene, options);
  EXPECT_EQ(stopped.stoppedBy, "held-out pixels");
  options.iterations = 300;
  EXPECT_LT(scene.error(stopped.volume), scene.error(solved(scene, options).volume));
}

TEST(Reconstruct, SaysWhenItStoppedForNothingBetter) {
  const TestScene scene(3);
  TomographyOptions options;
  options.regularization = kNone;
  options.raysPerPixel = 1;
  options.noiseSigma = 1e-9;  // never reached
  EXPECT_EQ(solved(scene, options).stoppedBy, "limit");
  options.iterations = 2;
  EXPECT_EQ(solved(scene, options).stoppedBy, "iterations");
}

TEST(Reconstruct, WarmStartNeedsFewerIterations) {
  const TestScene before(7), now(7, 0, 0.05);
  TomographyOptions options;
  options.regularization = kNone;
  options.iterations = 60;
  const Reconstruction first = solved(before, options);
  options.iterations = 5;
  EXPECT_LT(now.error(solved(now, options, first.volume).volume),
            0.9 * now.error(solved(now, options).volume));
}

/// Priors that make the result depend on more than the data.
class WarmStartTest : public testing::TestWithParam<Regularization> {};

TEST_P(WarmStartTest, EndsWhereAColdStartEnds) {
  const TestScene before(5), now(5, 0, 0.05);
  TomographyOptions options;
  options.regularization = GetParam();
  options.lambda = 1e-4;
  options.iterations = 150;
  const Reconstruction first = solved(before, options);
  const Reconstruction cold = solved(now, options), warm = solved(now, options, first.volume);
  EXPECT_NEAR(now.error(warm.volume), now.error(cold.volume), 0.01);
  options.iterations = 6;
  EXPECT_LT(now.error(solved(now, options, first.volume).volume),
            0.9 * now.error(solved(now, options).volume));
}

INSTANTIATE_TEST_SUITE_P(Priors, WarmStartTest,
                         testing::Values(Regularization::kTv, Regularization::kSmooth,
                                         Regularization::kWavelet));

TEST(Reconstruct, CoarseToFineFindsTheVolume) {
  const TestScene scene(7);
  TomographyOptions options;
  options.coarseToFine = true;
  options.regularization = Regularization::kTv;
  options.lambda = 1e-4;
  EXPECT_LT(scene.error(solved(scene, options).volume), 0.12);
}

TEST(Reconstruct, SameForAnyNumberOfThreads) {
  const TestScene scene(5, 0.01);
  std::vector<std::vector<float>> volumes;
  for (int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    volumes.push_back(solved(scene, {}).volume);
  }
  EXPECT_EQ(volumes[0], volumes[1]);
}

TEST(Reconstruct, NegativeValuesOnlyIfAllowed) {
  const TestScene scene(4, 0.05);
  TomographyOptions options;
  options.regularization = kNone;
  options.iterations = 50;
  options.hull = false;
  options.nonNegative = false;
  const auto volume = solved(scene, options).volume;
  EXPECT_LT(*std::ranges::min_element(volume), 0);
}

TEST(Reconstruct, SaturatedPixelsWithoutWeightDoNoHarm) {
  TestScene scene(8);
  const Reconstruction clean = solved(scene, {});
  for (TomographyView& view : scene.views) {
    view.weight.assign(view.radiance.pixels.size() / 3, 1.0F);
    for (std::size_t i = 0; i < view.weight.size(); ++i) {
      float* pixel = &view.radiance.pixels[3 * i];
      if (pixel[0] > 1.6F) {
        view.weight[i] = 0;
        pixel[0] = pixel[1] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  EXPECT_LT(scene.error(solved(scene, {}).volume), 2 * scene.error(clean.volume));
}

/// Pictures whose channels end at `white`.
void saturate(TestScene& scene, float white) {
  for (TomographyView& view : scene.views) {
    auto& pixels = view.radiance.pixels;
    view.weight.assign(pixels.size() / 3, 1.0F);
    view.atLeast.assign(pixels.size() / 3, 0);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i] < white)
        continue;
      pixels[i] = white;
      view.weight[i / 3] = 0;
      view.atLeast[i / 3] |= static_cast<std::uint8_t>(1U << i % 3);
    }
  }
}

TEST(Reconstruct, SaturatedPixelsAreBounds) {
  TestScene scene(8);
  TomographyOptions options;
  options.lambda = 1e-5;
  options.iterations = 100;
  saturate(scene, 0.6F);
  const double bounded = scene.error(solved(scene, options).volume);
  for (TomographyView& view : scene.views) view.atLeast.clear();
  const double leftOut = scene.error(solved(scene, options).volume);
  EXPECT_LT(bounded, 0.6 * leftOut);
}

/// The scene as optical depths, `strength` times as thick, of pictures with noise of 1 % of the
/// background.
void becomeDepths(TestScene& scene, float strength) {
  constexpr float kNoise = 0.01F;
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (TomographyView& view : scene.views) {
    Image light = view.radiance, background = view.radiance;
    std::ranges::fill(background.pixels, 1.0F);
    for (float& value : light.pixels) value = std::exp(-strength * value) + kNoise * normal(random);
    OpticalDepths depths = opticalDepths(light, background, {}, 3 * kNoise);
    view.radiance = std::move(depths.depth);
    for (float& value : view.radiance.pixels) value /= strength;
    view.weight = std::move(depths.weight);
    view.atLeast = std::move(depths.atLeast);
    view.opticalDepth = true;
  }
}

TEST(Reconstruct, DarkOpticalDepthsTellLess) {
  TestScene scene(9);
  becomeDepths(scene, 3);
  TomographyOptions options;
  options.lambda = 1e-4;
  options.iterations = 80;
  const double weighed = scene.error(solved(scene, options).volume);
  for (TomographyView& view : scene.views) {
    for (std::size_t i = 0; i < view.weight.size(); ++i) view.weight[i] = view.weight[i] > 0;
    view.opticalDepth = false;
  }
  EXPECT_LT(weighed, 0.9 * scene.error(solved(scene, options).volume));
  EXPECT_LT(weighed, 0.25);
}

TEST(Reconstruct, NothingSaturatedIsNothingElse) {
  TestScene scene(5);
  TomographyOptions options;
  options.lambda = 1e-5;
  options.iterations = 20;
  const auto plain = solved(scene, options).volume;
  saturate(scene, 1e9F);
  EXPECT_EQ(solved(scene, options).volume, plain);
}

TEST(Reconstruct, RefusesWhatMakesNoSense) {
  const TestScene scene(4);
  const auto invalid = ErrorCode::kInvalidArgument;
  EXPECT_THAT(failure({}, scene.geometry, {}, invalid), HasSubstr("no view"));
  VolumeGeometry flat = scene.geometry;
  flat.bounds.max.z() = flat.bounds.min.z();
  EXPECT_THAT(failure(scene.views, flat, {}, invalid), HasSubstr("bounds"));
  TomographyOptions options;
  options.raysPerPixel = 3;
  EXPECT_THAT(failure(scene.views, scene.geometry, options, invalid), HasSubstr("rays"));
  options = {};
  options.solver = TomographySolver::kSirt;
  options.regularization = Regularization::kTv;
  EXPECT_THAT(failure(scene.views, scene.geometry, options, invalid), HasSubstr("sirt"));
  options = {};
  options.lambda = -1;
  EXPECT_THAT(failure(scene.views, scene.geometry, options, invalid), HasSubstr("lambda"));

  options = {};
  options.maxMemory = 1 << 20;
  EXPECT_THAT(failure(scene.views, scene.geometry, options, ErrorCode::kTooLarge),
              HasSubstr("would fit"));

  options.maxMemory = 300 << 10;  // 20^3 voxels, 40 bytes each
  EXPECT_THAT(failure(scene.views, scene.geometry, options, ErrorCode::kTooLarge),
              AllOf(HasSubstr("A volume of 20 x 20 x 20 voxels needs"),
                    HasSubstr("(the values of 19 x 19 x 19 would fit)")));
  EXPECT_EQ(checkVolumeSize({scene.geometry.bounds, {512, 512, 512}}, 500 << 20).error().code,
            ErrorCode::kTooLarge);
  EXPECT_THAT(checkVolumeSize({scene.geometry.bounds, {1500, 8, 8}}, 1 << 30).error().message,
              HasSubstr("1 to 1024 voxels"));

  auto views = scene.views;
  views[2].radiance = Image(44, 48);
  EXPECT_THAT(failure(views, scene.geometry, {}, invalid), HasSubstr("Camera c2"));
  views = scene.views;
  views[1].radiance.at(5, 6) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(failure(views, scene.geometry, {}, ErrorCode::kInvalidData),
              HasSubstr("Camera c1: pixel (5, 6)"));
  views = scene.views;
  views[3].radiance = Image(48, 44);
  EXPECT_THAT(failure(views, scene.geometry, {}, ErrorCode::kNotFound), HasSubstr("Camera c3"));
  VolumeGeometry away = scene.geometry;
  away.bounds = {Vec3::Constant(0.8), Vec3::Constant(0.98)};
  EXPECT_THAT(failure(scene.views, away, {}, ErrorCode::kNotFound), HasSubstr("hull is empty"));
}

TEST(Reconstruct, CanBeCancelled) {
  struct Impatient : Progress {
    bool cancelled() const override { return true; }
  } impatient;

  const TestScene scene(3);
  const auto result = reconstruct(scene.views, scene.geometry, {}, {}, impatient);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kCancelled);
}

TEST(Names, RoundTrip) {
  for (const char* name : {"apg", "mlem", "sirt", "cgls"})
    EXPECT_EQ(tomographySolverName(*tomographySolverByName(name)), name);
  for (const char* name : {"auto", "none", "tv", "smooth", "wavelet"})
    EXPECT_EQ(regularizationName(*regularizationByName(name)), name);
  EXPECT_FALSE(tomographySolverByName("art"));
  EXPECT_FALSE(regularizationByName(""));
}

TEST(Reconstruct, AGreyCameraTellsTheMeanOfTheChannels) {
  TestScene scene(6);
  TomographyOptions options;
  options.regularization = Regularization::kNone;
  options.iterations = 60;
  const double colours = scene.error(solved(scene, options).volume);
  TomographyView& grey = scene.views[2];
  for (std::size_t i = 0; i < grey.radiance.pixels.size(); i += 3) {
    float* light = &grey.radiance.pixels[i];
    std::fill_n(light, 3, (light[0] + light[1] + light[2]) / 3);
  }
  const auto taken = solved(scene, options);
  const double asColours = scene.error(taken.volume);
  grey.grey = true;
  const auto right = solved(scene, options);
  EXPECT_LT(scene.error(right.volume), 1.15 * colours);
  EXPECT_GT(asColours, 1.5 * colours);
  EXPECT_LT(right.residual[2], 0.3 * taken.residual[2]);
}

TEST(Reconstruct, OfThreeViewsSparsityIsNotJudged) {
  TestScene scene(3, 0.02);
  TomographyOptions options;
  const auto byItself = solved(scene, options);
  EXPECT_EQ(byItself.sparsity, 0);
  options.sparsity = 1;
  EXPECT_EQ(solved(scene, options).sparsity, 1);
}

}  // namespace
}  // namespace volute
