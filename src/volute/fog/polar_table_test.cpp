// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include "volute/fog/fog_testing.hpp"
#include "volute/fog/polar_fog.hpp"

namespace volute {
namespace {

struct Picture {
  Vec3 eye;
  std::vector<float> x, y, z, distance;

  EyeRays rays() const { return {eye, x, y, z, distance}; }

  void add(const Vec3& direction, double length) {
    x.push_back(static_cast<float>(direction.x()));
    y.push_back(static_cast<float>(direction.y()));
    z.push_back(static_cast<float>(direction.z()));
    distance.push_back(static_cast<float>(length));
  }
};

/// A pinhole picture over a bumpy ground, some of it sky.
Picture pinhole(const Vec3& eye, double yaw, int side = 60) {
  Picture picture{eye, {}, {}, {}, {}};
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double a = 1.4 * (i + 0.5) / side - 0.7, b = 0.25 - 0.5 * (j + 0.5) / side;
      const Vec3 d(std::cos(yaw) - a * std::sin(yaw), std::sin(yaw) + a * std::cos(yaw), b);
      const double length = b < -0.02 ? -eye.z() / b * (1 + 0.2 * std::sin(9 * a)) : 1e9;
      picture.add(d.normalized(),
                  b > 0.1 ? std::numeric_limits<double>::infinity() : std::min(length, 1e4));
    }
  }
  return picture;
}

/// Directions all around, up and down too.
Picture sphere(const Vec3& eye) {
  Picture picture{eye, {}, {}, {}, {}};
  for (int i = 0; i < 4000; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 4000, turn = 2.399963 * i;
    const double level = std::sqrt(1 - z * z);
    picture.add(Vec3(level * std::cos(turn), level * std::sin(turn), z), 1 + i % 50);
  }
  return picture;
}

double worst(const FogMedium& fog, const PolarTable& table, const Picture& picture) {
  std::vector<float> out(picture.x.size());
  table.transmittance(picture.rays(), out);
  double most = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Segment segment{picture.eye, Vec3(picture.x[i], picture.y[i], picture.z[i]), 0,
                          picture.distance[i]};
    double depth = 0;
    fog.opticalDepth({&segment, 1}, {&depth, 1});
    const double error = std::abs(out[i] - std::exp(-depth));
    if (!(error <= most))
      most = std::isnan(error) ? 1e9 : error;
  }
  return most;
}

class PolarProfiles : public ::testing::TestWithParam<int> {
 protected:
  /// A smooth map; the walk itself is tested elsewhere.
  FogMedium make(int degree) const {
    SplineGrid map(40, 34);
    for (int j = 0; j < 34; ++j)
      for (int i = 0; i < 40; ++i)
        map.at(i, j) = std::pow(std::sin(0.31 * i + 0.1 * j) * std::sin(0.23 * j - 0.05 * i), 2);
    return fogtest::fog(map, fogtest::profiles()[GetParam()].profile, {.degree = degree});
  }
};

INSTANTIATE_TEST_SUITE_P(Every, PolarProfiles, ::testing::Values(0, 1, 3),
                         [](const auto& info) { return fogtest::profiles()[info.param].name; });

TEST_P(PolarProfiles, AgreeWithTheReference) {
  for (int degree = 0; degree <= 3; ++degree) {
    const FogMedium fog = make(degree);
    for (const Vec3& eye : {Vec3(10, 15, 2.5), Vec3(-60, 20, 4), Vec3(30, 30, 12)}) {
      const Picture front = pinhole(eye, eye.x() < 0 ? 0.05 : 0.8);
      const auto sector = PolarSector::of(front.rays());
      ASSERT_TRUE(sector);
      const double bound = degree == 0 ? 6e-2 : 1.0 / 512;  // degree 0 jumps between azimuths
      EXPECT_LT(worst(fog, *PolarTable::make(fog, eye, {.sector = sector}), front), bound);
      EXPECT_LT(worst(fog, *PolarTable::make(fog, eye), sphere(eye)), bound) << degree;
    }
  }
}

/// Of the picture's rays.
double walkedShare(const PolarTable& table, const Picture& picture) {
  std::vector<float> out(picture.x.size());
  table.lookUp(picture.rays(), out);
  return static_cast<double>(std::ranges::count_if(out, [](float t) { return t < 0; })) /
         static_cast<double>(out.size());
}

