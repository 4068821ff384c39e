// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/dxf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "volute/base/write_file.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

/// Codes and values from "0 LINE 8 walls": words that stand two and two.
std::string pairs(std::string words) {
  bool value = false;
  for (char& c : words) {
    if (c == ' ')
      c = '\n';
    value ^= c == '\n';
  }
  return words + '\n';
}

std::string fileOf(const std::string& entities, const std::string& before = "") {
  return before + pairs("0 SECTION 2 ENTITIES") + entities + pairs("0 ENDSEC 0 EOF");
}

class Dxf : public ::testing::Test {
 protected:
  Result<DxfDrawing> read(const std::string& text, std::uint64_t maxMemory = 64 << 20) {
    const auto file = std::filesystem::path(::testing::TempDir()) / "a.dxf";
    EXPECT_TRUE(writeFile(file, text));
    return readDxf(file, maxMemory);
  }

  DxfDrawing drawn(const std::string& text) {
    auto drawing = read(text);
    EXPECT_TRUE(drawing) << drawing.error().message;
    return drawing ? *drawing : DxfDrawing();
  }

  std::string refusal(const std::string& text) {
    const auto drawing = read(text);
    return drawing ? std::string("read") : drawing.error().message;
  }
};

double farthest(const DxfDrawing& drawing, const Vec2& center, double radius) {
  double most = 0;
  for (const DrawnLine& line : drawing.lines) {
    for (const Vec2& point : {line.from, line.to, Vec2(0.5 * (line.from + line.to))})
      most = std::max(most, std::abs((point - center).norm() - radius));
  }
  return most;
}

double lengthOf(const DxfDrawing& drawing) {
  double length = 0;
  for (const DrawnLine& line : drawing.lines) length += (line.to - line.from).norm();
  return length;
}

TEST_F(Dxf, linesAndTheirUnit) {
  const std::string header =
      pairs("0 SECTION 2 HEADER 9 $ACADVER 1 AC1015 9 $INSUNITS 70 4 0 ENDSEC");
  const auto drawing =
      drawn(fileOf(pairs("0 LINE 8 walls 10 1 20 2 30 9 11 3.5 21 -4e1 31 9"), header));
  ASSERT_EQ(drawing.lines.size(), 1u);
  EXPECT_EQ(drawing.lines[0].from, Vec2(1, 2));
  EXPECT_EQ(drawing.lines[0].to, Vec2(3.5, -40));
  EXPECT_EQ(drawing.unit, 1e-3);
  EXPECT_FALSE(drawn(fileOf(pairs("0 LINE 10 1 20 2 11 3 21 4"))).unit);
}

TEST_F(Dxf, linesEndAsTheyDoOnOtherSystems) {
  std::string text = fileOf(pairs("0 LINE 10 1 20 2 11 3 21 4"));
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string("") + c;
  EXPECT_EQ(drawn(windows).lines.size(), 1u);
  EXPECT_EQ(drawn("\xEF\xBB\xBF" + text).lines.size(), 1u);
  EXPECT_EQ(drawn("999\nmade by hand\n" + text).lines.size(), 1u);
}

TEST_F(Dxf, arcsAndCirclesAreRound) {
  const auto circle = drawn(fileOf(pairs("0 CIRCLE 10 2 20 3 40 5")));
  EXPECT_LT(farthest(circle, Vec2(2, 3), 5), 5 / 1999.0);
  EXPECT_NEAR(lengthOf(circle), 10 * std::numbers::pi, 0.02);
  // From 350 to 20 degrees, over 0.
  const auto arc = drawn(fileOf(pairs("0 ARC 10 0 20 0 40 2 50 350 51 20")));
  EXPECT_NEAR(lengthOf(arc), 2 * std::numbers::pi / 6, 1e-3);
  EXPECT_NEAR(arc.lines.back().to.x(), 2 * std::cos(std::numbers::pi / 9), 1e-12);
}

