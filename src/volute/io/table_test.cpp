// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

double changed(double value, std::string_view from, std::string_view to) {
  const auto change = unitChange(from, to);
  EXPECT_TRUE(change) << from << " to " << to;
  return change ? (*change)(value) : 0;
}

TEST(Units, AreConverted) {
  EXPECT_EQ(changed(20.3, "C", "C"), 20.3) << "exactly";
  EXPECT_EQ(changed(250, "cm", "m"), 2.5);
  EXPECT_EQ(changed(1.5, "min", "s"), 90);
  EXPECT_EQ(changed(1.5, "MIN", "s"), 90);
  EXPECT_EQ(changed(0.5, "hours", "s"), 1800);
  EXPECT_EQ(changed(0.5, "days", "s"), 43200);
  EXPECT_EQ(changed(250, "Milliseconds", "s"), 0.25);
  EXPECT_EQ(changed(250, "millimetres", "m"), 0.25);
  EXPECT_NEAR(changed(250, "µs", "s"), 2.5e-4, 1e-18);
  EXPECT_NEAR(changed(300, "K", "C"), 26.85, 1e-9);
  EXPECT_NEAR(changed(140, "°F", "C"), 60, 1e-9);
  EXPECT_NEAR(changed(140,
                      "\xB0"
                      "F",
                      "C"),
              60, 1e-9)
      << "Latin-1";
  EXPECT_NEAR(changed(8, "%", "mol/mol"), 0.08, 1e-15);
  EXPECT_NEAR(changed(1200, "ppm", "mol/mol"), 0.0012, 1e-15);
  EXPECT_NEAR(changed(5, "g/kg", "kg/kg"), 0.005, 1e-15);
  EXPECT_NEAR(changed(2500, "W/m2", "kW/m2"), 2.5, 1e-12);
  for (const char* name : {"kW/m2", "kW/m^2", "kW m-2", "kW·m⁻²", "kW/m²", "kW/m\xB2", "kW m^-2"})
    EXPECT_NEAR(changed(2.5, name, "W/m2"), 2500, 1e-9) << name;
  EXPECT_NEAR(changed(3, "mg/m³", "kg/m3"), 3e-6, 1e-20);
  EXPECT_NEAR(changed(3, "1/cm", "1/m"), 300, 1e-12);
}

TEST(Units, OfOtherThingsAreRefused) {
  EXPECT_FALSE(unitChange("s", "m"));
  EXPECT_FALSE(unitChange("kg/kg", "mol/mol")) << "the share of mass is not that of amount";
  EXPECT_FALSE(unitChange("furlong", "m"));
  EXPECT_FALSE(unitChange("kW/", "kW"));
  EXPECT_FALSE(unitChange("m99999999999", "m"));
  EXPECT_TRUE(isUnit(""));
  EXPECT_FALSE(isUnit("2"));
  EXPECT_FALSE(isUnit("kilo"));
  EXPECT_FALSE(isUnit("millicelsius"));
}

TEST(Tables, NumbersOfFortranAreRead) {
  EXPECT_EQ(fortranNumber("2.0-101").value(), 2e-101);
  EXPECT_EQ(fortranNumber("-2.0D+03").value(), -2000);
  EXPECT_EQ(fortranNumber("1.5E+000").value(), 1.5);
  for (const char* text : {"*****", "NaN", "", "1+", "--1", "Infinity"})
    EXPECT_FALSE(fortranNumber(text)) << text;
}

struct Rows {
  std::vector<std::vector<double>> values;
  std::vector<Remark> remarks;
};

Result<Rows> rowsOf(std::string_view text, TableRules rules = {}) {
  TableReader table("t.csv", {{"x", "m"}, {"time", "s", {"t"}}, {"name", "", {}, true}}, rules);
  Rows rows;
  VOLUTE_TRY(readTable(table, text, [&]() -> Status {
    std::vector<double> row;
    for (const std::size_t column : {0, 1}) {
      if (table.has(column)) {
        VOLUTE_ASSIGN(const double value, table.number(column));
        row.push_back(value);
      }
    }
    rows.values.push_back(row);
    return {};
  }));
  rows.remarks.assign(table.remarks().begin(), table.remarks().end());
  return rows;
}

std::string refusal(std::string_view text, TableRules rules = {}) {
  const auto rows = rowsOf(text, rules);
  EXPECT_FALSE(rows) << text;
  return rows ? "" : rows.error().message;
}

