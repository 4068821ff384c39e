// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/optics/black_body.hpp"
#include "volute/optics/extinction.hpp"
#include "volute/optics/smoke_potential.hpp"
#include "volute/optics/visibility.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

/// Half a unit in the last of the digits that a table prints.
void expectPrinted(double value, double printed, double lastDigit) {
  EXPECT_NEAR(value, printed, 0.5001 * lastDigit);
}

TEST(BlackBody, HasTheChromaticityOfThePlanckianLocus) {
  // CIE 1931 x, y of the locus (Wyszecki and Stiles); sRGB holds 2000 K and more.
  struct Row {
    double temperature, x, y;
  };

  for (const Row& row :
       {Row{2000, 0.5267, 0.4133}, {3000, 0.4369, 0.4041}, {6500, 0.3135, 0.3237}}) {
    const auto [r, g, b] = blackBodyColour(row.temperature);
    const double x = 0.4124 * r + 0.3576 * g + 0.1805 * b;
    const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    const double z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
    EXPECT_NEAR(y, 1, 1e-3);
    EXPECT_NEAR(x / (x + y + z), row.x, 1e-3) << row.temperature;
    EXPECT_NEAR(y / (x + y + z), row.y, 1e-3) << row.temperature;
  }
}

TEST(BlackBody, HasTheTabulatedChromaticities) {
  // 1000 and 6500 K: Wyszecki and Stiles, table 1(3.11). 1900 K: Kim et al. 2002, whose cubic is
  // within 3e-4 of such tables.
  struct Row {
    double temperature, x, y;
  };

  const double t = 1900,
               kim = -0.2661239e9 / (t * t * t) - 0.2343589e6 / (t * t) + 877.6956 / t + 0.17991;
  const double kimY =
      -1.1063814 * kim * kim * kim - 1.3481102 * kim * kim + 2.18555832 * kim - 0.20219683;
  for (const Row& row : {Row{1000, 0.6528, 0.3445}, {1900, kim, kimY}, {6500, 0.3135, 0.3237}}) {
    const auto [x, y] = blackBodyChromaticity(row.temperature);
    EXPECT_NEAR(x, row.x, 1e-3) << row.temperature;
    EXPECT_NEAR(y, row.y, 1e-3) << row.temperature;
  }
}

TEST(BlackBody, IsBrighterWhereItIsHotter) {
  EXPECT_DOUBLE_EQ(blackBodyLuminance(1900, 1900), 1);
  // At these temperatures Wien's law at 590 nm, where most of a flame's luminance is.
  const double wien = std::exp(1.438776877e7 / 590 * (1 / 1900.0 - 1 / 2000.0));
  EXPECT_NEAR(blackBodyLuminance(2000, 1900) / wien, 1, 0.05);
}

TEST(BlackBody, FlamesAreRedAndDaylightIsWhite) {
  const auto flame = blackBodyColour(1500);
  EXPECT_GT(flame[0], 2 * flame[1]);
  EXPECT_EQ(flame[2], 0);
  for (const double channel : blackBodyColour(6600)) EXPECT_NEAR(channel, 1, 0.06);
  for (const double temperature : {500.0, 20000.0}) {
    for (const double channel : blackBodyColour(temperature)) EXPECT_TRUE(std::isfinite(channel));
  }
}

struct LawRow {
  double k, d, db, s3, s8, sOd;
};

TEST(Extinction, HasItsSpellings) {
  const LawRow rows[] = {{0.10, 0.0434, 0.434, 30.0, 80.0, 23.03},
                         {0.23, 0.0999, 0.999, 13.04, 34.78, 10.01},
                         {0.30, 0.1303, 1.303, 10.0, 26.67, 7.68},
                         {1.00, 0.4343, 4.343, 3.0, 8.0, 2.30}};
  const auto law = [](const char* name) { return visibilityLaw(name).value(); };
  for (const LawRow& row : rows) {
    expectPrinted(opticalDensity(row.k), row.d, 1e-4);
    expectPrinted(opticalDensityDb(row.k), row.db, 1e-3);
    expectPrinted(visibilityDistance(row.k, law("jin-reflecting")), row.s3, 1e-2);
    expectPrinted(visibilityDistance(row.k, law("jin-emitting")), row.s8, 1e-2);
    expectPrinted(visibilityDistance(row.k, law("reciprocal-od")), row.sOd, 1e-2);
    EXPECT_NEAR(
        (SmokeModel{.quantity = SmokeQuantity::kOpticalDensity}.extinction(opticalDensity(row.k))),
        row.k, 1e-15);
    EXPECT_NEAR((SmokeModel{.quantity = SmokeQuantity::kOpticalDensityDb}.extinction(
                    opticalDensityDb(row.k))),
                row.k, 1e-15);
    EXPECT_NEAR((SmokeModel{.quantity = SmokeQuantity::kVisibility, .c = 8}.extinction(row.s8)),
                row.k, 2e-4);
  }
  EXPECT_TRUE(std::isinf(visibilityDistance(0, law("8"))));
}

