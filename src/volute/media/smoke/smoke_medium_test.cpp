// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_medium.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/io/testing.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/smoke/smoke_parameters.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

/// Two steps of smoke in a room, and a lamp.
class SmokeMediumTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 6, 3)}, {4, 4, 3}, 0.1, 1);
    std::vector<float> values;
    for (const Vec3& p : mesh->vertices())
      values.push_back(static_cast<float>(5e-5 * (0.2 + p.z() / 3)));
    ASSERT_TRUE(writeVtu(folder_ / "a.vtu", *mesh, "smoke", values));
    for (float& value : values) value *= 3;
    ASSERT_TRUE(writeVtu(folder_ / "b.vtu", *mesh, "smoke", values));
    const SeriesFile series[] = {{"a.vtu", 0}, {"b.vtu", 2}};
    ASSERT_TRUE(writePvd(folder_ / "case.pvd", series));
    smoke_.file = (folder_ / "case.pvd").string();
    lighting_.memory = std::make_shared<LightMemory>(1 << 20);
    Lamp lamp;
    lamp.position = Vec3(3, 3, 2.9);
    lighting_.lights.lamps = {lamp};
  }

  Result<std::shared_ptr<SmokeMedium>> opened(const SmokeDescription& smoke) {
    return SmokeMedium::open(smoke, std::make_shared<const SmokeLighting>(lighting_), reading_, {});
  }

  static void expectTheSame(SmokeMedium& a, SmokeMedium& b) {
    for (const double time : {0.0, 1.3, 2.0}) {
      Progress quiet;
      const auto left = a.stateAt(time, quiet), right = b.stateAt(time, quiet);
      ASSERT_TRUE(left && right);
      EXPECT_EQ(left->extinction, right->extinction);
      EXPECT_EQ(left->lampShares, right->lampShares);
      EXPECT_EQ(left->source, right->source);
    }
  }

  testing::TempFolder folder_;
  Progress quiet_;
  Reading reading_{quiet_, std::uint64_t{1} << 30};
  SmokeDescription smoke_;
  SmokeLighting lighting_;
};

TEST_F(SmokeMediumTest, OtherWordsReadNothingAgain) {
  auto layer = opened(smoke_);
  ASSERT_TRUE(layer) << layer.error().message;
  ASSERT_TRUE((*layer)->stateAt(1, quiet_));
  EXPECT_EQ((*layer)->done().stepsRead, 2u);
  SmokeDescription thicker = smoke_;
  thicker.model.massExtinction *= 1.5;
  ASSERT_TRUE(SmokeMedium::readsTheSame(smoke_, thicker));
  auto changed =
      (*layer)->with(thicker, std::make_shared<const SmokeLighting>(lighting_), reading_);
  ASSERT_TRUE(changed);
  ASSERT_TRUE((*changed)->stateAt(1, quiet_));
  EXPECT_EQ((*changed)->done().stepsRead, 0u);
  EXPECT_EQ((*changed)->done().lightsComputed, 2u) << "other smoke, other shadows";
  lighting_.memory = nullptr;
  auto anew = opened(thicker);
  ASSERT_TRUE(anew);
  expectTheSame(**changed, **anew);
}

TEST_F(SmokeMediumTest, LightIsFoundAgainWhereNothingChangesItsWay) {
  auto layer = opened(smoke_);
  ASSERT_TRUE(layer && (*layer)->stateAt(1, quiet_));
  SmokeDescription brighter = smoke_;
  brighter.albedo = Rgb::Constant(0.9);
  lighting_.lights.lamps[0].intensity *= 2;
  auto changed =
      (*layer)->with(brighter, std::make_shared<const SmokeLighting>(lighting_), reading_);
  ASSERT_TRUE(changed && (*changed)->stateAt(1, quiet_));
  EXPECT_EQ((*changed)->done().lightsComputed, 0u);
  EXPECT_EQ((*changed)->done().lightsReused, 2u);
  lighting_.memory = nullptr;
  auto anew = opened(brighter);
  ASSERT_TRUE(anew);
  expectTheSame(**changed, **anew);
}

