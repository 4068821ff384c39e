// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/fewer_lamps.hpp"

#include <gtest/gtest.h>

#include <random>

namespace volute {
namespace {

const Box3 kHall{Vec3(0, 0, 0), Vec3(40, 40, 6)};

std::vector<Lamp> underTheCeiling(std::size_t count, double coneCosine) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Lamp> lamps(count);
  for (Lamp& lamp : lamps) {
    lamp.position = Vec3(40 * uniform(random), 40 * uniform(random), 8);
    lamp.coneCosine = coneCosine;
    lamp.intensity = Rgb(1 + uniform(random), 1, 1);
  }
  return lamps;
}

Rgb powerOf(std::span<const Lamp> lamps) {
  Rgb sum = Rgb::Zero();
  for (const Lamp& lamp : lamps) sum += (1 - lamp.coneCosine) * lamp.intensity;
  return sum;
}

TEST(FewerLamps, SendThePowerOfAll) {
  for (const double cone : {-1.0, 0.5}) {
    const auto all = underTheCeiling(3000, cone);
    const auto few = fewerLamps(all, 64);
    EXPECT_EQ(few.size(), 64u);
    EXPECT_LT((powerOf(few) / powerOf(all) - 1).abs().maxCoeff(), 1e-9);
    EXPECT_LT(lampsDiffer(few, all, kHall), 0.2);
  }
}

TEST(FewerLamps, MoreOfThemDifferLess) {
  const auto all = underTheCeiling(500, -1);
  double before = 1;
  for (const std::size_t most : {4u, 32u, 256u, 500u}) {
    const double now = lampsDiffer(fewerLamps(all, most), all, kHall);
    EXPECT_LT(now, before);
    before = now;
  }
  EXPECT_EQ(before, 0);
}

TEST(FewerLamps, KeepSunsAndWhatShinesElsewhere) {
  std::vector<Lamp> all(100);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].position = Vec3(0.01 * static_cast<double>(i), 0, 3);
    all[i].coneCosine = 0.8;
    all[i].direction = i % 2 == 0 ? Vec3(0, 1, 0) : Vec3(0, -1, 0);
  }
  all[10].kind = Lamp::Kind::kSun;
  all[11].intensity.setZero();
  const auto few = fewerLamps(all, 2);
  ASSERT_EQ(few.size(), 3u);
  EXPECT_EQ(few[0].kind, Lamp::Kind::kSun);
  EXPECT_NEAR(few[1].direction.dot(few[2].direction), -1, 1e-12);
  EXPECT_NEAR(few[1].coneCosine, 0.8, 1e-9);
}

}  // namespace
}  // namespace volute