TEST_F(Dxf, bulgesAreArcs) {
  // A half circle to the right of the way from (0, 0) to (2, 0), which is below it, and back.
  const auto half = drawn(fileOf(pairs("0 LWPOLYLINE 90 2 70 1 10 0 20 0 42 1 10 2 20 0")));
  EXPECT_NEAR(lengthOf(half), std::numbers::pi + 2, 2e-3);
  double low = 0;
  for (const DrawnLine& line : half.lines) low = std::min(low, line.to.y());
  EXPECT_NEAR(low, -1, 1e-3);
  // A quarter: tan(90 / 4 degrees).
  const auto quarter =
      drawn(fileOf(pairs("0 LWPOLYLINE 70 0 10 1 20 0 42 0.41421356237309503 10 0 20 1")));
  EXPECT_LT(farthest(quarter, Vec2(0, 0), 1), 1 / 1999.0);
}

TEST_F(Dxf, oldPolylinesHaveTheirPointsAsEntities) {
  const auto drawing =
      drawn(fileOf(pairs("0 POLYLINE 66 1 70 1 10 0 20 0 0 VERTEX 10 1 20 1 0 VERTEX 10 4 20 1 "
                         "0 VERTEX 10 4 20 5 0 SEQEND")));
  ASSERT_EQ(drawing.lines.size(), 3u);
  EXPECT_DOUBLE_EQ(lengthOf(drawing), 3 + 4 + 5);
  EXPECT_THAT(refusal(fileOf(pairs("0 VERTEX 10 1 20 1"))),
              HasSubstr("a VERTEX without its POLYLINE"));
}

TEST_F(Dxf, ellipsesHaveTheirAxes) {
  const auto drawing =
      drawn(fileOf(pairs("0 ELLIPSE 10 1 20 1 11 0 21 3 40 0.5 41 0 42 6.283185307179586")));
  for (const DrawnLine& line : drawing.lines) {
    const Vec2 p = line.from - Vec2(1, 1);
    EXPECT_NEAR(p.y() * p.y() / 9 + p.x() * p.x() / 2.25, 1, 1e-12);
  }
}

TEST_F(Dxf, splinesFollowTheirControlPoints) {
  // A rational quadratic that is a quarter of a circle.
  const auto drawing = drawn(
      fileOf(pairs("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 0.7071067811865476 41 1 "
                   "10 1 20 0 10 1 20 1 10 0 20 1")));
  EXPECT_EQ(drawing.lines.size(), 16u);
  for (const DrawnLine& line : drawing.lines) EXPECT_NEAR(line.to.norm(), 1, 1e-12);
  // Given by what it passes alone.
  EXPECT_EQ(drawn(fileOf(pairs("0 SPLINE 71 3 11 0 21 0 11 1 21 0 11 1 21 1"))).lines.size(), 2u);
  EXPECT_THAT(refusal(fileOf(pairs("0 SPLINE 71 3 40 0 40 1 10 1 20 1"))),
              HasSubstr("1 points and 2 knots"));
}

TEST_F(Dxf, blocksAreInsertedTurnedAndStretched) {
  const std::string blocks = pairs(
      "0 SECTION 2 BLOCKS 0 BLOCK 2 door 10 1 20 0 0 LINE 10 1 20 0 11 2 21 0 0 ENDBLK "
      "0 BLOCK 2 two 10 0 20 0 0 INSERT 2 door 10 0 20 0 0 ENDBLK 0 ENDSEC");
  const auto drawing =
      drawn(fileOf(pairs("0 INSERT 2 two 10 5 20 6 41 2 42 3 50 90 70 2 44 10"), blocks));
  ASSERT_EQ(drawing.lines.size(), 2u);
  EXPECT_LT((drawing.lines[0].from - Vec2(5, 6)).norm(), 1e-12);
  EXPECT_LT((drawing.lines[0].to - Vec2(5, 8)).norm(), 1e-12);
  EXPECT_LT((drawing.lines[1].from - Vec2(5, 16)).norm(), 1e-12) << "columns go along the turned x";
  EXPECT_THAT(refusal(fileOf(pairs("0 INSERT 2 gate 10 0 20 0"))),
              HasSubstr("'gate', which is not there"));
  const std::string ring =
      pairs("0 SECTION 2 BLOCKS 0 BLOCK 2 a 0 INSERT 2 a 10 0 20 0 0 ENDBLK 0 ENDSEC");
  EXPECT_THAT(refusal(fileOf(pairs("0 INSERT 2 a 10 0 20 0"), ring)),
              HasSubstr("blocks within each other"));
}