TEST_P(PolarProfiles, RaysThatTooFewAzimuthsWouldMissAreWalked) {
  const FogMedium fog = make(2);
  const Vec3 eye(10, 15, 2.5);
  const Picture picture = pinhole(eye, 0.8);
  double walked = 1;
  for (const int azimuths : {33, 129, 513}) {
    const PolarTable table = *PolarTable::make(
        fog, eye, {.azimuths = azimuths, .radii = 600, .sector = PolarSector::of(picture.rays())});
    EXPECT_LT(worst(fog, table, picture), kPolarError);
    EXPECT_LE(walkedShare(table, picture), walked);
    walked = walkedShare(table, picture);
  }
  EXPECT_LT(walked, 0.05);
}

TEST(PolarTable, HomogeneousFogIsExact) {
  SplineGrid ones(30, 30);
  std::ranges::fill(ones.c, 1.0);
  const FogMedium fog =
      *FogMedium::make(*FogMap::fromCoefficients(ones, {.cell = 2}), *FogProfile::slab(0, 5), {});
  Picture picture{Vec3(30, 30, 2), {}, {}, {}, {}};
  for (double turn = 0; turn < 6.28; turn += 0.05)
    for (double z : {-0.3, -0.05, 0.0, 0.2, 0.9})
      picture.add(Vec3(std::cos(turn), std::sin(turn), z).normalized(), 15);
  EXPECT_LT(worst(fog, *PolarTable::make(fog, picture.eye), picture), 1e-5);
}

/// Blobs and streaks in 256 levels, as a person paints them, or noise in every pixel.
FogMedium largeFog(int side, bool noise) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  SplineGrid map(side, side);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double x = 64.0 * i / side, y = 64.0 * j / side;
      const double streaks =
          0.55 + 0.45 * std::sin(1.9 * x + 0.7 * y) * std::sin(0.9 * x - 1.3 * y);
      const double blobs =
          std::exp(-std::pow(x - 32, 2) / 300) + std::exp(-std::pow(y - 50, 2) / 90);
      map.at(i, j) = noise ? uniform(random) : std::round(127 * streaks * blobs) / 255;
    }
  }
  for (double& value : map.c) value = value < 0.16 ? 0 : 0.06 * value;
  return *FogMedium::make(*FogMap::fromCoefficients(map, {.cell = 65.0 / (side + 1)}),
                          *FogProfile::slab(-50, 50), {});
}

TEST(PolarTable, LargeMapsAreWithinTheStatedError) {
  const Picture picture = pinhole(Vec3(6.3, 7.7, 4.6), 0.74, 50);
  const auto sector = PolarSector::of(picture.rays());
  for (const auto& [side, noise, walked] :
       {std::tuple(160, false, 0.05), std::tuple(512, false, 0.2), std::tuple(512, true, 1.0)}) {
    const FogMedium fog = largeFog(side, noise);
    const PolarTable table = *PolarTable::make(fog, picture.eye, {.sector = sector});
    EXPECT_LT(worst(fog, table, picture), kPolarError) << side;
    EXPECT_LE(walkedShare(table, picture), walked) << side;
  }
}

/// Of a picture of the map by a lens as long as the distance asks for.
Picture towardsMap(const Vec3& eye, int side) {
  const Vec3 middle(32, 32, 0), ahead = (middle - eye).normalized();
  const Vec3 right = ahead.cross(Vec3::UnitZ()).normalized(), up = right.cross(ahead);
  const double half = 40 / (middle - eye).norm();
  Picture picture{eye, {}, {}, {}, {}};
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double a = half * (2 * (i + 0.5) / side - 1), b = half * (2 * (j + 0.5) / side - 1);
      picture.add((ahead + a * right + 0.5 * b * up).normalized(),
                  i % 3 == 0 ? (middle - eye).norm() : INFINITY);
    }
  }
  return picture;
}

