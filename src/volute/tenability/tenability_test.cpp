// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "volute/tenability/criterion.hpp"
#include "volute/tenability/walking_speed.hpp"

namespace volute {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Air with one quantity changed.
Exposure with(Air quantity, double value) {
  Exposure air;
  air[quantity] = value;
  return air;
}

/// Seconds until a constant exposure is a whole dose.
double secondsToOne(DoseLaw law, const Exposure& air, const DosePerson& person = {}) {
  return 1 / doseRate(law, person, air);
}

// pyFDS-Evac's worked example: "0.10 % CO, 2.0 % CO2 and 15.0 % O2 ... reaches FED = 1 at 981.7 s".
TEST(Dose, TheWorkedExampleOfPyFdsEvac) {
  Exposure air;
  air[Air::kCarbonMonoxide] = 0.001;
  air[Air::kCarbonDioxide] = 0.02;
  air[Air::kOxygen] = 0.15;
  EXPECT_NEAR(secondsToOne(DoseLaw::kFdsGas, air), 981.7, 0.05);
}

TEST(Dose, GasesOneByOneInClosedForm) {
  const double third = 1.0 / 60;
  EXPECT_NEAR(doseRate(DoseLaw::kIsoGas, {}, with(Air::kCarbonMonoxide, 0.0035)), 0.1 * third,
              1e-12);
  EXPECT_NEAR(doseRate(DoseLaw::kIsoGas, {}, with(Air::kHydrogenCyanide, 1e-4)),
              std::pow(100, 2.36) / 1.2e6 * third, 1e-12);
  Exposure breathing = with(Air::kCarbonMonoxide, 0.0035);
  breathing[Air::kCarbonDioxide] = 0.05;
  EXPECT_NEAR(doseRate(DoseLaw::kIsoGas, {}, breathing), 0.1 * std::exp(1) * third, 1e-12);
  // 63.18 at light work is 2.764e-5 CO^1.036 per minute.
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeGas, {}, with(Air::kCarbonMonoxide, 0.001)),
              3.317e-5 * 25 / 30 * std::pow(1000, 1.036) * third, 1e-12);
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeGas, {.activity = Activity::kHeavy},
                       with(Air::kCarbonMonoxide, 0.001)),
              0.106 * third, 0.001 * third);
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeGas, {}, with(Air::kOxygen, 0.10)),
              std::exp(0.54 * 10.9 - 8.13) * third, 1e-12);
  EXPECT_EQ(doseRate(DoseLaw::kSfpeGas, {}, with(Air::kOxygen, 0.205)), 0);
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeGas, {}, with(Air::kNitricOxide, 15e-6)), 0.01 * third, 1e-12);
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeGas, {}, with(Air::kAcrolein, 45e-6)), 0.01 * third, 1e-12);
  EXPECT_NEAR(doseRate(DoseLaw::kFdsGas, {}, with(Air::kHydrogenCyanide, 86e-6)),
              (std::exp(2) - 1) / 220 * third, 1e-12);
  EXPECT_EQ(doseRate(DoseLaw::kFdsGas, {}, Exposure()), 0);
  // Smokeview's counts low oxygen at all times.
  EXPECT_NEAR(doseRate(DoseLaw::kSmokeviewGas, {}, Exposure()), std::exp(0.54 * 0.9 - 8.13) * third,
              1e-12);
}

/// SMV Verification Guide, "fed_test": 1000 ppm of CO, 2 % of CO2, 7 % of O2; what its four
/// pictures are marked with, to the last digit.
TEST(Dose, smokeviewsFiguresOfItsVerificationGuide) {
  Exposure air;
  air[Air::kCarbonMonoxide] = 1e-3;
  air[Air::kCarbonDioxide] = 0.02;
  air[Air::kOxygen] = 0.07;
  const double rate = doseRate(DoseLaw::kSmokeviewGas, {}, air);
  EXPECT_NEAR(30 * rate, 0.29, 0.01);
  EXPECT_NEAR(60 * rate, 0.59, 0.01);
  EXPECT_NEAR(120 * rate, 1.2, 0.05);
  EXPECT_NEAR(360 * rate, 3.5, 0.05);
}

TEST(Dose, HeatInClosedForm) {
  // 100 degrees C: 24.7 min clothed, 7.924 min unclothed.
  const Exposure hot = with(Air::kTemperature, 100);
  EXPECT_NEAR(secondsToOne(DoseLaw::kIsoHeat, hot, {.clothing = Clothing::kClothed}) / 60, 24.7,
              0.05);
  EXPECT_NEAR(secondsToOne(DoseLaw::kIsoHeat, hot) / 60, 7.924, 0.001);
  EXPECT_NEAR(secondsToOne(DoseLaw::kSfpeHeat, hot) / 60, 7.924, 0.001);
  Exposure fire = with(Air::kRadiantFlux, 10);
  fire[Air::kTemperature] = 0;
  EXPECT_NEAR(secondsToOne(DoseLaw::kIsoHeat, fire), 60 * 4.2 * std::pow(10, -1.9), 1e-9);
  EXPECT_NEAR(secondsToOne(DoseLaw::kIsoHeat, fire, {.burns = BurnEndpoint::kSecondDegree}),
              60 * 6.9 * std::pow(10, -1.56), 1e-9);
  EXPECT_NEAR(secondsToOne(DoseLaw::kSfpeHeat, fire), 60 * 1.33 * std::pow(10, -1.33), 1e-9);
  fire[Air::kRadiantFlux] = 2.5;
  EXPECT_EQ(doseRate(DoseLaw::kIsoHeat, {}, fire), 0);
  EXPECT_EQ(doseRate(DoseLaw::kIsoHeat, {}, with(Air::kTemperature, -10)), 0);
}