TEST_F(Dxf, manyCopiesOfNothingEnd) {
  std::string blocks = "0 SECTION 2 BLOCKS";
  for (int i = 0; i < 8; ++i)
    blocks += " 0 BLOCK 2 b" + std::to_string(i) + " 0 INSERT 2 b" + std::to_string(i + 1) +
              " 10 0 20 0 70 100 71 100 0 ENDBLK";
  blocks += " 0 BLOCK 2 b8 0 ENDBLK 0 ENDSEC";
  EXPECT_THAT(refusal(fileOf(pairs("0 INSERT 2 b0 10 0 20 0"), pairs(blocks))),
              HasSubstr("blocks within blocks counted"));
}

TEST_F(Dxf, whatIsSeenFromBelowIsMirrored) {
  const auto drawing = drawn(fileOf(pairs("0 LWPOLYLINE 10 1 20 0 10 2 20 0 230 -1")));
  EXPECT_EQ(drawing.lines.at(0).to, Vec2(-2, 0));
}

TEST_F(Dxf, whatIsHiddenIsNotDrawnAndTheRestIsCounted) {
  const std::string layers = pairs(
      "0 SECTION 2 TABLES 0 TABLE 2 LAYER 0 LAYER 2 off 70 0 62 -7 0 LAYER 2 cold 70 1 62 7 "
      "0 LAYER 2 on 70 0 62 7 0 ENDTAB 0 ENDSEC");
  const std::string line = " 10 0 20 0 11 1 21 1";
  const auto drawing = drawn(fileOf(pairs("0 LINE 8 off" + line) + pairs("0 LINE 8 cold" + line) +
                                        pairs("0 LINE 8 on" + line) + pairs("0 LINE 60 1" + line) +
                                        pairs("0 LINE 67 1" + line) + pairs("0 TEXT 8 on 1 hall"),
                                    layers));
  EXPECT_EQ(drawing.lines.size(), 1u);
  EXPECT_EQ(drawing.left.at("TEXT"), 1);
  EXPECT_THAT(refusal(fileOf(pairs("0 LINE 8 off" + line), layers)), HasSubstr("off or frozen"));
}

TEST_F(Dxf, closedLinesAndTextsOfALayerAreKeptThoughItIsOff) {
  const std::string layers =
      pairs("0 SECTION 2 TABLES 0 LAYER 2 Areas 70 0 62 -7 0 LAYER 2 walls 70 0 62 7 0 ENDSEC") +
      pairs(
          "0 SECTION 2 BLOCKS 0 BLOCK 2 room 10 0 20 0 0 LWPOLYLINE 8 0 70 1 10 0 20 0 10 1 20 0 "
          "10 1 20 1 0 ENDBLK 0 ENDSEC");
  const std::string text =
      fileOf(pairs("0 LWPOLYLINE 8 AREAS 70 1 10 0 20 0 10 4 20 0 10 4 20 3 10 0 20 3") +
                 pairs("0 LWPOLYLINE 8 AREAS 70 0 10 9 20 0 10 9 20 1") +
                 pairs("0 LWPOLYLINE 8 walls 70 1 10 0 20 0 10 1 20 0 10 1 20 1") +
                 pairs("0 CIRCLE 8 Areas 10 8 20 8 40 1") +
                 pairs("0 INSERT 8 AREAS 2 room 10 20 20 5 41 2 42 2") +
                 pairs("0 MTEXT 8 AREAS 10 1 20 1 1 {\\fArial|b0;Hall\\PNorth}") +
                 pairs("0 TEXT 8 walls 10 1 20 1 1 other"),
             layers);
  const auto file = std::filesystem::path(::testing::TempDir()) / "layers.dxf";
  ASSERT_TRUE(writeFile(file, text));
  const auto drawing = readDxf(file, 64 << 20, "areas");
  ASSERT_TRUE(drawing) << drawing.error().message;
  ASSERT_EQ(drawing->outlines.size(), 3u);
  EXPECT_EQ(drawing->outlines[0].points.at(2), Vec2(4, 3));
  EXPECT_EQ(drawing->outlines[2].points.at(2), Vec2(22, 7)) << "a block's layer 0 is where it is";
  EXPECT_EQ(drawing->open, 1);
  ASSERT_EQ(drawing->texts.size(), 1u);
  EXPECT_EQ(drawing->texts[0].text, "Hall North");
  EXPECT_EQ(drawing->lines.size(), 3u) << "what is off is not drawn";
  EXPECT_THAT(readDxf(file, 64 << 20, "area").error().message, HasSubstr("did you mean"));
}

