// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_faults.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "volute/image/srgb.hpp"
#include "volute/tomography/camera_correction.hpp"
#include "volute/tomography/fault_level.hpp"
#include "volute/tomography/testing.hpp"

namespace volute {
namespace {

using Views = std::vector<TomographyView>;
using Kind = CaptureFault::Kind;

/// Pictures and voxels no finer than the search needs.
TestScene smallScene(int cameras, double noise = 0, double phase = 0) {
  TestScene scene(cameras, noise, phase, 28, 26);
  scene.geometry.resolution = {14, 14, 14};
  return scene;
}

/// Columns, rows or both in the other order.
void turn(TomographyView& view, bool columns, bool rows) {
  const Image before = view.radiance;
  for (int y = 0; y < before.height; ++y)
    for (int x = 0; x < before.width; ++x)
      for (int c = 0; c < 3; ++c)
        view.radiance.at(x, y, c) =
            before.at(columns ? before.width - 1 - x : x, rows ? before.height - 1 - y : y, c);
}

void encode(TomographyView& view, double white) {
  for (float& value : view.radiance.pixels)
    value = static_cast<float>(white * srgbEncode(value / white));
}

void decode(TomographyView& view, double white) {
  for (float& value : view.radiance.pixels)
    value = static_cast<float>(white * srgbDecode(value / white));
}

double brightestOf(const Views& views) {
  double most = 0;
  for (const TomographyView& view : views)
    for (const float value : view.radiance.pixels) most = std::max<double>(most, value);
  return most;
}

std::vector<CaptureFault> faultsOf(const TestScene& scene, const Views& views, double white) {
  Progress progress;
  const std::vector<double> whites(views.size(), white);
  const auto faults = findCaptureFaults(views, whites, scene.geometry, progress);
  EXPECT_TRUE(faults) << (faults ? "" : faults.error().message);
  return faults.value_or(std::vector<CaptureFault>{});
}

struct Injected {
  const char* name;
  Kind kind;
  std::vector<std::size_t> cameras;
  std::function<void(Views&, double white)> inject;
};

class InjectedFault : public testing::TestWithParam<Injected> {};

TEST_P(InjectedFault, IsNamed) {
  const TestScene scene = smallScene(6);
  Views views = scene.views;
  const double white = brightestOf(views);
  GetParam().inject(views, white);
  const auto faults = faultsOf(scene, views, white);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, GetParam().kind) << faults[0].text;
  EXPECT_EQ(faults[0].cameras, GetParam().cameras) << faults[0].text;
}

INSTANTIATE_TEST_SUITE_P(
    All, InjectedFault,
    testing::Values(
        Injected{
            "Mirrored", Kind::kMirrored, {2}, [](Views& v, double) { turn(v[2], true, false); }},
        Injected{"Flipped", Kind::kFlipped, {1}, [](Views& v, double) { turn(v[1], false, true); }},
        Injected{
            "UpsideDown", Kind::kUpsideDown, {4}, [](Views& v, double) { turn(v[4], true, true); }},
        Injected{"OtherOrder",
                 Kind::kOrder,
                 {},
                 [](Views& v, double) {
                   const Image first = v[0].radiance;
                   for (std::size_t i = 0; i + 1 < v.size(); ++i) v[i].radiance = v[i + 1].radiance;
                   v.back().radiance = first;
                 }},
        Injected{"HalfExposure",
                 Kind::kGain,
                 {2},
                 [](Views& v, double) {
                   for (float& value : v[2].radiance.pixels) value *= 0.5F;
                 }},
        Injected{"AllFlipped",
                 Kind::kFlipped,
                 {},
                 [](Views& v, double) {
                   for (TomographyView& view : v) turn(view, false, true);
                 }},
        Injected{"AllMirrored",
                 Kind::kMirrored,
                 {},
                 [](Views& v, double) {
                   for (TomographyView& view : v) turn(view, true, false);
                 }},
        Injected{"Exchanged",
                 Kind::kExchanged,
                 {1, 4},
                 [](Views& v, double) { std::swap(v[1].radiance, v[4].radiance); }},
        Injected{"NeighboursExchanged",
                 Kind::kExchanged,
                 {2, 3},
                 [](Views& v, double) { std::swap(v[2].radiance, v[3].radiance); }},
        Injected{"OneEncoded", Kind::kEncoded, {3}, [](Views& v, double w) { encode(v[3], w); }},
        Injected{"AllEncoded",
                 Kind::kEncoded,
                 {},
                 [](Views& v, double w) {
                   for (TomographyView& view : v) encode(view, w);
                 }},
        Injected{"OneDecoded", Kind::kDecoded, {0}, [](Views& v, double w) { decode(v[0], w); }},
        Injected{"AllDecoded",
                 Kind::kDecoded,
                 {},
                 [](Views& v, double w) {
                   for (TomographyView& view : v) decode(view, w);
                 }}),
    [](const auto& info) { return info.param.name; });

TEST(CaptureFaults, GainsAreMeasured) {
  const TestScene scene = smallScene(6);
  Views views = scene.views;
  for (float& value : views[2].radiance.pixels) value *= 0.5F;
  const auto faults = faultsOf(scene, views, brightestOf(views));
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_NEAR(faults[0].value, 2, 0.1);
  EXPECT_NE(faults[0].text.find(" % too dark: its radiance times"), std::string::npos)
      << faults[0].text;
}

TEST(CaptureFaults, FocalLengthsThatAreALittleOffAreMeasured) {
  const TestScene scene = smallScene(6);
  for (const double factor : {0.92, 1.08}) {
    Views views = scene.views;
    const auto zoomed = corrected(views[1].camera, zoomBy(factor));
    ASSERT_TRUE(zoomed);
    views[1].camera = *zoomed;
    const auto faults = faultsOf(scene, views, brightestOf(views));
    ASSERT_EQ(faults.size(), 1U) << factor;
    EXPECT_EQ(faults[0].kind, Kind::kZoom) << faults[0].text;
    EXPECT_EQ(faults[0].cameras, std::vector<std::size_t>{1});
    EXPECT_NEAR(faults[0].value, 1 / factor, 0.02);
  }
}

TEST(CaptureFaults, HalfAPixelInAllCamerasIsToldByItsName) {
  TestScene scene(6, 0, 0, 40, 37);
  scene.geometry.resolution = {14, 14, 14};
  for (const double off : {0.5, -0.5}) {
    Views views = scene.views;
    CameraCorrection shift;
    shift.values[CameraCorrection::kPrincipal] = off;
    shift.values[CameraCorrection::kPrincipal + 1] = off;
    for (TomographyView& view : views) view.camera = *corrected(view.camera, shift);
    const auto faults = faultsOf(scene, views, brightestOf(views));
    ASSERT_EQ(faults.size(), 1U) << off;
    EXPECT_EQ(faults[0].kind, Kind::kShift) << faults[0].text;
    EXPECT_NEAR(faults[0].value, -off, 0.15);
    EXPECT_NE(faults[0].text.find(off < 0 ? "is the centre of the first pixel at 0, not at 0.5?"
                                          : "are they cropped?"),
              std::string::npos)
        << faults[0].text;
  }
}

/// Counterclockwise.
void turnLeft(TomographyView& view) {
  const Image before = view.radiance;
  for (int y = 0; y < before.height; ++y)
    for (int x = 0; x < before.width; ++x)
      for (int c = 0; c < 3; ++c) view.radiance.at(x, y, c) = before.at(before.width - 1 - y, x, c);
}

TEST(CaptureFaults, QuarterTurnsOfSquaresAreToldByTheirNames) {
  TestScene scene(6, 0, 0, 28, 28);
  scene.geometry.resolution = {14, 14, 14};
  for (const bool all : {false, true}) {
    for (const int quarters : {1, 3}) {
      Views views = scene.views;
      for (std::size_t v = 0; v < views.size(); ++v) {
        for (int i = 0; (all || v == 2) && i < quarters; ++i) turnLeft(views[v]);
      }
      const auto faults = faultsOf(scene, views, brightestOf(views));
      ASSERT_EQ(faults.size(), 1U);
      EXPECT_EQ(faults[0].kind, quarters == 1 ? Kind::kTurnedLeft : Kind::kTurnedRight)
          << faults[0].text;
      EXPECT_EQ(faults[0].cameras.empty(), all);
    }
  }
}

TEST(CaptureFaults, TheWhiteBalanceOfACameraIsMeasured) {
  const TestScene scene = smallScene(6);
  Views views = scene.views;
  for (std::size_t i = 0; i < views[3].radiance.pixels.size(); ++i)
    views[3].radiance.pixels[i] *= std::array{1.0F, 0.7F, 1.4F}[i % 3];
  const auto faults = faultsOf(scene, views, brightestOf(views));
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Kind::kBalance) << faults[0].text;
  EXPECT_EQ(faults[0].cameras, std::vector<std::size_t>{3});
  EXPECT_NEAR(faults[0].factors[0], 1, 0.02);
  EXPECT_NEAR(faults[0].factors[1], 1 / 0.7, 0.03);
  EXPECT_NEAR(faults[0].factors[2], 1 / 1.4, 0.02);
}