TEST(SmokePotential, GivesVisibilityAtOneGramPerCubicMetre) {
  struct Row {
    const char* material;
    double potential, sOd, s3, s8, digitOd, digit3, digit8;
  };

  const Row rows[] = {{"Rigid PU foam", 4.2, 2.38, 3.10, 8.27, .01, .01, .01},
                      {"Extruded ABS", 3.3, 3.03, 3.95, 10.53, .01, .01, .01},
                      {"Chipboard", 0.37, 27.03, 35.21, 93.90, .01, .01, .01},
                      {"Plasterboard", 0.042, 238.1, 310.2, 827.2, .1, .1, .1}};
  for (const Row& row : rows) {
    const auto potential = smokePotentialOf(row.material);
    ASSERT_TRUE(potential.has_value());
    EXPECT_EQ(potential->value(Burning::kFlaming), row.potential);
    const SmokeModel model{.quantity = SmokeQuantity::kProductsDensity,
                           .unit = densityUnit("g/m3").value(),
                           .smokePotential = potential->flaming};
    ASSERT_TRUE(model.check().has_value());
    const double k = model.extinction(1);
    EXPECT_NEAR(k, 0.2303 * row.potential, 1e-4 * row.potential);
    expectPrinted(visibilityDistance(k, visibilityLaw("reciprocal-od").value()), row.sOd,
                  row.digitOd);
    expectPrinted(visibilityDistance(k, visibilityLaw("jin-reflecting").value()), row.s3,
                  row.digit3);
    expectPrinted(visibilityDistance(k, visibilityLaw("jin-emitting").value()), row.s8, row.digit8);
  }
}

TEST(SmokePotential, CarriesDecibels) {
  EXPECT_NEAR(smokePotential(7600, 1), 33.0, 0.01);
  EXPECT_NEAR(smokePotential(4400, 1), 19.1, 0.01);
  expectPrinted(3.3 / smokePotential(7600, 1), 0.100, 1e-3);   // ABS
  expectPrinted(4.2 / smokePotential(7600, 1), 0.127, 1e-3);   // rigid PU
  expectPrinted(0.17 / smokePotential(7600, 1), 0.005, 1e-3);  // birch plywood
  expectPrinted(4.2 / smokePotential(4400, 1), 0.22, 1e-2);
  EXPECT_NEAR(productsExtinction(smokePotential(7600, 0.1)), 760, 1e-9);
  EXPECT_EQ(smokePotentials().size(), 11u);
  EXPECT_EQ(smokePotentialOf("flexible pu FOAM")->value(Burning::kSmouldering), 5.1);
}

TEST(PictureMode, SeesThroughTenMetres) {
  const double depth = 0.3 * 10;
  const auto seen = [&](PictureMode mode, double c) { return seenTransmittance(depth, mode, c); };
  expectPrinted(seen(PictureMode::kPhotometric, 3), 0.0498, 1e-4);
  expectPrinted(seen(PictureMode::kThreshold, 3), 0.1000, 1e-4);
  expectPrinted(seen(PictureMode::kThreshold, 8), 0.4217, 1e-4);
  // The paper's power of its own transmittance is the sign's; that of the physical one is not.
  EXPECT_NEAR(std::pow(seen(PictureMode::kThreshold, 3), 3.0 / 8), seen(PictureMode::kThreshold, 8),
              1e-15);
  expectPrinted(std::pow(seen(PictureMode::kPhotometric, 3), 3.0 / 8), 0.3247, 1e-4);
  const double ln10 = std::numbers::ln10;
  EXPECT_NEAR(std::pow(photometricTransmittance(depth), ln10 / 3), seen(PictureMode::kThreshold, 3),
              1e-15);
  EXPECT_NEAR(std::pow(photometricTransmittance(depth), ln10 / 8), seen(PictureMode::kThreshold, 8),
              1e-15);
  // What is left at the visibility distance: 10 % of the law's, 5 % of the light.
  EXPECT_NEAR(thresholdTransmittance(3, 3), 0.1, 1e-15);
  expectPrinted(photometricTransmittance(3), 0.050, 1e-3);
}

