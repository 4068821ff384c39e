// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/scene_smoke.hpp"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "volute/media/smoke/smoke_words.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

/// Of a mesh, with these members.
Result<SmokeDescription> parsed(Json members) {
  members.update({{"kind", "smoke"}, {"case", "hall.pvd"}});
  return parseSmoke(members, {"scene.json", "/media/0"});
}

struct Contradiction {
  Json members;
  const char* about;
  const char* says;
};

TEST(SceneSmoke, RefusesWordsThatWouldChangeNothing) {
  const Contradiction contradictions[] = {
      {{{"quantity", "soot-density"}, {"soot_yield", 0.1}}, "soot_yield", "soot alone"},
      {{{"quantity", "mass-fraction"}, {"density_field", "rho"}, {"soot_yield", 0.1}},
       "soot_yield",
       "soot alone"},
      {{{"quantity", "extinction"}, {"soot_yield", 0.1}}, "soot_yield", "products-density"},
      {{{"quantity", "extinction"}, {"unit", "g/m3"}}, "unit", "extinction is in 1/m"},
      {{{"quantity", "optical-density-db"}, {"unit", "g/m3"}}, "unit", "dB/m"},
      {{{"quantity", "mass-fraction"}, {"density_field", "rho"}, {"unit", "g/m3"}},
       "unit",
       "kg/kg"},
      {{{"quantity", "visibility"}, {"mass_extinction", 8700}}, "mass_extinction", "of soot"},
      {{{"quantity", "optical-density"}, {"mass_extinction", 7600}}, "mass_extinction", "of soot"},
      {{{"quantity", "soot-density"}, {"smoke_potential", 2}}, "smoke_potential", "soot-density"},
      {{{"quantity", "products-density"}, {"smoke_potential", 2}, {"soot_yield", 0.1}},
       "soot_yield",
       "the smoke potential takes its place"},
      {{{"quantity", "products-density"}, {"material", "chipboard"}, {"mass_extinction", 7600}},
       "mass_extinction",
       "the material takes its place"},
      {{{"quantity", "soot-density"}, {"density_field", "rho"}}, "density_field", "mass-fraction"}};
  for (const Contradiction& wrong : contradictions) {
    const auto found = parsed(wrong.members);
    ASSERT_FALSE(found) << wrong.members;
    EXPECT_EQ(found.error().code, ErrorCode::kInvalidData);
    EXPECT_TRUE(found.error().message.starts_with("scene.json: /media/0/" +
                                                  std::string(wrong.about) + ": "))
        << found.error().message;
    EXPECT_NE(found.error().message.find(wrong.says), std::string::npos) << found.error().message;
  }
}

TEST(SceneSmoke, TakesWordsThatPlayAPart) {
  const Json good[] = {
      {{"quantity", "soot-density"}, {"unit", "mg/m3"}, {"mass_extinction", 7600}},
      {{"quantity", "products-density"},
       {"unit", "g/m3"},
       {"mass_extinction", 7600},
       {"soot_yield", 0.1}},
      {{"quantity", "products-density"}, {"smoke_potential", 2}},
      {{"quantity", "mass-fraction"}, {"density_field", "rho"}, {"mass_extinction", 7600}},
      {{"quantity", "visibility"}, {"C", 8}},
      {{"quantity", "extinction"}, {"scale", 2}, {"mode", "threshold"}, {"C", "jin-emitting"}}};
  for (const Json& members : good) {
    const auto found = parsed(members);
    EXPECT_TRUE(found) << found.error().message;
  }
  EXPECT_TRUE(parsed(good[5])->givesC);
  EXPECT_FALSE(parsed(good[0])->givesC);
}

TEST(SmokeWords, SayWhatPlaysAPart) {
  SmokeModel model;
  model.unit = 1e-3;
  using Words = std::vector<std::string>;
  EXPECT_EQ(wordsOf(model), (Words{"soot-density [g/m3]", "Km = 8700 m2/kg"}));
  model.quantity = SmokeQuantity::kProductsDensity;
  model.sootYield = 0.1;
  model.scale = 2;
  EXPECT_EQ(wordsOf(model),
            (Words{"products-density [g/m3]", "scale 2", "Km = 8700 m2/kg", "ys = 0.1"}));
  model.smokePotential = 4.2;
  EXPECT_EQ(wordsOf(model), (Words{"products-density [g/m3]", "scale 2", "P = 4.2 dB m2/g"}));
  model.scale = 1;
  model.quantity = SmokeQuantity::kExtinction;
  EXPECT_EQ(wordsOf(model), Words{"extinction [1/m]"});
  model.quantity = SmokeQuantity::kVisibility;
  EXPECT_EQ(wordsOf(model), (Words{"visibility [m]", "K = C / S, C = 3"}));
}

TEST(SmokeWords, ConcentrationHasTheUnitOfTheField) {
  SmokeModel model;
  model.unit = 1e-3;
  model.scale = 4;  // of the values, not of what they mean
  EXPECT_EQ(unitOfConcentration(model), "g/m3");
  EXPECT_DOUBLE_EQ(extinctionOfConcentration(model), 8.7);
  model.quantity = SmokeQuantity::kProductsDensity;
  model.sootYield = 0.1;
  EXPECT_DOUBLE_EQ(extinctionOfConcentration(model), 0.87);
  model.quantity = SmokeQuantity::kMassFraction;
  EXPECT_EQ(unitOfConcentration(model), "kg/m3");
  EXPECT_DOUBLE_EQ(extinctionOfConcentration(model), 8700);
  model.quantity = SmokeQuantity::kOpticalDensity;
  EXPECT_EQ(unitOfConcentration(model), "");
  EXPECT_EQ(extinctionOfConcentration(model), 0);
}

TEST(SmokeWords, DimensionsOfAFileAreThoseOfTheQuantity) {
  using Dimensions = std::array<double, 7>;
  constexpr Dimensions kDensity{1, -3}, kPerLength{0, -1}, kLength{0, 1}, kNone{};
  const auto said = [](const Dimensions& stated, SmokeQuantity quantity, double unit = 1) {
    SmokeModel model;
    model.quantity = quantity;
    model.unit = unit;
    const auto remark = compareDimensions(stated, model, "c.foam: field 'soot'");
    return remark ? *remark : "refused: " + remark.error().message;
  };
  EXPECT_EQ(said(kDensity, SmokeQuantity::kSootDensity), "");
  EXPECT_EQ(said(kPerLength, SmokeQuantity::kExtinction), "");
  EXPECT_EQ(said(kLength, SmokeQuantity::kVisibility), "");
  EXPECT_EQ(said(kNone, SmokeQuantity::kMassFraction), "");
  EXPECT_EQ(said(kDensity, SmokeQuantity::kExtinction),
            "refused: c.foam: field 'soot': the file states kg m^-3, and extinction has m^-1; "
            "choose the quantity that the field holds");
  EXPECT_EQ(said(kDensity, SmokeQuantity::kMassFraction).substr(0, 8), "refused:");
  EXPECT_EQ(said(kNone, SmokeQuantity::kSootDensity),
            "c.foam: field 'soot': the file states a number without dimensions; it is read as "
            "soot-density [kg/m3]");
  EXPECT_EQ(said(kDensity, SmokeQuantity::kSootDensity, 1e-3),
            "c.foam: field 'soot': the file states kg m^-3 (SI), and its values are read as g/m3");
}

}  // namespace
}  // namespace volute
