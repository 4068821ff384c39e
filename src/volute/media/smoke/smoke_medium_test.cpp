// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_medium.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/io/mesh_case_files.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/media/smoke/smoke_parameters.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/volume_files/memory_volumes.hpp"

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

  /// What the files hold, as a mesh in memory.
  MemoryMesh inMemory() const {
    const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(6, 6, 3)}, {4, 4, 3}, 0.1, 1);
    MemoryMesh made;
    made.cells.vertices.assign(mesh->vertices().begin(), mesh->vertices().end());
    made.cells.shapes.assign(mesh->tets().size(), CellShape::kTet);
    made.cells.offsets = {0};
    for (const Tet& tet : mesh->tets()) {
      made.cells.connectivity.insert(made.cells.connectivity.end(), tet.begin(), tet.end());
      made.cells.offsets.push_back(std::ssize(made.cells.connectivity));
    }
    made.times = {0, 2};
    std::vector<float> values;
    for (const Vec3& p : mesh->vertices())
      values.push_back(static_cast<float>(5e-5 * (0.2 + p.z() / 3)));
    MemoryMesh::Field smoke{"smoke", false, {values, values}};
    for (float& value : smoke.values[1]) value *= 3;
    made.fields = {smoke};
    return made;
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

TEST_F(SmokeMediumTest, AMeshInMemoryIsWhatItsFileWouldBe) {
  auto fromFiles = opened(smoke_);
  ASSERT_TRUE(fromFiles) << fromFiles.error().message;
  MemoryVolumes volumes, others;
  ASSERT_TRUE(others.add("room", inMemory()));
  volumes.add(others);
  reading_.volumes = &volumes;
  smoke_.file = "somewhere/memory:room.vtu";
  lighting_.memory = nullptr;
  auto fromMemory = opened(smoke_);
  ASSERT_TRUE(fromMemory) << fromMemory.error().message;
  expectTheSame(**fromFiles, **fromMemory);
  EXPECT_EQ((*fromMemory)->fieldName(), "smoke");
  const auto described = (*fromMemory)->source().describe(1);
  ASSERT_TRUE(described) << described.error().message;
  EXPECT_EQ(described->contents.shapes[0], inMemory().cells.shapes.size());
  EXPECT_FLOAT_EQ(static_cast<float>(described->fields.at(0).most), 3 * 6e-5F);
}

TEST_F(SmokeMediumTest, AMeshInMemoryHasAirAsItsFileWould) {
  MemoryMesh mesh = inMemory();
  MemoryMesh::Field heat{"Temp", false, mesh.fields[0].values};
  for (std::size_t time = 0; time < 2; ++time) {
    for (std::size_t i = 0; i < mesh.cells.vertices.size(); ++i)
      heat.values[time][i] = static_cast<float>(300 + 40 * time + mesh.cells.vertices[i].x());
  }
  mesh.fields.push_back(heat);
  MemoryVolumes volumes;
  ASSERT_TRUE(volumes.add("room", mesh));
  reading_.volumes = &volumes;
  smoke_.file = "memory:room.vtu", smoke_.field = "smoke";
  auto smoke = opened(smoke_);
  ASSERT_TRUE(smoke) << smoke.error().message;
  const auto sight = (*smoke)->sight(reading_);
  ASSERT_TRUE(sight) << sight.error().message;
  const auto air = (*sight)->conditions("temperature");
  ASSERT_TRUE(air) << air.error().message;
  const Vec3 place(2.5, 3, 1);
  double celsius = 0;
  ASSERT_TRUE((*air)->at(1, {&place, 1}, {&celsius, 1}));
  EXPECT_NEAR(celsius, 322.5 - 273.15, 1e-3);
  // Cells are split once, for all times and fields.
  MeshSource source = (*smoke)->source();
  ASSERT_TRUE(source.read(0));
  auto other = source.withField("Temp", Negatives::kKeep);
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_EQ(other->read(1)->mesh, source.read(1)->mesh);
  const auto probe = (*smoke)->fieldProbe();
  const auto fields = probe->at(0, place);
  ASSERT_TRUE(fields) << fields.error().message;
  ASSERT_EQ(fields->size(), 2U);
  EXPECT_NEAR((*fields)[1].values.at(0), 302.5, 1e-3);
}

