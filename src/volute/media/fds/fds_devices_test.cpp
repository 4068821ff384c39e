// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_devices.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/media/fds/fds_conditions.hpp"

namespace volute {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Remarks of which one has this text.
auto tells(const std::string& text) {
  return Contains(HasSubstr(text));
}

/// A case of one mesh with devices at x = 1, 2, 3 ... m.
class FdsDevices : public ::testing::Test {
 protected:
  FdsDevices() {
    index_.meshes.push_back({{{{0, 10}, {0, 1}, {0, 1}}}, {}, {}});
    index_.input = "made.fds";
  }

  void device(const std::string& label, const std::string& quantity) {
    index_.device(label, quantity, {1.0 + count_++, 0.5, 0.5});
  }

  SmvIndex read(const std::string& table, const std::string& input = "") {
    fdswriter::saveText(folder_ / "made_devc.csv", table);
    if (!input.empty())
      fdswriter::saveText(folder_ / "made.fds", "&HEAD CHID='made' /\n" + input);
    index_.save(folder_ / "made.smv");
    auto index = SmvIndex::read(folder_ / "made.smv");
    if (!index)
      throw std::runtime_error(index.error().message);
    return std::move(*index);
  }

  static double valueAt(PointField& field, double time, double x) {
    const Vec3 point(x, 0.5, 0.5);
    double value = 0;
    EXPECT_TRUE(field.at(time, {&point, 1}, {&value, 1}));
    return value;
  }