TEST_F(Dxf, namesAreInTheCodePageOfTheFile) {
  const auto named = [&](const std::string& page, const std::string& text) {
    const std::string header =
        page.empty() ? "" : pairs("0 SECTION 2 HEADER 9 $DWGCODEPAGE 3 " + page + " 0 ENDSEC");
    const auto file = std::filesystem::path(::testing::TempDir()) / "page.dxf";
    EXPECT_TRUE(writeFile(file, fileOf(pairs("0 LINE 8 R 10 0 20 0 11 1 21 1") +
                                           pairs("0 ATTRIB 8 R 10 1 20 1 2 NAME 1 Tag") +
                                           pairs("0 TEXT 8 R 10 1 20 1 1 " + text),
                                       header)));
    const auto drawing = readDxf(file, 64 << 20, "R");
    EXPECT_TRUE(drawing) << drawing.error().message;
    EXPECT_EQ(drawing->texts.size(), 2U);
    EXPECT_EQ(drawing->texts.back().text, "Tag") << "texts go first";
    return drawing->texts.front().text;
  };
  EXPECT_EQ(named("ANSI_1252",
                  "K\xFC"
                  "che\x80"),
            "Küche€");
  EXPECT_EQ(named("ANSI_1250", "\xF8"), "ř");
  EXPECT_EQ(named("ANSI_1252", "Küche"), "Küche") << "UTF-8 whatever it states";
  EXPECT_EQ(named("",
                  "K\xFC"
                  "che"),
            "Küche");
  EXPECT_EQ(named("ANSI_1252", "K\\U+00FCche"), "Küche");
  EXPECT_EQ(named("ANSI_99999", "K\\U+00F\xFC"), "K\\U+00Fü");
}

TEST_F(Dxf, damagedFilesAreRefusedWithTheirLine) {
  EXPECT_THAT(refusal(fileOf(pairs("0 LINE 10 x1 20 0 11 1 21 1"))),
              HasSubstr("line 8: 'x1' is no number (group 10)"));
  EXPECT_THAT(refusal(fileOf(pairs("0 LINE 10 nan 20 0 11 1 21 1"))), HasSubstr("is no number"));
  EXPECT_THAT(refusal(fileOf(pairs("0 LINE 10 1e300 20 0 11 1 21 1"))), HasSubstr("is no number"));
  EXPECT_THAT(refusal(fileOf(pairs("0 LINE 10 1"))), HasSubstr("LINE without group 20"));
  EXPECT_THAT(refusal("hello\nworld\n"), HasSubstr("line 1: 'hello' is no group code"));
  EXPECT_THAT(refusal(""), HasSubstr("cut off"));
  EXPECT_THAT(refusal("AutoCAD Binary DXF\r\n"), HasSubstr("save it as ASCII DXF"));
  EXPECT_THAT(refusal(fileOf("")), HasSubstr("no lines"));
  const std::string whole = fileOf(pairs("0 LINE 10 1 20 2 11 3 21 4"));
  for (std::size_t length = 0; length + 1 < whole.size(); ++length)
    EXPECT_FALSE(read(whole.substr(0, length))) << length;
  EXPECT_FALSE(read(whole, 256)) << "memory";
}

}  // namespace
}  // namespace volute
