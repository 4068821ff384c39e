// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_underlay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "volute/base/program.hpp"
#include "volute/base/write_file.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Underlay : public ::testing::Test {
 protected:
  /// A rectangle of the given corners, in a .dxf with the unit's code, or none.
  std::filesystem::path rectangle(double x0, double y0, double x1, double y1, int unit) {
    const auto file = std::filesystem::path(::testing::TempDir()) / "plan.dxf";
    std::string text;
    if (unit > 0)
      text = fmt::format("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n", unit);
    text += "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n70\n1\n";
    for (const auto& [x, y] : {std::pair(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}})
      text += fmt::format("10\n{}\n20\n{}\n", x, y);
    EXPECT_TRUE(writeFile(file, text + "0\nENDSEC\n0\nEOF\n"));
    return file;
  }

  UnderlayOptions options_{Vec2(0, 0), Vec2(20, 10), {}, 64 << 20};
  std::vector<Remark> remarks_;
};

TEST_F(Underlay, aDrawingLiesWhereItsCoordinatesSay) {
  const auto underlay = readUnderlay(rectangle(1000, 2000, 19000, 9000, 4), options_, remarks_);
  ASSERT_TRUE(underlay) << underlay.error().message;
  EXPECT_LT((underlay->min - Vec2(1, 2)).norm() + (underlay->max - Vec2(19, 9)).norm(), 1e-12);
  EXPECT_EQ(underlay->lines.size(), 4u);
  EXPECT_THAT(remarks_, ElementsAre());
}

TEST_F(Underlay, aUnitThatIsNotStatedIsThatOfTheCasesSize) {
  const auto underlay = readUnderlay(rectangle(0, 0, 1950, 980, 0), options_, remarks_);
  ASSERT_TRUE(underlay);
  EXPECT_LT((underlay->max - Vec2(19.5, 9.8)).norm(), 1e-12);
  EXPECT_THAT(remarks_,
              ElementsAre(::testing::Field(&Remark::sentence,
                                           HasSubstr("taken as cm, by its size of 1950 x 980"))));
}

TEST_F(Underlay, aDrawingApartFromTheCaseIsMovedToItsCorner) {
  const auto underlay = readUnderlay(rectangle(500, 500, 518, 509, 6), options_, remarks_);
  ASSERT_TRUE(underlay);
  EXPECT_LT((underlay->min - Vec2(0, 0)).norm() + (underlay->max - Vec2(18, 9)).norm(), 1e-12);
  EXPECT_THAT(remarks_, ElementsAre(::testing::Field(&Remark::sentence,
                                                     HasSubstr("lies apart from the case"))));
}

TEST_F(Underlay, itsPlaceCanBeStated) {
  options_.place = {{2, 3}, {8, 5}};
  const auto underlay = readUnderlay(rectangle(500, 500, 518, 509, 6), options_, remarks_);
  ASSERT_TRUE(underlay);
  EXPECT_LT((underlay->min - Vec2(2, 3)).norm() + (underlay->max - Vec2(8, 5)).norm(), 1e-12);
  EXPECT_THAT(remarks_, ElementsAre());
}