TEST(Extinction, AgreesWithFdsSmokeTest) {
  const SmokeModel fds;
  const double k = fds.extinction(7.922e-5);
  const double lengths[] = {0.5, 1, 2, 3, 4, 5};
  const int greys[] = {181, 128, 64, 32, 16, 8};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(255 * photometricTransmittance(k * lengths[i]), greys[i], 0.75) << lengths[i];
  EXPECT_NEAR(k, std::log(255.0 / 128), 2e-4);
  EXPECT_NEAR(fds.sootDensity(k), 7.922e-5, 1e-18);
}

TEST(Extinction, AgreesWithFdsBeamDetector) {
  constexpr double kExtinction = 0.3119;
  EXPECT_NEAR(100 * obscuration(kExtinction, 10), 95.58, 0.005);
  const double exact[] = {192.6, 141.0, 103.2, 75.6, 55.3, 40.5, 29.6, 21.7, 15.9};
  for (int i = 0; i < 9; ++i) {
    const double grey = 255 * photometricTransmittance(kExtinction * (0.9 + i));
    EXPECT_NEAR(grey, exact[i], 0.0501) << i;
  }
}

TEST(Extinction, TellsSootFromProducts) {
  const SmokeModel soot{.unit = 1e-3, .massExtinction = 7600};
  SmokeModel products{.quantity = SmokeQuantity::kProductsDensity,
                      .unit = 1e-3,
                      .massExtinction = 7600,
                      .sootYield = 0.1};
  EXPECT_DOUBLE_EQ(products.extinction(10), soot.extinction(1));
  products.smokePotential = smokePotential(7600, 0.1);
  EXPECT_NEAR(products.extinction(10), soot.extinction(1), 1e-12);
  const SmokeModel fraction{.quantity = SmokeQuantity::kMassFraction, .massExtinction = 7600};
  EXPECT_NEAR(fraction.extinction(1e-3 / 1.2, 1.2), soot.extinction(1), 1e-12);
  EXPECT_EQ((SmokeModel{.quantity = SmokeQuantity::kExtinction, .scale = 0.5}.extinction(3)), 1.5);
}

TEST(Extinction, ConvertsFields) {
  const float values[] = {0, 1e-5F, 1e-4F};
  const float densities[] = {1.2F, 1, 0.5F};
  float out[3];
  SmokeModel{.quantity = SmokeQuantity::kMassFraction, .massExtinction = 1e4}.extinction(
      values, densities, out);
  EXPECT_THAT(out, ::testing::ElementsAre(0, ::testing::FloatNear(0.1F, 1e-7F),
                                          ::testing::FloatNear(0.5F, 1e-7F)));
}

TEST(Optics, ExplainsWhatIsWrong) {
  EXPECT_THAT(smokeQuantity("soot").error().message, HasSubstr("soot-density"));
  EXPECT_THAT(densityUnit("g/cm3").error().message, HasSubstr("mg/m3"));
  EXPECT_THAT(smokePotentialOf("oak").error().message, HasSubstr("chipboard"));
  EXPECT_THAT(visibilityLaw("-1").error().message, HasSubstr("jin-emitting"));
  EXPECT_THAT(visibilityLaw("3m").error().message, HasSubstr("number C > 0"));
  EXPECT_THAT(pictureMode("physical").error().message, HasSubstr("photometric"));
  EXPECT_THAT(burning("cold").error().message, HasSubstr("smouldering"));
  EXPECT_THAT((SmokeModel{.quantity = SmokeQuantity::kProductsDensity}.check().error().message),
              HasSubstr("soot yield"));
  EXPECT_THAT((SmokeModel{.massExtinction = -1}.check().error().message), HasSubstr("m2/kg"));
  EXPECT_THAT((SmokeModel{.quantity = SmokeQuantity::kVisibility, .c = 0}.check().error().message),
              HasSubstr("C of the visibility"));
}

TEST(Optics, NamesComeBack) {
  for (const auto quantity :
       {SmokeQuantity::kSootDensity, SmokeQuantity::kVisibility, SmokeQuantity::kOpticalDensityDb})
    EXPECT_EQ(smokeQuantity(nameOf(quantity)).value(), quantity);
  for (const auto mode : {PictureMode::kPhotometric, PictureMode::kThreshold})
    EXPECT_EQ(pictureMode(nameOf(mode)).value(), mode);
  EXPECT_EQ(visibilityLaw("4.5")->c, 4.5);
}

}  // namespace
}  // namespace volute