  ScratchFolder folder_;
  fdswriter::Index index_;
  int count_ = 0;
};

TEST_F(FdsDevices, SpeciesAreThoseOfTheInput) {
  device("CO", "VOLUME FRACTION");
  device("CO2", "VOLUME FRACTION");
  device("O2", "OXYGEN VOLUME FRACTION");
  device("R", "RADIATIVE HEAT FLUX");
  const auto index = read(
      "s,ppm,mol/mol,%,W/m2\nTime,\"CO\",\"CO2\",\"O2\",\"R\"\n0,0,0,21,0\n10,1200,0.05,15,2500\n",
      "&DEVC ID='CO', QUANTITY='VOLUME FRACTION', SPEC_ID='CARBON MONOXIDE', XYZ=1,.5,.5 /\n"
      "&DEVC ID='CO2', QUANTITY='VOLUME FRACTION', SPEC_ID='my gas', XYZ=2,.5,.5 /\n"
      "&SPEC ID='my gas', FORMULA='CO2' /\n"
      "&DEVC ID='R', QUANTITY='RADIATIVE HEAT FLUX GAS', XYZ=4,.5,.5 /\n");

  const struct {
    const char* quantity;
    double x, value;
  } expected[] = {{"carbon-monoxide", 1, 0.0012},
                  {"carbon-dioxide", 2, 0.05},
                  {"oxygen", 3, 0.15},
                  {"radiant-flux", 4, 2.5}};

  for (const auto& one : expected) {
    auto field = fdsConditions(index, one.quantity, 1 << 20);
    ASSERT_TRUE(field) << one.quantity << ": " << field.error().message;
    EXPECT_NEAR(valueAt(**field, 10, one.x), one.value, 1e-12) << one.quantity;
    EXPECT_TRUE(std::isnan(valueAt(**field, 10, one.x + 0.5)));
  }
  EXPECT_EQ(fdsConditions(index, "hydrogen-cyanide", 1 << 20).error().code, ErrorCode::kNotFound);
}

TEST_F(FdsDevices, AFractionOfNobodyKnowsWhatIsTold) {
  device("P1 CO", "VOLUME FRACTION");
  const std::string table = "s,mol/mol\nTime,\"P1 CO\"\n0,0\n10,.01\n";
  const std::string text = "1 of 1 devices measure VOLUME FRACTION of a species that ";
  EXPECT_THAT(fdsFacts(read(table)).remarks,
              tells(text + "the input file would say, which is not there: they serve no "
                           "criterion: 'P1 CO'"));
  EXPECT_THAT(fdsFacts(read(table, "&DEVC ID='other', QUANTITY='TIME', XYZ=1,.5,.5 /\n")).remarks,
              tells(text + "made.fds does not name"));
}

TEST_F(FdsDevices, ABadCellIsThatCellAlone) {
  for (const char* label : {"T1", "T2", "T3"}) device(label, "TEMPERATURE");
  const auto index = read(
      "s,C,C,K\nTime,\"T1\",\"T2\",\"T3\"\n0,NaN,20,293.15\n5,30,*****,303.15\n10,50,2.0-101,313."
      "15\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_THAT(field->times(), ElementsAre(0, 5, 10));
  EXPECT_EQ(valueAt(*field, 5, 1), 30);
  EXPECT_TRUE(std::isnan(valueAt(*field, 2, 1))) << "nobody knows before its first number";
  EXPECT_NEAR(valueAt(*field, 5, 2), 10, 1e-12) << "between its numbers";
  EXPECT_NEAR(valueAt(*field, 10, 2), 0, 1e-12);
  EXPECT_NEAR(valueAt(*field, 5, 3), 30, 1e-9);
  EXPECT_THAT(fdsFacts(index).remarks,
              tells("2 cells hold no number and are left out (line 3 is the first): of "
                    "T1, T2"));
}

TEST_F(FdsDevices, WhatNoPlaceCanHaveIsAGap) {
  device("T1", "TEMPERATURE");
  device("T2", "TEMPERATURE");
  device("O2", "OXYGEN VOLUME FRACTION");
  const auto index = read(
      "s,C,K,%\nTime,\"T1\",\"T2\",\"O2\"\n0,-999,293.15,21\n5,30,-1,-1\n10,-60,313.15,-0.1\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_TRUE(std::isnan(valueAt(*field, 2, 1)));
  EXPECT_EQ(valueAt(*field, 10, 1), -60);
  EXPECT_NEAR(valueAt(*field, 5, 2), 30, 1e-9) << "between its numbers";
  auto oxygen = fdsConditions(index, "oxygen", 1 << 20).value();
  EXPECT_NEAR(valueAt(*oxygen, 5, 3), (0.21 - 0.001) / 2, 1e-12);
  EXPECT_THAT(
      fdsFacts(index).remarks,
      tells("values that cannot be are left out: O2 (1 of 3 below -0.1 %), T1 (1 of 3 below "
            "-273.15 C), T2 (1 of 3 below 0 K)"));
}

TEST_F(FdsDevices, LinesThatAreNotWholeAreTold) {
  device("T1", "TEMPERATURE");
  const std::string head = "s,C\nTime,\"T1\"\n";
  const auto values = [&](const std::string& rows) {
    auto field = fdsConditions(read(head + rows), "temperature", 1 << 20);
    return field ? std::vector<double>((*field)->times().begin(), (*field)->times().end())
                 : std::vector<double>();
  };
  EXPECT_THAT(values("0,20\n5,30\n10,9"), ElementsAre(0, 5));
  EXPECT_THAT(fdsFacts(read(head + "0,20\n5,30\n10,9")).remarks,
              tells("its last line has no end and is left out"));
  EXPECT_THAT(values("0,20,\n5,30,5\n10,40\n"), ElementsAre(0, 10));
  EXPECT_THAT(fdsFacts(read(head + "0,20,\n5,30,5\n10,40\n")).remarks,
              tells("1 lines have more cells than there are names (line 4 is the first)"));
  EXPECT_THAT(fdsFacts(read(head)).remarks, tells("made_devc.csv: has no line of values yet"));
}

TEST_F(FdsDevices, LongTablesAreReadWhole) {
  device("T1", "TEMPERATURE");
  constexpr int kRows = 1000000;
  std::string table = "s,C\nTime,\"T1\"\n";
  for (int row = 0; row < kRows; ++row) table += fmt::format("{},20\n", row);
  const auto index = read(table + "1000000,90\n1000010,90\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_EQ(valueAt(*field, 1000005, 1), 90);
  EXPECT_TRUE(fdsFacts(index).remarks.empty());
  const auto all = [](const auto&, const auto&) { return true; };
  const auto cut = readCurves(index, "devc", all, 100).value();
  EXPECT_EQ(cut.curves.front().times.back(), 99);
  EXPECT_THAT(cut.remarks, tells("more than 100 values; those from line 103 on, after 99 s, are "
                                 "left out"));
}

TEST_F(FdsDevices, OneLineOfValuesIsTold) {
  device("T1", "TEMPERATURE");
  device("T2", "TEMPERATURE");
  const std::string text =
      "made_devc.csv: one value alone, and so nothing known at any other time: of ";
  EXPECT_THAT(fdsFacts(read("s,C,C\nTime,\"T1\",\"T2\"\n5,20,30\n")).remarks,
              tells(text + "T1 (at 5 s), T2 (at 5 s)"));
  EXPECT_THAT(fdsFacts(read("s,C,C\nTime,\"T1\",\"T2\"\n5,20,30\n6,20,*\n")).remarks,
              AllOf(tells(text + "T2 (at 5 s)"), tells("1 cell holds no number and is left out")));
}

TEST_F(FdsDevices, NamesAreLatin1OrUtf8) {
  device("T\xFCr", "VOLUME FRACTION");
  const auto index = read("s,mol/mol\nTime,\"T\xFCr\"\n0,0.1\n",
                          "&DEVC ID='Tür', QUANTITY='VOLUME FRACTION', SPEC_ID='OXYGEN' /\n");
  auto field = fdsConditions(index, "oxygen", 1 << 20);
  ASSERT_TRUE(field) << field.error().message;
  EXPECT_EQ(valueAt(**field, 0, 1), 0.1);
}

TEST_F(FdsDevices, ARestartReplacesWhatCameBefore) {
  device("T1", "TEMPERATURE");
  const auto index = read("s,C\nTime,\"T1\"\n0,20\n5,30\n10,40\n5,25\n9,27\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_THAT(field->times(), ElementsAre(0, 5, 9));
  EXPECT_EQ(valueAt(*field, 5, 1), 25);
  EXPECT_THAT(fdsFacts(index).remarks, tells("times go back (line 6, from 10 to 5 s)"));
}

TEST_F(FdsDevices, TheFirstColumnIsTimeInItsUnit) {
  device("T1", "TEMPERATURE");
  device("T2", "TEMPERATURE");
  const auto index = read("min,C\nTime,\"T1\"\n0,20\n1,50\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_THAT(field->times(), ElementsAre(0, 60));
  EXPECT_THAT(field->description(), HasSubstr("T2 (no column of that name)"));
  EXPECT_THAT(fdsFacts(read("C,s\n\"T1\",Time\n20,0\n")).remarks,
              tells("its first column is 'T1'; expected Time"));
  EXPECT_THAT(fdsFacts(read("fortnight,C\nTime,\"T1\"\n20,0\n")).remarks,
              tells("its times are in 'fortnight'; expected s"));
}

TEST_F(FdsDevices, WhatIsNoValueAtAPointIsLeftOutAndNamed) {
  for (const char* label : {"T1", "mean", "scaled", "twice", "odd"}) device(label, "TEMPERATURE");
  const auto index = read(
      "s,C,C,C,C,C,furlong\nTime,\"T1\",\"mean\",\"scaled\",\"twice\",\"twice\",\"odd\"\n0,20,1,2,"
      "3,4,5\n",
      "&DEVC ID='mean', QUANTITY='TEMPERATURE', SPATIAL_STATISTIC='MEAN' /\n"
      "&DEVC ID='scaled', QUANTITY='TEMPERATURE', CONVERSION_FACTOR=2. /\n");
  auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_EQ(valueAt(*field, 0, 1), 20);
  for (const double x : {2, 3, 4, 5}) EXPECT_TRUE(std::isnan(valueAt(*field, 0, x))) << x;
  EXPECT_THAT(field->description(), HasSubstr("mean (MEAN)"));
  EXPECT_THAT(field->description(), HasSubstr("scaled (CONVERSION_FACTOR without UNITS)"));
  EXPECT_THAT(field->description(), HasSubstr("odd (in 'furlong')"));
  EXPECT_THAT(fdsFacts(index).remarks, tells("several columns have one name"));
}

TEST_F(FdsDevices, OfSeveralAtOnePlaceTheWorstCounts) {
  index_.device("west", "RADIATIVE HEAT FLUX", {1, 0.5, 0.5});
  index_.device("east", "RADIATIVE HEAT FLUX", {1, 0.5, 0.5});
  const auto index = read("s,kW/m2,kW/m2\nTime,\"west\",\"east\"\n0,5.59,0.4\n");
  auto field = fdsConditions(index, "radiant-flux", 1 << 20).value();
  EXPECT_EQ(valueAt(*field, 0, 1.1), 5.59);
}

TEST_F(FdsDevices, DecimalCommasAndAByteOrderMarkAreRead) {
  device("T1", "TEMPERATURE");
  device("T2", "TEMPERATURE");
  const auto index = read(
      "\xEF\xBB\xBFs;C;K\n\"Time\";\"T1\";\"T2\"\n 0,0E+00; 20,5;293,15\n10,0;5,05E+01;333,15\n");
  const auto temperature = fdsConditions(index, "temperature", 1 << 30).value();
  EXPECT_NEAR(valueAt(*temperature, 0, 1), 20.5, 1e-9);
  EXPECT_NEAR(valueAt(*temperature, 5, 1), 35.5, 1e-9);
  EXPECT_NEAR(valueAt(*temperature, 10, 2), 60, 1e-9);
}

TEST_F(FdsDevices, AColumnInAnUnknownUnitIsTold) {
  device("T1", "TEMPERATURE");
  device("T2", "TEMPERATURE");
  device("V", "VELOCITY");
  const auto facts =
      fdsFacts(read("s,furlong,C,knot\nTime,\"T1\",\"T2\",\"V\"\n0,20,20,1\n10,50,60,1\n"));
  EXPECT_THAT(facts.remarks, tells("1 of 3 devices are left out, because their column "
                                   "is in no unit of what they measure: 'T1' "
                                   "(TEMPERATURE in 'furlong')"));
}

TEST_F(FdsDevices, AColumnWithoutAUnitIsTakenAsFdsWritesItAndTold) {
  const std::string input =
      "&DEVC ID='CO', QUANTITY='VOLUME FRACTION', SPEC_ID='CARBON MONOXIDE' /\n"
      "&DEVC ID='O', QUANTITY='VOLUME FRACTION', SPEC_ID='OXYGEN' /\n";
  device("CO", "VOLUME FRACTION");
  device("O", "VOLUME FRACTION");
  device("T", "TEMPERATURE");
  const auto index = read("s,,,\nTime,\"CO\",\"O\",\"T\"\n0,0,0.2,20\n10,0.3,0.1,90\n", input);
  EXPECT_EQ(valueAt(*fdsConditions(index, "carbon-monoxide", 1 << 20).value(), 10, 1), 0.3);
  EXPECT_EQ(valueAt(*fdsConditions(index, "temperature", 1 << 20).value(), 10, 3), 90);
  EXPECT_THAT(fdsFacts(index).remarks,
              tells("3 of 3 devices have columns without a unit, which are taken in the unit that "
                    "FDS writes: 'CO' in mol/mol and others"));

  const auto percent = read("s,,,\nTime,\"CO\",\"O\",\"T\"\n0,0,20.9,293\n10,0.3,10,350\n", input);
  EXPECT_THAT(fdsConditions(percent, "carbon-monoxide", 1 << 20).error().message,
              HasSubstr("CO (without a unit, as 'O', which is up to 20.9: in % or ppm?)"));
  EXPECT_THAT(fdsConditions(percent, "temperature", 1 << 20).error().message,
              HasSubstr("T (never below 293 without a unit: in K?)"));
  EXPECT_THAT(fdsFacts(percent).remarks, tells("3 of 3 devices are left out"));
}

TEST_F(FdsDevices, OfTwoTablesOfOneDeviceTheWorseCountsAndItIsTold) {
  device("T", "TEMPERATURE");
  index_.files += "CSVF\n devc\n made_devc.csv\nCSVF\n devc\n made_2_devc.csv\n";
  fdswriter::saveText(folder_ / "made_2_devc.csv", "s,C\nTime,\"T\"\n5,60\n15,60\n");
  const auto index = read("s,C\nTime,\"T\"\n0,20\n10,20\n");
  const auto field = fdsConditions(index, "temperature", 1 << 20).value();
  EXPECT_EQ(valueAt(*field, 2, 1), 20);
  EXPECT_EQ(valueAt(*field, 7, 1), 60);
  EXPECT_EQ(valueAt(*field, 15, 1), 60);
  EXPECT_THAT(fdsFacts(index).remarks,
              tells("made_2_devc.csv: an earlier table has values at the same times, of which the "
                    "worse count: of T"));
  fdswriter::saveText(folder_ / "made_2_devc.csv", "s,C\nTime,\"T\"\n10,60\n15,60\n");
  EXPECT_TRUE(fdsFacts(index).remarks.empty()) << "one after the other, as after a restart";
}

TEST_F(FdsDevices, SlicesAreReadInTheirUnit) {
  const struct {
    const char* unit;
    double stored, value;
  } right[] = {{"C", 80, 80}, {"K", 353.15, 80}, {"F", 176, 80}};

  fdswriter::Slice slice{{0, 1, 0, 1, 0, 1}, "TEMPERATURE", "temp", "C"};
  const auto conditions = [&](double value, const char* quantity) {
    fdswriter::sliceFile(slice, {{0, std::vector<float>(8, static_cast<float>(value))}})
        .save(folder_ / "t.sf");
    index_.files.clear();
    index_.slice(1, slice, "t.sf", false);
    return fdsConditions(read(""), quantity, 1 << 20);
  };
  for (const auto& one : right) {
    slice.unit = one.unit;
    EXPECT_NEAR(valueAt(*conditions(one.stored, "temperature").value(), 0, 1), one.value, 1e-4);
  }
  slice.unit = "";
  EXPECT_THAT(conditions(80, "temperature").error().message,
              HasSubstr("slice3d-temperature is in ''; expected C"));
  slice.quantity = "CARBON MONOXIDE VOLUME FRACTION";
  slice.unit = "ppm";
  EXPECT_NEAR(valueAt(*conditions(1200, "carbon-monoxide").value(), 0, 1), 0.0012, 1e-9);
  slice.unit = "";
  EXPECT_THAT(conditions(0.2, "carbon-monoxide").error().message, HasSubstr("is in ''"));
  slice.unit = "kg/kg";
  EXPECT_THAT(conditions(0.2, "carbon-monoxide").error().message, HasSubstr("is in 'kg/kg'"));
  slice.unit = "mol/mol";
  auto percent = conditions(20.9, "carbon-monoxide").value();
  double value = 0;
  const Vec3 point(1, 0.5, 0.5);
  EXPECT_THAT(percent->at(0, {&point, 1}, {&value, 1}).error().message,
              HasSubstr("is 20.9 mol/mol at 0 s; expected a fraction of at most 1"));
}

TEST_F(FdsDevices, TimesMayGoBack) {
  const fdswriter::Slice slice{{0, 1, 0, 1, 0, 1}, "TEMPERATURE", "temp", "C"};
  std::vector<std::pair<float, std::vector<float>>> frames;
  for (int i = 0; i < 5; ++i) frames.emplace_back(10.0F * i, std::vector<float>(8, 20.0F + i));
  fdswriter::sliceFile(slice, frames).save(folder_ / "t.sf");
  index_.slice(1, slice, "t.sf", false);
  auto field = fdsConditions(read(""), "temperature", 1 << 20).value();
  for (const double time : {35.0, 25.0, 5.0, 15.0, 40.0, 0.0, 5.0, 35.0})
    EXPECT_NEAR(valueAt(*field, time, 1), 20 + time / 10, 1e-4) << time;
}

TEST_F(FdsDevices, AFractionAboveOneIsNotUsed) {
  const std::string input =
      "&DEVC ID='O', QUANTITY='VOLUME FRACTION', SPEC_ID='OXYGEN', XYZ=1,.5,.5 /\n";
  device("O", "VOLUME FRACTION");

  const struct {
    const char *unit, *values, *says;
  } wrong[] = {{"", "20.9", "up to 20.9 without a unit, where a fraction is at most 1: in %?"},
               {"mol/mol", "20.9", "up to 20.9 in 'mol/mol', where a fraction"},
               {"%", "209000", "up to 2.09e+05 in '%', where a fraction is at most 1: in ppm?"},
               {"kg/kg", "0.23", "in 'kg/kg'"}};

  for (const auto& one : wrong) {
    const auto index = read(
        fmt::format("s,{}\nTime,\"O\"\n0,{}\n10,8\n", one.unit, one.values).c_str(), input.c_str());
    const auto field = fdsConditions(index, "oxygen", 1 << 20);
    ASSERT_FALSE(field) << one.unit;
    EXPECT_THAT(field.error().message, HasSubstr(one.says));
    EXPECT_THAT(fdsFacts(index).remarks, tells(one.says));
  }
  for (const char* right : {"s,%\nTime,\"O\"\n0,20.9\n", "s,\nTime,\"O\"\n0,1.0001\n"}) {
    const auto field = fdsConditions(read(right, input.c_str()), "oxygen", 1 << 20);
    EXPECT_TRUE(field) << right;
  }
}

}  // namespace
}  // namespace volute
