// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/csv_cell.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

TEST(CsvCell, IsTheTextWhereItCanBe) {
  for (const char* text : {"", "exit", "a b", "1", "-2.5", "-1e-3", "x=1", "'quoted'"})
    EXPECT_EQ(csvCell(text), text);
}

TEST(CsvCell, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csvCell("exit, north"), "\"exit, north\"");
  EXPECT_EQ(csvCell("the \"big\" one"), "\"the \"\"big\"\" one\"");
  EXPECT_EQ(csvCell("two\r\nlines"), "two  lines");
}

TEST(CsvCell, HasNoControlCharacters) {
  EXPECT_EQ(csvCell("ex\x1b[31mit\x07"), "ex\\u001b[31mit\\u0007");
  EXPECT_EQ(csvCell("tab\there"), "tab\there");
}

TEST(CsvCell, IsNoFormula) {
  EXPECT_EQ(csvCell("=1+1"), "'=1+1");
  EXPECT_EQ(csvCell("+x"), "'+x");
  EXPECT_EQ(csvCell("-2+3"), "'-2+3");
  EXPECT_EQ(csvCell("@x"), "'@x");
  EXPECT_EQ(csvCell("\t=1"), "'\t=1");
  EXPECT_EQ(csvCell("\n=1"), "' =1");
  EXPECT_EQ(csvCell("=cmd|' /C calc'!A0"), "'=cmd|' /C calc'!A0");
  EXPECT_EQ(csvCell("=HYPERLINK(\"http://x\",\"y\")"),
            "\"'=HYPERLINK(\"\"http://x\"\",\"\"y\"\")\"");
  EXPECT_EQ(csvCell("-inf"), "'-inf");
}

}  // namespace
}  // namespace volute