/// A layer of hot smoke: visibility, and mass fraction times density, have large steps between
/// cells.
TEST_F(SmokeMediumTest, CellsGoToPointsAsExtinction) {
  MemoryMesh mesh = inMemory();
  MemoryMesh::Field visibility{"visibility", true, {{}, {}}}, extinction{"K", true, {{}, {}}};
  MemoryMesh::Field soot{"soot", true, {{}, {}}}, rho{"rho", true, {{}, {}}};
  MemoryMesh::Field product{"product", true, {{}, {}}};
  for (std::size_t cell = 0; cell < mesh.cells.shapes.size(); ++cell) {
    double z = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto corner = mesh.cells.connectivity[4 * cell + k];
      z += mesh.cells.vertices[static_cast<std::size_t>(corner)].z() / 4;
    }
    const bool hot = z > 2;
    for (const std::size_t time : {0U, 1U}) {
      const float metres = hot ? 1 : 30, gas = hot ? 0.4F : 1.2F, share = hot ? 1e-3F : 0;
      visibility.values[time].push_back(metres);
      extinction.values[time].push_back(3 / metres);
      soot.values[time].push_back(share);
      rho.values[time].push_back(gas);
      product.values[time].push_back(share * gas);
    }
  }
  mesh.fields = {visibility, extinction, soot, rho, product};
  MemoryVolumes volumes;
  ASSERT_TRUE(volumes.add("room", mesh));
  reading_.volumes = &volumes;
  lighting_.lights.lamps.clear();
  smoke_.file = "memory:room.vtu";
  const auto of = [&](SmokeQuantity quantity, const std::string& field, double scale = 1) {
    smoke_.model.quantity = quantity, smoke_.field = field;
    smoke_.model.scale = scale;
    smoke_.densityField = quantity == SmokeQuantity::kMassFraction ? "rho" : "";
    const auto smoke = opened(smoke_);
    EXPECT_TRUE(smoke) << smoke.error().message;
    return (*smoke)->stateAt(1, quiet_)->extinction;
  };
  const auto expectNear = [](const std::vector<float>& found, const std::vector<float>& right) {
    ASSERT_EQ(found.size(), right.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i], right[i], 1e-5F * right[i]);
  };
  const auto right = of(SmokeQuantity::kExtinction, "K");
  expectNear(of(SmokeQuantity::kVisibility, "visibility"), right);
  expectNear(of(SmokeQuantity::kVisibility, "visibility", 0.5),
             of(SmokeQuantity::kExtinction, "K", 2));
  expectNear(of(SmokeQuantity::kMassFraction, "soot"), of(SmokeQuantity::kSootDensity, "product"));
  SmokeDescription other = smoke_;
  other.model.quantity = SmokeQuantity::kVisibility;
  EXPECT_FALSE(SmokeMedium::readsTheSame(smoke_, other)) << "its cells go to points otherwise";
}