TEST(Dose, IrritantsAreFractionsOfConcentrations) {
  Exposure air = with(Air::kHydrogenChloride, 100e-6);
  air[Air::kAcrolein] = 3e-6;
  EXPECT_NEAR(doseRate(DoseLaw::kIsoIrritants, {}, air), 0.2, 1e-12);
  EXPECT_NEAR(doseRate(DoseLaw::kSfpeIrritants, {}, air), 1.25, 1e-12);
  EXPECT_TRUE(isInstantaneous(DoseLaw::kIsoIrritants));
}

TEST(Dose, WhatIsNotKnownIsSaidOrCountsAsClean) {
  Exposure air = with(Air::kCarbonMonoxide, 0.0035);
  for (const Air gas :
       {Air::kHydrogenCyanide, Air::kCarbonDioxide, Air::kOxygen, Air::kNitricOxide})
    air[gas] = kUnknown;
  EXPECT_NEAR(doseRate(DoseLaw::kIsoGas, {}, air), 0.1 / 60, 1e-12);
  air[Air::kCarbonMonoxide] = kUnknown;
  for (const DoseLaw law :
       {DoseLaw::kIsoGas, DoseLaw::kSfpeGas, DoseLaw::kFdsGas, DoseLaw::kSmokeviewGas})
    EXPECT_TRUE(std::isnan(doseRate(law, {}, air)));
  Exposure nothing;
  for (const AirQuantity& one : airQuantities()) nothing[one.quantity] = kUnknown;
  EXPECT_TRUE(std::isnan(doseRate(DoseLaw::kIsoIrritants, {}, nothing)));
  EXPECT_TRUE(std::isnan(doseRate(DoseLaw::kIsoHeat, {}, nothing)));
  // Interpolated values may lie a little below 0.
  EXPECT_EQ(doseRate(DoseLaw::kIsoGas, {}, with(Air::kCarbonMonoxide, -1e-9)), 0);
}

TEST(Criterion, SaysWhatItNeeds) {
  for (const Criterion& one : usualCriteria()) {
    EXPECT_FALSE(one.source.empty());
    EXPECT_FALSE(one.words().empty());
    EXPECT_GT(one.limit, 0);
    EXPECT_FALSE(one.assessable([](Air) { return false; }));
    EXPECT_TRUE(one.assessable([](Air) { return true; }));
  }
  const Criterion& fec = usualCriteria().back();
  EXPECT_TRUE(fec.assessable([](Air air) { return air == Air::kAcrolein; }));
  EXPECT_EQ(airQuantity("oxygen").value(), Air::kOxygen);
  EXPECT_NE(airQuantity("oxigen").error().message.find("'oxygen'"), std::string::npos);
}

TEST(WalkingSpeed, FallsWithSmoke) {
  const SpeedLaw fridolf = speedLaw("fridolf").value();
  const SpeedLaw frantzich = speedLaw("frantzich-nilsson").value();
  EXPECT_EQ(walkingSpeed(SpeedLaw(), 1.2, 5), 1.2);
  EXPECT_EQ(walkingSpeed(fridolf, 1.2, 0.9), 1.2);
  EXPECT_NEAR(walkingSpeed(fridolf, 1.2, 2), 1.2 - 0.34 * 1.5, 1e-12);
  EXPECT_EQ(walkingSpeed(fridolf, 1.2, 100), 0.2);
  EXPECT_NEAR(walkingSpeed(frantzich, 1.2, 0.706), 1.2 * 0.943, 1e-12);
  EXPECT_NEAR(walkingSpeed(frantzich, 1.2, 100), 0.12, 1e-12);
  EXPECT_EQ(walkingSpeed(fridolf, 1.2, kUnknown), 1.2);
  const SpeedLaw own = speedLaw("fridolf:0.2,4,0.3").value();
  EXPECT_TRUE(isOwn(own) && !isOwn(fridolf));
  EXPECT_NEAR(walkingSpeed(own, 1.2, 1.5), 1.2 - 0.2 * 2, 1e-12);
  EXPECT_NEAR(walkingSpeed(own, 1.2, 100), 1.2 - 0.2 * 3.97, 1e-12);
  EXPECT_NEAR(walkingSpeed(speedLaw("frantzich-nilsson:0.7,-0.1,0.05").value(), 1, 3.5), 0.5,
              1e-12);
  for (const char* wrong : {"fridolf:", "fridolf:1,2", "fridolf:1,2,3,4", "fridolf:a,3,0.2",
                            "fridolf:0.34,0,0.2", "none:1,2,3", "frantzich-nilsson:0.7,0.1,0.1"})
    EXPECT_FALSE(speedLaw(wrong)) << wrong;
}

}  // namespace
}  // namespace volute