TEST(Tables, UnitsStandInNamesOrBelow) {
  for (const char* head :
       {"x [cm],time [min]", "x (cm),time (min)", "X/cm,Time/min", "x[in cm],time in min",
        "\"x [cm]\",\"t [min]\"", "x,time\ncm,min", "x [cm],time\n,min", "x [cm],time\ncm,min",
        "x [cm];time [min]", "x [cm]\ttime [min]"}) {
    const std::string_view text(head);
    const char separator = text.find(';') != text.npos    ? ';'
                           : text.find('\t') != text.npos ? '\t'
                                                          : ',';
    const auto rows = rowsOf(fmt::format("{}\n250{}0.5\n", head, separator));
    ASSERT_TRUE(rows) << head << ": " << rows.error().message;
    ASSERT_EQ(rows->values.size(), 1U) << head;
    EXPECT_THAT(rows->values[0], ElementsAre(2.5, 30)) << head;
  }
}

TEST(Tables, UnitsThatAreNoneAreRefused) {
  EXPECT_THAT(refusal("x [furlong],time\n1,2\n"),
              HasSubstr("line 1: x is in 'furlong'; expected m"));
  EXPECT_THAT(refusal("x,time [m]\n1,2\n"), HasSubstr("time is in 'm'; expected s"));
  EXPECT_THAT(refusal("x,time\nm,m\n1,2\n"), HasSubstr("line 2: time is in 'm'"));
  EXPECT_THAT(refusal("x [cm],time\nm,s\n1,2\n"), HasSubstr("its name has another unit"));
  EXPECT_THAT(refusal("x,time\nfurlong,s\n1,2\n"), HasSubstr("line 2: x is 'furlong'"));
}

TEST(Tables, ColumnsAreNamedOnceAndKnown) {
  EXPECT_THAT(refusal("x,times\n1,2\n"), HasSubstr("unknown column 'times': did you mean 'time'?"));
  EXPECT_THAT(refusal("x,t,time\n1,2,3\n"), HasSubstr("two columns are called 'time'"));
  EXPECT_THAT(refusal("x,X\n1,2\n"), HasSubstr("two columns are called 'x'"));
  EXPECT_TRUE(rowsOf("x,#law,\n1,a,\n"));
  const auto others =
      rowsOf("x,law,speed,Angle [deg]\n1,a,2,3\n", {.own = false, .spare = {"angle"}});
  ASSERT_TRUE(others);
  ASSERT_EQ(others->remarks.size(), 2U);
  EXPECT_EQ(others->remarks[0].code, RemarkCode::kNote);
  EXPECT_THAT(others->remarks[0].sentence, HasSubstr("not used of its columns: Angle [deg]"));
  EXPECT_EQ(others->remarks[1].code, RemarkCode::kLeftOut);
  EXPECT_THAT(others->remarks[1].sentence, HasSubstr("not used of its columns: law, speed"));
}

TEST(Tables, WithoutNamesHaveTheFirstColumns) {
  EXPECT_THAT(rowsOf("# a remark\n\n1,2\n", {.unnamed = {1, 3}})->values[0], ElementsAre(1, 2));
  EXPECT_THAT(refusal("1,2\n"), HasSubstr("expected a line with the names of columns: x, time"));
  EXPECT_THAT(refusal("1,2,3,4\n", {.unnamed = {1, 3}}), HasSubstr("4 columns without names"));
  EXPECT_THAT(refusal("x\n1\n1,2\n"), HasSubstr("line 3: 2 columns; expected 1"));
  EXPECT_THAT(refusal("x,t\n1,2\n1\n"), HasSubstr("is a value missing"));
}

TEST(Tables, HaveDecimalCommasWhereOthersSeparate) {
  EXPECT_THAT(rowsOf("x;t\n1,5;-2,25e1\n")->values[0], ElementsAre(1.5, -22.5));
  EXPECT_THAT(rowsOf("x\tt\nm\ts\n1,5\t2.5\n")->values[0], ElementsAre(1.5, 2.5));
  EXPECT_THAT(rowsOf("1,5;2\n", {.unnamed = {1, 3}})->values[0], ElementsAre(1.5, 2));
  EXPECT_THAT(refusal("x;t\n1,500.2;2\n"), HasSubstr("x is '1,500.2'; expected a number"));
  EXPECT_THAT(refusal("x;t\n1,500,2;2\n"), HasSubstr("x is '1,500,2'; expected a number"));
}

TEST(Tables, AreUtf8OrLatin1) {
  TableReader table("t.csv", {{"x", "m"}, {"name", "", {}, true}}, {});
  EXPECT_FALSE(table.take("x,name").value());
  EXPECT_TRUE(table.take("1,T\xFCr").value());
  EXPECT_EQ(table.text(1), "Tür");
  EXPECT_TRUE(table.take("1,Tür").value());
  EXPECT_EQ(table.text(1), "Tür");
}

}  // namespace
}  // namespace volute