TEST_F(SmokeMediumTest, WhatIsNoMeshInMemoryIsRefused) {
  MemoryVolumes volumes;
  const auto wrong = [&](auto&& change) {
    MemoryMesh mesh = inMemory();
    change(mesh);
    const Status added = volumes.add("a", std::move(mesh));
    return added ? "" : added.error().message;
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(wrong([](MemoryMesh& m) { m.fields[0].values[1].pop_back(); }),
              HasSubstr("memory:a: field 'smoke' has 99 values at 2 s, and there are 100 points"));
  EXPECT_THAT(wrong([](MemoryMesh& m) { m.fields[0].values.pop_back(); }), HasSubstr("1 times"));
  EXPECT_THAT(wrong([](MemoryMesh& m) { m.times[1] = 0; }), HasSubstr("ascending"));
  EXPECT_THAT(wrong([](MemoryMesh& m) { m.fields.clear(); }), HasSubstr("at least a time"));
  EXPECT_THAT(wrong([](MemoryMesh& m) { m.fields.push_back(m.fields[0]); }),
              HasSubstr("different names"));
  EXPECT_EQ(wrong([](MemoryMesh& m) { m.cells.connectivity[7] = 100; }), "") << "reading checks it";
  reading_.volumes = &volumes;
  smoke_.file = "memory:a.vtu";
  const auto outside = opened(smoke_);
  ASSERT_FALSE(outside);
  EXPECT_THAT(outside.error().message, HasSubstr("has vertex 100; there are 100 vertices"));
  MemoryMesh two = inMemory();
  two.fields.push_back(two.fields[0]);
  two.fields[1].name = "soot";
  ASSERT_TRUE(volumes.add("a", std::move(two)));
  const auto which = opened(smoke_);
  ASSERT_FALSE(which);
  EXPECT_THAT(which.error().message, HasSubstr("has smoke, soot; expected one field"));
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
    void remark(const Remark& remark) override { sentences += remark.sentence; }

    std::string sentences;
  };

  const auto remarksWith = [this](double unit, double scale = 1) {
    Remarks remarks;
    Reading reading{remarks, std::uint64_t{1} << 30};
    SmokeDescription smoke = smoke_;
    smoke.model.unit = unit;
    smoke.model.scale = scale;
    EXPECT_TRUE(SmokeMedium::open(smoke, std::make_shared<const SmokeLighting>(), reading, {}));
    return remarks.sentences;
  };
  EXPECT_EQ(remarksWith(1).find("clear air"), std::string::npos);
  // 6e-5 kg/m3 at most, read as milligrammes: 5.22e-7/m over a diagonal of 9 m.
  const std::string milligrammes = remarksWith(1e-6);
  EXPECT_NE(milligrammes.find("step 0: this looks like clear air"), std::string::npos);
  EXPECT_NE(milligrammes.find("above 4.7e-06"), std::string::npos) << milligrammes;
  EXPECT_NE(milligrammes.find("read as kg/m3 instead of mg/m3 it would be 6e-05"),
            std::string::npos)
      << milligrammes;
  EXPECT_NE(remarksWith(1e-3).find("read as kg/m3 instead of g/m3"), std::string::npos);
  // 7.5e-7 kg/m3, of which 6 % of the light can be missed.
  const std::string little = remarksWith(1e-3, 12.5);
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

TEST_F(SmokeMediumTest, DimensionsOfOpenFoamCountForAllFields) {
  using ::testing::HasSubstr;
  testing::writeFoam(folder_.path());
  const std::string soot = testing::readBytes(folder_ / "10" / "soot");
  const auto put = [&](const std::string& field, const std::string& dimensions, double value) {
    std::string text = soot;
    const auto replace = [&](std::size_t begin, std::size_t end, const std::string& by) {
      text.replace(begin, end - begin, by);
    };
    replace(text.find("object soot"), text.find(";\n}", text.find("object")), "object " + field);
    replace(text.find("[1 -3"), text.find("]") + 1, "[" + dimensions + "]");
    replace(text.find("nonuniform"), text.find("boundaryField"),
            fmt::format("uniform {};\n", value));
    for (const char* time : {"10", "20"}) testing::writeBytes(folder_ / time / field, text);
  };
  smoke_.file = (folder_ / "box.foam").string(), smoke_.field = "soot";
  // The field, its dimensions, its value, and what is said of it.
  const auto said = [&](const std::string& field, const std::string& dimensions, double value,
                        const std::string& quantity, const std::string& air = "") {
    put(field, dimensions, value);
    smoke_.airFields = air;
    const auto smoke = opened(smoke_);
    EXPECT_TRUE(smoke) << smoke.error().message;
    const auto sight = (*smoke)->sight(reading_);
    EXPECT_TRUE(sight) << sight.error().message;
    const auto points = (*sight)->conditions(quantity);
    if (!points)
      return points.error().message;
    double found = 0;
    const Vec3 place = (*smoke)->info().bounds.centre();
    EXPECT_TRUE((*points)->at(10, std::span(&place, 1), std::span(&found, 1)));
    return fmt::format("{:.4g}", found);
  };
  EXPECT_EQ(said("T", "0 0 0 1 0 0 0", 350, "temperature"), "76.85");
  EXPECT_THAT(said("T", "0 0 1 0 0 0 0", 90, "temperature"),
              HasSubstr("field 'T': the file states s, and temperature has K"));
  EXPECT_THAT(said("T", "0 0 0 1 0 0 0", 20, "temperature"), HasSubstr("and the file states K"));
  EXPECT_EQ(said("T", "0 0 0 1 0 0 0", 20, "temperature", "temperature=T:C"), "20");
  EXPECT_EQ(said("T", "0 0 0 0 0 0 0", 20, "temperature"), "20");
  EXPECT_EQ(said("O2", "0 0 0 0 0 0 0", 0.2, "oxygen").substr(0, 4), "0.18");
  EXPECT_THAT(said("CO", "1 -3 0 0 0 0 0", 0.01, "carbon-monoxide"),
              HasSubstr("the file states kg m^-3, and carbon-monoxide has no dimensions"));
  EXPECT_EQ(said("radiant_flux", "1 0 -3 0 0 0 0", 2500, "radiant-flux"), "2.5");

  smoke_.model.quantity = SmokeQuantity::kMassFraction;
  smoke_.densityField = "rho";
  put("soot", "0 0 0 0 0 0 0", 1e-4);
  put("rho", "1 -3 0 0 0 0 0", 1.2);
  const auto right = opened(smoke_);
  EXPECT_TRUE(right) << right.error().message;
  put("rho", "0 0 0 1 0 0 0", 300);
  const auto wrong = opened(smoke_);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message,
              HasSubstr("field 'rho': the file states K, and the density of the gas has kg m^-3"));
}

}  // namespace
}  // namespace volute