TEST_F(SmokeMediumTest, AnErrorLeavesTheLayerAsItWas) {
  auto layer = opened(smoke_);
  ASSERT_TRUE(layer);
  SmokeDescription endless = smoke_;
  endless.model.massExtinction = 1e300;
  endless.model.scale = 1e300;
  EXPECT_FALSE((*layer)->with(endless, std::make_shared<const SmokeLighting>(lighting_), reading_));
  auto anew = opened(smoke_);
  ASSERT_TRUE(anew);
  expectTheSame(**layer, **anew);
}

TEST_F(SmokeMediumTest, SaysThatSmokeLooksLikeClearAirAndWhichUnitItMayHave) {
  struct Remarks final : Progress {
    void remark(const Remark& remark) override { heard += remark.sentence; }

    std::string heard;
  };

  const auto heard = [this](double unit, double scale = 1) {
    Remarks remarks;
    Reading reading{remarks, std::uint64_t{1} << 30};
    SmokeDescription smoke = smoke_;
    smoke.model.unit = unit;
    smoke.model.scale = scale;
    EXPECT_TRUE(SmokeMedium::open(smoke, std::make_shared<const SmokeLighting>(), reading, {}));
    return remarks.heard;
  };
  EXPECT_EQ(heard(1).find("clear air"), std::string::npos);
  // 6e-5 kg/m3 at most, read as milligrammes: 5.22e-7/m over a diagonal of 9 m.
  const std::string milligrammes = heard(1e-6);
  EXPECT_NE(milligrammes.find("step 0: this looks like clear air"), std::string::npos);
  EXPECT_NE(milligrammes.find("above 4.7e-06"), std::string::npos) << milligrammes;
  EXPECT_NE(milligrammes.find("read as kg/m3 instead of mg/m3 it would be 6e-05"),
            std::string::npos)
      << milligrammes;
  EXPECT_NE(heard(1e-3).find("read as kg/m3 instead of g/m3"), std::string::npos);
  // 7.5e-7 kg/m3, of which 6 % of the light can be missed.
  const std::string little = heard(1e-3, 12.5);
  EXPECT_NE(little.find("this is little for a fire"), std::string::npos) << little;
  EXPECT_NE(little.find("read as kg/m3 instead of g/m3 it would be 0.00075"), std::string::npos)
      << little;
}

TEST_F(SmokeMediumTest, KnowsTheFieldAndWhatAUnitOfItIs) {
  smoke_.model.unit = 1e-3;
  auto layer = opened(smoke_);
  ASSERT_TRUE(layer);
  EXPECT_EQ((*layer)->fieldName(), "smoke");
  EXPECT_DOUBLE_EQ((*layer)->stateAt(0, quiet_)->extinctionOfUnit, 8.7);
  EXPECT_EQ((*layer)
                ->with(smoke_, std::make_shared<const SmokeLighting>(), reading_)
                .value()
                ->fieldName(),
            "smoke");
}

TEST_F(SmokeMediumTest, ItsMeaningIsGuessedByNameAndValue) {
  // 6e-5 in the file.
  const auto guessed = [this](double scale, const char* field) {
    smoke_.model.scale = scale;
    smoke_.field = field;
    auto layer = opened(smoke_);
    nlohmann::ordered_json json{{"quantity", "soot-density"}, {"unit", "kg/m3"}};
    const std::string why = layer ? guessSmoke(json, **layer) : layer.error().message;
    return std::pair(json, why);
  };
  EXPECT_EQ(guessed(1, "smoke").second, "") << "as much as a fire may have";
  const auto [extinction, why] = guessed(1e4, "smoke");
  EXPECT_EQ(extinction["quantity"], "extinction");
  EXPECT_FALSE(extinction.contains("unit"));
  EXPECT_NE(why.find("up to 0.6 kg/m3 of soot, much for a fire"), std::string::npos) << why;
  const auto [grams, whyGrams] = guessed(1e6, "smoke");
  EXPECT_EQ(grams["unit"], "mg/m3") << "60 1/m is no smoke, 60 kg/m3 neither";
  EXPECT_NE(whyGrams.find("in mg/m3, unless you say otherwise"), std::string::npos) << whyGrams;
}

TEST_F(SmokeMediumTest, AnotherFieldIsAnotherReading) {
  SmokeDescription other = smoke_;
  other.field = "T";
  EXPECT_FALSE(SmokeMedium::readsTheSame(smoke_, other));
  other = smoke_;
  other.negatives = Negatives::kClamp;
  EXPECT_FALSE(SmokeMedium::readsTheSame(smoke_, other));
}

}  // namespace
}  // namespace volute