/// Lines with sharp edges, along the axes and across.
FogMedium sharpFog(int degree) {
  SplineGrid map(128, 128);
  for (int j = 0; j < 128; ++j) {
    for (int i = 0; i < 128; ++i)
      map.at(i, j) = (i > 40 && i < 44) || (j > 90 && j < 92) || std::abs(i - j) < 2 ? 0.1 : 0;
  }
  return *FogMedium::make(*FogMap::fromCoefficients(map, {.cell = 0.5}), *FogProfile::slab(0, 10),
                          {.degree = degree});
}

TEST(PolarTable, FromAnyDistanceNoRayIsFurtherOffThanStated) {
  for (const double away : {40.0, 100.0, 200.0, 1000.0, 3000.0, 30000.0}) {
    for (const Vec3& side : {Vec3(0, -1, 0.03), Vec3(-0.7, -0.7, 0.4), Vec3(1, 0.02, 0.2)}) {
      const Vec3 eye = Vec3(32, 32, 0) + away * side;
      const Picture picture = towardsMap(eye, 48);
      const auto sector = PolarSector::of(picture.rays());
      for (const FogMedium& fog :
           {largeFog(160, false), sharpFog(1), sharpFog(2), sharpFog(3), largeFog(160, true)}) {
        const PolarTable table = *PolarTable::make(fog, eye, {.sector = sector});
        EXPECT_LT(worst(fog, table, picture), kPolarError) << away << " " << side.y();
      }
    }
  }
}

TEST(PolarTable, SectorOfRaysAllAroundIsNone) {
  EXPECT_FALSE(PolarSector::of(sphere(Vec3(0, 0, 1)).rays()));
  const auto sector = PolarSector::of(pinhole(Vec3(0, 0, 1), 2).rays());
  ASSERT_TRUE(sector);
  EXPECT_NEAR(sector->yaw, 2, 1e-3);
  EXPECT_NEAR(sector->tangent, 0.7, 0.02);
}

TEST(PolarFog, LooksUpFromItsEyeAndWalksFromElsewhere) {
  SplineGrid map(40, 34);
  for (int j = 0; j < 34; ++j)
    for (int i = 0; i < 40; ++i) map.at(i, j) = 0.5 + 0.5 * std::sin(0.3 * i) * std::cos(0.2 * j);
  const FogMedium fog =
      fogtest::fog(map, *FogProfile::slab(0, 6), {.degree = 1, .color = Rgb(0.5, 0.6, 0.7)});
  const Vec3 eye(10, 15, 2.5);
  const PolarFog polar = *PolarFog::make(fog, eye);
  std::vector<Segment> here, elsewhere;
  for (int i = 0; i < 40; ++i) {
    const Vec3 direction = Vec3(std::cos(0.16 * i), std::sin(0.16 * i), -0.05).normalized();
    here.push_back({eye, direction, 0, 20});
    elsewhere.push_back({eye + Vec3(1, 0, 0), direction, 0, 20});
  }
  std::vector<Radiance> looked(40), walked(40);
  polar.radiance(here, looked);
  fog.radiance(here, walked);
  double most = 0;
  for (int i = 0; i < 40; ++i) {
    most = std::max(most, std::abs(looked[i].transmittance - walked[i].transmittance));
    EXPECT_NEAR(looked[i].emitted[1], 0.6 * (1 - looked[i].transmittance), 1e-12);
  }
  EXPECT_LT(most, 1.0 / 512);
  EXPECT_GT(most, 0);
  polar.radiance(elsewhere, looked);
  fog.radiance(elsewhere, walked);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(looked[i].transmittance, walked[i].transmittance);
}

TEST(PolarTable, WhatItCannotServeIsSaid) {
  const SplineGrid map = fogtest::map(9, 9);
  const auto code = [&](const FogMedium& fog, PolarOptions options = {}) {
    const auto table = PolarTable::make(fog, Vec3(0, 0, 1), options);
    EXPECT_FALSE(table);
    return table.error().code;
  };
  EXPECT_EQ(code(fogtest::fog(map, *FogProfile::exponential(0, 3), {})), ErrorCode::kUnsupported);
  EXPECT_EQ(code(fogtest::fog(map, {}, {.levels = 2, .detail = {.mu = 0.5}})),
            ErrorCode::kUnsupported);
  EXPECT_EQ(code(fogtest::fog(map, {}, {}), {.azimuths = 1}), ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace volute
