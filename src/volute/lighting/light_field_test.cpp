// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "volute/base/parallel.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

const Box3 kLit{Vec3(0, 0, 0), Vec3(9, 8, 6)};

/// Smoke that rises in a box.
AnyMedium risingSmoke(double strength, const Vec3& corner = Vec3(2, 3, 1), double size = 4) {
  const auto mesh = boxMesh({corner, corner + Vec3::Constant(size)}, {12, 10, 12}, 0.2, 4);
  const Vec3 middle = corner + Vec3::Constant(0.5 * size);
  std::vector<float> extinction;
  for (const Vec3& p : mesh->vertices()) {
    const double across =
        std::hypot(p.x() - middle.x() - 0.2 * (p.z() - middle.z()), p.y() - middle.y()) * 4 / size;
    extinction.push_back(static_cast<float>(strength * std::exp(-2 * across * across)));
  }
  return AnyMedium(TetMedium(std::make_shared<TetLocator>(mesh), std::move(extinction)));
}

Lamp fieldSun(const Vec3& direction) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = direction.normalized();
  return lamp;
}

Lamp fieldLampAt(const Vec3& place) {
  Lamp lamp;
  lamp.position = place;
  return lamp;
}

std::vector<Lamp> fieldLamps() {
  return {fieldSun(Vec3(0.4, -0.2, -1)), fieldSun(Vec3(0, 0, -1)), fieldSun(Vec3(1, 0, 0)),
          fieldLampAt(Vec3(3.1, 4.2, 2.3)), fieldLampAt(Vec3(-1, 2, 7))};
}

std::vector<Vec3> litPoints(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> out;
  for (int i = 0; i < count; ++i)
    out.emplace_back(9 * uniform(random), 8 * uniform(random), 6 * uniform(random));
  return out;
}

/// The largest and the mean difference from the exact share.
std::pair<double, double> errorsOf(const LightField& field, const std::vector<Vec3>& where) {
  double most = 0, sum = 0;
  for (const Vec3& point : where) {
    const double error = std::abs(field.at(point).share - field.exactly(point));
    most = std::max(most, error), sum += error;
  }
  return {most, sum / static_cast<double>(where.size())};
}

TEST(LightField, IsTheTransmittanceOfTheWayToTheLight) {
  for (const double strength : {0.3, 3.0}) {
    for (const Lamp& lamp : fieldLamps()) {
      const LightField field(lamp, {risingSmoke(strength)}, kLit, {.finest = 0.05});
      const auto [most, mean] = errorsOf(field, litPoints(300));
      const bool jumps = lamp.direction == Vec3(1, 0, 0);  // along sides of the mesh
      EXPECT_LT(most, jumps ? 1.0 : 2e-2) << strength << ", " << lamp.direction;
      EXPECT_LT(mean, jumps ? 3e-3 : 1e-3) << strength << ", " << lamp.direction;
    }
  }
}

TEST(LightField, SeveralMediaTakeTheirShares) {
  const LightField field(fieldSun(Vec3(0.1, 0.3, -1)),
                         {risingSmoke(1), risingSmoke(0.5, Vec3(4, 3, 2))}, kLit);
  const auto [most, mean] = errorsOf(field, litPoints(1000));
  EXPECT_LT(most, 2e-2);
  EXPECT_LT(mean, 1e-3);
}

TEST(LightField, WithoutMediaAllLightArrives) {
  const LightField field(fieldSun(Vec3(0, 0, -1)), {}, kLit);
  EXPECT_EQ(field.at(Vec3(1, 2, 3)).share, 1);
  EXPECT_EQ(field.memoryBytes(), 0u);
}

/// A puff of 40 cm in what is lit of 9 m, between the first bricks' rays.
TEST(LightField, SmallMediaAreNotMissed) {
  const AnyMedium puff = risingSmoke(9, Vec3(4.1, 4.05, 3.07), 0.4);
  for (const Lamp& lamp : {fieldSun(Vec3(0.1, 0.2, -1)), fieldLampAt(Vec3(4, 4, 5.5))}) {
    const LightField field(lamp, {puff}, kLit);
    const Segment way = lamp.towards(Vec3(4.3, 4.25, 3.27));
    const Vec3 behind = Vec3(4.3, 4.25, 3.27) - way.direction;
    EXPECT_LT(field.exactly(behind), 0.9);
    EXPECT_NEAR(field.at(behind).share, field.exactly(behind), 2e-2);
  }
}

/// Smoke of 10 km, and cells that are allowed to be as large as a house.
TEST(LightField, ACandleInAWideValleyIsDimmedWithinMetres) {
  const auto mesh = boxMesh({Vec3(-5000, -5000, 0), Vec3(5000, 5000, 500)}, {4, 4, 2}, 0, 1);
  const AnyMedium smoke(TetMedium(std::make_shared<TetLocator>(mesh),
                                  std::vector<float>(mesh->vertices().size(), 0.05F)));
  const LightField field(fieldLampAt(Vec3(0, 0, 1.2)), {smoke}, smoke.bounds(),
                         {.tolerance = 4e-3, .finest = 300});
  for (const double distance : {1.0, 3.0, 10.0, 17.0, 30.0, 60.0, 200.0}) {
    const Vec3 point = Vec3(0, 0, 1.2) + distance * Vec3(0.6, 0.7, 0.3).normalized();
    EXPECT_NEAR(field.at(point).share, std::exp(-0.05 * distance), 1e-2) << distance;
  }
}

TEST(LightField, IsTheSameForAnyOrderOfPointsAndThreads) {
  for (const Lamp& lamp : fieldLamps()) {
    const LightField one(lamp, {risingSmoke(2)}, kLit), other(lamp, {risingSmoke(2)}, kLit);
    const auto where = litPoints(2000);
    std::vector<double> shares(where.size());
    for (std::size_t i = 0; i < where.size(); ++i) shares[i] = one.at(where[i]).share;
    parallelRanges(where.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = end; i-- > begin;) {
        const std::size_t k = where.size() - 1 - i;
        EXPECT_EQ(other.at(where[k]).share, shares[k]);
      }
    });
  }
}

/// Ten kilometres and a candle, and extinctions that jump by 1e6.
TEST(LightField, StaysSmallWhereThereIsLittleToKnow) {
  const Box3 wide{Vec3::Zero(), Vec3(1e4, 1e4, 100)};
  const LightField candle(fieldLampAt(Vec3(5000, 5000, 1)), {risingSmoke(1e-7, Vec3::Zero(), 100)},
                          wide);
  const LightField dark(fieldSun(Vec3(0.1, 0.3, -1)), {risingSmoke(1e6)}, kLit, {.finest = 0.05});
  for (const Vec3& point : litPoints(500)) {
    EXPECT_NEAR(candle.at(1000 * point).share, 1, 1e-4);
    const double share = dark.at(point).share;
    EXPECT_TRUE(share >= 0 && share <= 1);
  }
  EXPECT_LT(candle.memoryBytes(), 4u << 20);
  EXPECT_LT(dark.memoryBytes(), 64u << 20);
}

}  // namespace
}  // namespace volute
