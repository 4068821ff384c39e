// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/sun_sums.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/fog/fog_testing.hpp"

namespace volute {
namespace {

constexpr double kScale = 40;  // [m], of the exponential

/// Larger than kWhole along either axis.
FogMedium largeFog(int degree) {
  SplineGrid map(301, 210);
  for (int j = 0; j < 210; ++j)
    for (int i = 0; i < 301; ++i)
      map.at(i, j) = std::pow(std::sin(0.25 * i + 0.1 * j) * std::sin(0.2 * j), 2);
  return fogtest::fog(map, {}, {.degree = degree}, 0.01).finest();
}

FogMedium roughFog() {
  return fogtest::fog(fogtest::map(301, 210), {}, {.degree = 1}, 0.01).finest();
}

/// The worst difference from the reference's exact way, relative to the largest sum.
double worst(const FogMedium& fog, const Vec3& towards, SunSums::Weight weight, int samples) {
  const Vec3 sun = towards.normalized();
  const SunSums plain(fog, sun, samples, SunSums::Weight::kOne);
  const SunSums sums(fog, sun, samples, weight, 1 / kScale, &plain);
  std::mt19937 random(3);
  const CellRect map = fog.levels().mapCells();
  std::vector<Vec2> places;
  for (int i = 0; i < 300; ++i) {
    const auto upTo = [&](int cells) {
      return static_cast<double>(random() % (cells * samples + 1)) / samples;
    };
    const double x = upTo(map.x1 - map.x0), y = upTo(map.y1 - map.y0);
    places.emplace_back(x, y);
  }
  std::vector<double> found(places.size());
  sums.at(places, found);
  FogProfile profile;
  double factor = 1;
  if (weight == SunSums::Weight::kDecay)
    profile = *FogProfile::exponential(0, kScale);
  if (weight == SunSums::Weight::kWay) {
    const FogProfile::Knot knots[] = {{0, 0}, {1e6, 1}};
    profile = *FogProfile::linear(knots);
    factor = 1e6 / sun.z();
  }
  const FogMedium exact = fog.withProfile(profile);
  const Vec3 corner = fog.domainCorner() + fog.cell() * Vec3(map.x0, map.y0, 0);
  double difference = 0, largest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3 from = corner + fog.cell() * Vec3(places[i].x(), places[i].y(), 0);
    const double sum = factor * fogtest::depthOf(exact, {from, sun, 0, 1e9});
    largest = std::max(largest, sum);
    difference = std::max(difference, std::abs(found[i] - sum));
  }
  return difference / largest;
}

const Vec3 kSuns[] = {Vec3(1, 0.4, 0.1), Vec3(-2, 1, 0.5), Vec3(0.3, -1, 0.2), Vec3(-0.02, 1, 0.05),
                      Vec3(-1, 0.003, 0.1)};

TEST(SunSums, OfLargeMapsAreThoseOfTheWalk) {
  for (const auto weight :
       {SunSums::Weight::kOne, SunSums::Weight::kWay, SunSums::Weight::kDecay}) {
    for (const Vec3& towards : kSuns) {
      EXPECT_LT(worst(largeFog(2), towards, weight, 1), 5e-4) << towards.x() << ", " << towards.y();
      EXPECT_LT(worst(roughFog(), towards, weight, 3), 1e-3) << towards.x() << ", " << towards.y();
    }
  }
}

/// Ways meet nodes of the lines, so that nothing is interpolated.
TEST(SunSums, AlongAxesAndDiagonalsAreExact) {
  for (const Vec3& towards : {Vec3(1, 0, 0.3), Vec3(-1, 0, 0.1), Vec3(0, 1, 0.2), Vec3(0, -1, 0.5),
                              Vec3(1, -1, 0.3), Vec3(0, 0, 1)}) {
    if (towards.z() < 1) {
      EXPECT_LT(worst(roughFog(), towards, SunSums::Weight::kOne, 3), 2e-5);
    }
    EXPECT_LT(worst(roughFog(), towards, SunSums::Weight::kDecay, 3), 2e-5);
  }
}

}  // namespace
}  // namespace volute