TEST(CaptureFaults, TheOrderOfDigitsIsOfNumbersFromTen) {
  EXPECT_EQ(cameraOrder(0, 3), (std::vector<std::size_t>{1, 2, 0}));
  EXPECT_EQ(cameraOrder(3, 12), (std::vector<std::size_t>{0, 1, 10, 11, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(CaptureFaults, AnotherOrderOfChannelsIsToldByItsName) {
  const TestScene scene = smallScene(6);
  Views views = scene.views;
  for (std::size_t i = 0; i < views[3].radiance.pixels.size(); i += 3)
    std::swap(views[3].radiance.pixels[i], views[3].radiance.pixels[i + 2]);
  const auto faults = faultsOf(scene, views, brightestOf(views));
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Kind::kChannels) << faults[0].text;
  EXPECT_EQ(faults[0].cameras, std::vector<std::size_t>{3});
  EXPECT_NE(faults[0].text.find("camera c3: red and blue exchanged"), std::string::npos)
      << faults[0].text;
}

TEST(CaptureFaults, BoundsThatCutTheMediumAreToldAlone) {
  TestScene scene = smallScene(6);
  scene.geometry.bounds.max.x() = 0;
  scene.geometry.resolution[0] = 7;
  const auto faults = faultsOf(scene, scene.views, brightestOf(scene.views));
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Kind::kBox) << faults[0].text;
  EXPECT_NE(faults[0].text.find("bounds cut what the cameras see"), std::string::npos);
}

/// Light around a point that falls off as Gauss's curve.
struct Kernel {
  Vec3 centre;
  double radius, light;
};

/// Its pictures in closed form, stored in 8 bits as sRGB with noise.
TestScene photographed(const std::vector<Kernel>& kernels, std::mt19937& random) {
  std::normal_distribution<double> normal;
  TestScene scene(6, 0, 0, 60, 55);
  scene.geometry.resolution = {24, 24, 24};
  double brightest = 0;
  for (TomographyView& view : scene.views) {
    for (std::size_t i = 0; i < view.radiance.pixels.size() / 3; ++i) {
      const Segment ray = view.camera.ray(static_cast<double>(i % view.radiance.width) + 0.5,
                                          static_cast<double>(i / view.radiance.width) + 0.5);
      double sum = 0;
      for (const Kernel& one : kernels) {
        const Vec3 to = one.centre - ray.origin;
        const double apart = to.squaredNorm() - std::pow(to.dot(ray.direction), 2);
        if (apart < 9 * one.radius * one.radius)
          sum += one.light * one.radius * std::exp(-0.5 * apart / (one.radius * one.radius));
      }
      for (int c = 0; c < 3; ++c)
        view.radiance.pixels[3 * i + c] = static_cast<float>(sum * (1 - 0.35 * c));
      brightest = std::max(brightest, sum);
    }
  }
  for (TomographyView& view : scene.views) {
    for (float& value : view.radiance.pixels) {
      const double stored = srgbEncode(0.9 * value / brightest) + 1.2 / 255 * normal(random);
      value = static_cast<float>(srgbDecode(std::round(255 * std::clamp(stored, 0.0, 1.0)) / 255));
    }
  }
  return scene;
}

/// Thin filaments of fire: light that a coarse volume does not resolve, which responses of other
/// curves would make flat.
TestScene filaments(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Kernel> kernels;
  for (int filament = 0; filament < 6; ++filament) {
    Vec3 at(0.2 * normal(random), 0.2 * normal(random), -0.85), along(0, 0, 1);
    for (int step = 0; step < 50; ++step) {
      along += 0.3 * Vec3(normal(random), normal(random), normal(random));
      along.z() = std::abs(along.z()) + 0.3;
      at += 0.035 * along.normalized();
      kernels.push_back({at, 0.04 + 0.03 * uniform(random), (1 - step / 70.0) * uniform(random)});
    }
  }
  return photographed(kernels, random);
}

/// A plume that widens as it rises, nearly round: wrong pictures of it are explained nearly as
/// well.
TestScene billows(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::vector<Kernel> kernels;
  for (int i = 0; i < 60; ++i) {
    const double height = uniform(random), angle = 2 * std::numbers::pi * uniform(random);
    const double away = (0.14 + 0.36 * height) * std::sqrt(uniform(random));
    kernels.push_back({Vec3(away * std::cos(angle), away * std::sin(angle), 1.5 * height - 0.75),
                       0.07 + 0.08 * uniform(random), 0.4 + 0.6 * uniform(random)});
  }
  return photographed(kernels, random);
}

class Responses : public testing::TestWithParam<unsigned> {};

TEST_P(Responses, OfFilamentsAreTold) {
  const TestScene scene = filaments(GetParam());
  for (const CaptureFault& fault : faultsOf(scene, scene.views, 1))
    ADD_FAILURE() << "nothing is wrong, but: " << fault.text;
  Views encoded = scene.views, decoded = scene.views;
  for (TomographyView& view : encoded) encode(view, 1);
  for (TomographyView& view : decoded) decode(view, 1);
  for (const auto& [views, kind] :
       {std::pair(&encoded, Kind::kEncoded), std::pair(&decoded, Kind::kDecoded)}) {
    const auto faults = faultsOf(scene, *views, 1);
    ASSERT_EQ(faults.size(), 1U) << static_cast<int>(kind);
    EXPECT_EQ(faults[0].kind, kind) << faults[0].text;
    EXPECT_TRUE(faults[0].cameras.empty()) << faults[0].text;
  }
}

TEST_P(Responses, OfOtherCurvesAreTold) {
  const TestScene scene = filaments(GetParam());
  Views views = scene.views;
  for (TomographyView& view : views) {
    for (float& value : view.radiance.pixels)
      value = srgbDecode(std::pow(std::max(0.0F, value), 1 / 1.8F));
  }
  const auto faults = faultsOf(scene, views, 1);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Kind::kExponent) << faults[0].text;
  EXPECT_NEAR(faults[0].value, 1.8 / 2.2, 0.1) << faults[0].text;
}

INSTANTIATE_TEST_SUITE_P(Seeds, Responses, testing::Values(1U, 2U));

class Billows : public testing::TestWithParam<unsigned> {};

TEST_P(Billows, AreMirroredAndFlippedByName) {
  const TestScene scene = billows(GetParam());
  for (const CaptureFault& fault : faultsOf(scene, scene.views, 1))
    ADD_FAILURE() << "nothing is wrong, but: " << fault.text;
  for (const Kind kind : {Kind::kMirrored, Kind::kFlipped}) {
    Views views = scene.views;
    for (TomographyView& view : views) turn(view, kind == Kind::kMirrored, kind == Kind::kFlipped);
    const auto faults = faultsOf(scene, views, 1);
    ASSERT_EQ(faults.size(), 1U) << static_cast<int>(kind);
    EXPECT_EQ(faults[0].kind, kind) << faults[0].text;
    EXPECT_TRUE(faults[0].cameras.empty()) << faults[0].text;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Billows, testing::Values(1U));

TEST(CaptureFaults, TwoAreNamedOneAfterTheOther) {
  const TestScene scene(7);  // two are not told apart in smaller pictures
  Views views = scene.views;
  turn(views[5], true, false);
  std::swap(views[0].radiance, views[2].radiance);
  const auto faults = faultsOf(scene, views, brightestOf(views));
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_NE(faults[0].kind, faults[1].kind);
  for (const CaptureFault& fault : faults)
    EXPECT_EQ(fault.cameras, fault.kind == Kind::kMirrored ? std::vector<std::size_t>({5})
                                                           : std::vector<std::size_t>({0, 2}));
}

TEST(CaptureFaults, TwoOfSingleCamerasAreNoCurveOfAll) {
  for (const double phase : {0.0, 1.0, 2.0}) {
    const TestScene scene = smallScene(6, 0, phase);
    Views views = scene.views;
    for (float& value : views[1].radiance.pixels) value *= 0.6F;
    CameraCorrection correction;
    correction.values[CameraCorrection::kPrincipal] = 3;
    views[4].camera = *corrected(views[4].camera, correction);
    for (const CaptureFault& fault : faultsOf(scene, views, brightestOf(views)))
      EXPECT_FALSE(fault.cameras.empty()) << fault.text;
  }
}

TEST(CaptureFaults, CleanPicturesHaveNone) {
  for (const int cameras : {4, 5, 8}) {
    for (const double noise : {0.0, 0.05}) {
      const TestScene scene = smallScene(cameras, noise);
      EXPECT_TRUE(faultsOf(scene, scene.views, brightestOf(scene.views)).empty())
          << cameras << " cameras, noise " << noise;
    }
  }
}

TEST(CaptureFaults, WhatNoneOfThemExplainsIsNotNamed) {
  // Another scene in one camera: wrong, but not mirrored.
  const TestScene scene = smallScene(6), other = smallScene(6, 0, 2);
  Views views = scene.views;
  views[3].radiance = other.views[3].radiance;
  for (const CaptureFault& fault : faultsOf(scene, views, brightestOf(views)))
    ADD_FAILURE() << fault.text;
}

}  // namespace
}  // namespace volute