TEST_F(Underlay, closedLinesOfALayerAreAreas) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "areas.dxf";
  const auto write = [&](const std::string& entities) {
    std::string text = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES " +
                       entities + " 0 ENDSEC 0 EOF\n";
    std::ranges::replace(text, ' ', '\n');
    ASSERT_TRUE(writeFile(file, text));
  };
  const std::string office =
      "0 LWPOLYLINE 8 A 70 1 10 0 20 0 10 6000 20 0 10 6000 20 4000 10 0 20 4000";
  const std::string hall =
      "0 LWPOLYLINE 8 A 70 1 10 6000 20 0 10 20000 20 0 10 20000 20 10000 10 6000 20 10000";
  options_.areaLayer = "A";
  write(office + " " + hall + " 0 TEXT 8 A 10 100 20 100 1 office");
  const auto underlay = readUnderlay(file, options_, remarks_);
  ASSERT_TRUE(underlay) << underlay.error().message;
  ASSERT_EQ(underlay->areas.size(), 2u);
  EXPECT_EQ(underlay->areas[0].name, "office");
  EXPECT_EQ(underlay->areas[1].name, "A 2");
  EXPECT_TRUE(underlay->areas[0].contains(Vec2(3, 2)));
  EXPECT_FALSE(underlay->areas[0].contains(Vec2(7, 2)));
  EXPECT_TRUE(underlay->areas[1].isAt(17)) << "on each storey";
  // What areas.json refuses is refused here.
  write(office + " " + office);
  EXPECT_THAT(readUnderlay(file, options_, remarks_).error().message,
              HasSubstr("overlaps area 'A 1'"));
  write(office + " 0 TEXT 8 A 10 100 20 100 1 x " + hall + " 0 TEXT 8 A 10 7000 20 100 1 x");
  EXPECT_THAT(readUnderlay(file, options_, remarks_).error().message, HasSubstr("is the name of"));
  write("0 LWPOLYLINE 8 A 70 1 10 0 20 0 10 2000 20 2000 10 2000 20 0 10 0 20 2000");
  EXPECT_THAT(readUnderlay(file, options_, remarks_).error().message,
              HasSubstr("crosses itself at x = 1, y = 1 m"));
  write("0 LINE 8 A 10 0 20 0 11 2000 21 2000");
  EXPECT_THAT(readUnderlay(file, options_, remarks_).error().message,
              HasSubstr("has 0 closed lines"));
  EXPECT_THAT(readUnderlay("plan.png", options_, remarks_).error().message,
              HasSubstr("layers of .dxf and .svg drawings"));
}

TEST_F(Underlay, otherFilesAreRefusedWithWhatToDo) {
  const auto underlay = readUnderlay("plan.dwg", options_, remarks_);
  ASSERT_FALSE(underlay);
  EXPECT_THAT(underlay.error().message, HasSubstr(".png, .svg or .dxf"));
}

TEST_F(Underlay, aDrawingInSvgIsAPicture) {
  const ScratchFolder folder;
  const auto file = folder.path() / "plan.svg", cut = folder.path() / "cut.svg";
  const std::string text =
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 20 10'><rect x='5' y='0' width='1' "
      "height='5'/></svg>\n";
  ASSERT_TRUE(writeFile(file, text));
  ASSERT_TRUE(writeFile(cut, text.substr(0, 60)));
  options_.maxMemory = std::uint64_t{1} << 30;
  const auto underlay = readUnderlay(file, options_, remarks_);
  if (findProgram({"rsvg-convert"}).empty()) {
    ASSERT_FALSE(underlay);
    EXPECT_THAT(underlay.error().message, HasSubstr("rsvg-convert"));
    return;
  }
  ASSERT_TRUE(underlay) << underlay.error().message;
  const Image& picture = underlay->picture;
  EXPECT_EQ(picture.width, 2 * picture.height);
  const auto at = [&](double x, double y) {
    return picture.at(static_cast<int>(x / 20 * picture.width),
                      static_cast<int>(y / 10 * picture.height), 0);
  };
  EXPECT_EQ(at(5.5, 2.5), 0) << "the wall is black";
  EXPECT_EQ(at(5.5, 7.5), 1) << "what is transparent is white";
  EXPECT_EQ(at(3, 2.5), 1);
  EXPECT_EQ(underlay->max, Vec2(20, 10));
  const auto refused = readUnderlay(cut, options_, remarks_);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("cut.svg: not a drawing"));
  EXPECT_FALSE(readUnderlay(folder.path() / "nowhere.svg", options_, remarks_));
}

TEST(LineWithin, cutsAtTheRectangle) {
  const Vec2 min(0, 0), max(4, 2);
  const auto through = lineWithin({-2, 1}, {6, 1}, min, max);
  ASSERT_TRUE(through);
  EXPECT_LT((through->first - Vec2(0, 1)).norm() + (through->second - Vec2(4, 1)).norm(), 1e-12);
  EXPECT_FALSE(lineWithin({-1, 3}, {5, 3}, min, max));
  EXPECT_FALSE(lineWithin({-2, 1}, {1, 4}, min, max)) << "past the corner";
  const auto inside = lineWithin({1, 1}, {2, 1.5}, min, max);
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->second, Vec2(2, 1.5));
  EXPECT_TRUE(lineWithin({1, 1}, {1, 1}, min, max));
  EXPECT_FALSE(lineWithin({5, 1}, {5, 1}, min, max));
}

}  // namespace
}  // namespace volute
