// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_picture.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "volute/report/canvas.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

/// 10 x 6 m, a point every 0.25 m; 22 pixels a point.
struct PlanOfRoom {
  FloorPlan plan;
  PlanPicture picture;

  PlanOfRoom() {
    plan.step = 0.25;
    plan.nx = 40, plan.ny = 24;
    plan.origin = Vec3(0.125, 0.125, 1.8);
    plan.places.assign(plan.size(), Place::kGas);
    picture.title = "A room";
    picture.barLabel = "time [s]";
    picture.high = 60;
    picture.values.assign(plan.size(), 30);
    picture.marks.assign(plan.size(), PlanMark::kValue);
  }

  /// Of a point in metres.
  Rgb at(const Image& image, double x, double y) const {
    constexpr int scale = 22;  // pixels a point
    const int px = static_cast<int>(92 + x / plan.step * scale);
    const int py = static_cast<int>(62 + (6 - y) / plan.step * scale);
    return {image.at(px, py, 0), image.at(px, py, 1), image.at(px, py, 2)};
  }
};

TEST(PlanPicture, thinWallsStandAtTheirPlaceWhateverTheStep) {
  PlanOfRoom room;
  // 0.1 m that no point of the plan stands in, and a sheet without any thickness.
  room.picture.shapes = {{PlanShape::Kind::kSolid, {4.26, 1}, {4.36, 5}},
                         {PlanShape::Kind::kSolid, {7.0, 2}, {7.0, 4}}};
  const Image image = drawPlan(room.plan, room.picture, {});
  for (const double x : {4.28, 4.31, 4.34}) EXPECT_LT(room.at(image, x, 3).maxCoeff(), 0.02) << x;
  for (const double x : {4.22, 4.40}) EXPECT_GT(room.at(image, x, 3).maxCoeff(), 0.1) << x;
  EXPECT_LT(room.at(image, 7.0, 3).maxCoeff(), 0.02);
  EXPECT_GT(room.at(image, 7.0, 5).maxCoeff(), 0.1) << "beyond its end";
  const std::string svg = planSvg(room.plan, room.picture, {});
  EXPECT_THAT(svg, HasSubstr("<svg xmlns="));
  EXPECT_THAT(svg, HasSubstr("wall or obstruction at this height"));
  // 92 + 4.26 / 0.25 x 22 pixels, 0.1 / 0.25 x 22 wide.
  EXPECT_THAT(svg, HasSubstr("<rect x='466.88' y='150.00' width='8.80' height='352.00'"));
}

TEST(PlanPicture, neverLostIsNotNobody) {
  PlanOfRoom room;
  for (std::size_t i = 0; i < room.plan.size(); ++i) {
    const std::size_t x = i % 40;
    room.picture.marks[i] = x < 10   ? PlanMark::kKept
                            : x < 20 ? PlanMark::kSolid
                            : x < 30 ? PlanMark::kHidden
                                     : PlanMark::kLost;
  }
  const Image image = drawPlan(room.plan, room.picture, {});
  const auto share = [&](double from, const auto& is) {
    int count = 0;
    for (int i = 0; i < 400; ++i)
      count += is(room.at(image, from + 2.4 * (i % 20 + 0.5) / 20, 0.5 + 5.0 * (i / 20) / 20));
    return count / 400.0;
  };
  const auto blue = [](const Rgb& c) { return c[2] > c[0] + 0.1; };
  const auto white = [](const Rgb& c) { return c.minCoeff() > 0.95; };
  const auto dark = [](const Rgb& c) { return c.maxCoeff() < 0.2; };
  EXPECT_GT(share(0, blue), 0.1) << "hatched";
  EXPECT_GT(share(0, white), 0.4);
  EXPECT_EQ(share(0, dark), 0);
  EXPECT_EQ(share(2.5, dark), 1) << "nobody stands there";
  EXPECT_EQ(share(5, blue), 0);
  EXPECT_GT(share(5, [](const Rgb& c) { return c.minCoeff() > 0.8; }), 0.99);
  EXPECT_EQ(share(7.5, [](const Rgb& c) { return c.maxCoeff() > 0.3 && c.maxCoeff() < 0.6; }), 1);
}

TEST(PlanPicture, noDataIsHatchedAndHasItsKey) {
  PlanOfRoom room;
  for (std::size_t i = 0; i < room.plan.size(); ++i) {
    room.plan.places[i] = i % 40 < 10 ? Place::kSolid : i % 40 < 20 ? Place::kOutside : Place::kGas;
  }
  const std::vector<PlanMark> empty = emptyMarks(room.plan);
  EXPECT_EQ(empty[0], PlanMark::kSolid);
  EXPECT_EQ(empty[10], PlanMark::kUnknown);
  EXPECT_EQ(empty[20], PlanMark::kUnknown) << "nothing is said of it yet";
  for (std::size_t i = 0; i < empty.size(); ++i) {
    if (i % 40 < 20)
      room.picture.marks[i] = empty[i];
  }
  room.picture.words = {{PlanMark::kUnknown, kNoData}, {PlanMark::kSolid, kSolidWords}};
  const Image image = drawPlan(room.plan, room.picture, {});
  int white = 0, grey = 0, other = 0;
  for (int i = 0; i < 900; ++i) {
    const Rgb c = room.at(image, 2.6 + 2.2 * (i % 30) / 30, 0.5 + 5.0 * (i / 30) / 30);
    const bool even = c.maxCoeff() - c.minCoeff() < 1e-3;
    (c.minCoeff() > 0.95 ? white : even && c.maxCoeff() < 0.9 ? grey : other) += 1;
  }
  EXPECT_GT(white, 300) << "between the lines";
  EXPECT_GT(grey, 150) << "lines both ways";
  EXPECT_LT(other, 200) << "their rims";
  const std::string svg = planSvg(room.plan, room.picture, {});
  EXPECT_THAT(svg, HasSubstr(">no data<"));
  EXPECT_THAT(svg, HasSubstr(">solid: nobody stands there<"));
}

TEST(PlanPicture, storedTimesHaveOneColourEach) {
  PlanOfRoom room;
  for (std::size_t i = 0; i < room.plan.size(); ++i)
    room.picture.values[i] = 10.0 * static_cast<double>(i % 40 / 8);  // 0, 10, ... 40 s
  EXPECT_THAT(planSvg(room.plan, room.picture, {}), HasSubstr(">60<")) << "a bar";
  room.picture.stored = true;
  const std::string svg = planSvg(room.plan, room.picture, {});
  for (const char* time : {">0<", ">10<", ">20<", ">30<", ">40<"})
    EXPECT_THAT(svg, HasSubstr(time));
  EXPECT_EQ(svg.find(">50<"), std::string::npos) << "no time that there is not";
  const Image image = drawPlan(room.plan, room.picture, {});
  std::set<std::array<double, 3>> colours;
  for (int step = 0; step < 5; ++step) {
    const Rgb colour = room.at(image, 2.0 * step + 1, 3);
    colours.insert({colour[0], colour[1], colour[2]});
  }
  EXPECT_EQ(colours.size(), 5U);
}

TEST(PlanPicture, whereNothingIsLostThereIsNoBar) {
  PlanOfRoom room;
  room.picture.stored = true;
  room.picture.marks.assign(room.plan.size(), PlanMark::kKept);
  EXPECT_EQ(planSvg(room.plan, room.picture, {}).find("time [s]"), std::string::npos);
}

TEST(PlanPicture, whatAWallLeavesOfASquareIsNotDark) {
  PlanOfRoom room;
  // A wall from x = 5.0 to 5.2: the middle of the square 5.0 .. 5.25 is in it.
  room.picture.shapes = {{PlanShape::Kind::kSolid, {5, 0}, {5.2, 6}}};
  for (std::size_t i = 20; i < room.plan.size(); i += 40) room.picture.marks[i] = PlanMark::kSolid;
  const Image image = drawPlan(room.plan, room.picture, {});
  EXPECT_LT(room.at(image, 5.1, 3).maxCoeff(), 0.02) << "the wall";
  EXPECT_TRUE((room.at(image, 5.23, 3) == room.at(image, 5.5, 3)).all()) << "beside it";
  // Solid of which no shape is known: dark.
  room.picture.shapes.clear();
  const Image bare = drawPlan(room.plan, room.picture, {});
  EXPECT_FALSE((room.at(bare, 5.23, 3) == room.at(image, 5.5, 3)).all());
}

TEST(PlanPicture, theFrameStandsWhereTheCaseEnds) {
  PlanOfRoom room;
  // The case ends at x = 9.9, the last square at 10.
  room.picture.shapes = {{PlanShape::Kind::kBorder, {0, 0}, {0, 6}},
                         {PlanShape::Kind::kBorder, {9.9, 0}, {9.9, 6}},
                         {PlanShape::Kind::kOpening, {0, 0}, {9.9, 0}},
                         {PlanShape::Kind::kOpening, {0, 6}, {9.9, 6}}};
  const Image image = drawPlan(room.plan, room.picture, {});
  EXPECT_TRUE((room.at(image, 10.003, 3) == 1).all()) << "no second line";
  EXPECT_LT(room.at(image, 9.9, 3).maxCoeff(), 0.02);
}

TEST(PlanPicture, transparentPartsOfAnUnderlayAreNotDrawn) {
  PlanOfRoom room;
  // Black all over, and opaque in the left half alone, as drawing programs save ink on nothing.
  Image picture(20, 12, 3), alpha(20, 12, 1);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 10; ++x) alpha.at(x, y) = 1;
  }
  layOnWhite(picture, alpha);
  EXPECT_EQ(picture.at(5, 6, 1), 0);
  EXPECT_EQ(picture.at(15, 6, 1), 1);
  room.picture.underlay =
      std::make_shared<const PlanUnderlay>(PlanUnderlay{picture, Vec2(0, 0), Vec2(10, 6), {}});
  const Image image = drawPlan(room.plan, room.picture, {});
  PlanOfRoom bare;
  const Image without = drawPlan(bare.plan, bare.picture, {});
  EXPECT_FALSE((room.at(image, 2.5, 3) == bare.at(without, 2.5, 3)).all());
  EXPECT_TRUE((room.at(image, 7.5, 3) == bare.at(without, 7.5, 3)).all());
}

TEST(PlanPicture, signsHaveTheirNamesAndPointWhereTheyFace) {
  PlanOfRoom room;
  SightTarget target;
  target.sign.name = "exit <1>";
  target.sign.position = Vec3(5, 3, 2);
  target.sign.normal = Vec3(1, 0, 0);
  const std::string svg = planSvg(room.plan, room.picture, {&target, 1});
  EXPECT_THAT(svg, HasSubstr(">exit &lt;1&gt;<"));
  // The arrow's tip, 20 pixels to the right of 92 + 5 / 0.25 x 22.
  EXPECT_THAT(svg, HasSubstr("points='552.00,326.00"));
}

TEST(PlanPicture, namesOfSignsAtOnePlaceStandBelowEachOther) {
  PlanOfRoom room;
  std::vector<SightTarget> targets(4);
  const char* names[] = {"exit", "exit left", "way out", "far"};
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].sign.name = names[i];
    targets[i].sign.position = Vec3(i == 3 ? 1 : 5, 3, 2);
    targets[i].sign.normal = Vec3(1, 0, 0);
  }
  const std::string svg = planSvg(room.plan, room.picture, targets);
  const auto rowOf = [&](const std::string& name) {
    const std::size_t text = svg.find(">" + name + "<");
    EXPECT_NE(text, std::string::npos) << name;
    return std::stod(svg.substr(svg.rfind(" y='", text) + 4));
  };
  const double first = rowOf("exit");
  EXPECT_EQ(rowOf("exit left"), first + kCanvasTextHeight + 6);
  EXPECT_EQ(rowOf("way out"), first - kCanvasTextHeight - 6);
  EXPECT_EQ(rowOf("far"), first) << "where there is room";
}

TEST(PlanPicture, labelsStandBesideWalls) {
  PlanOfRoom room;
  room.picture.barLabel.clear();
  room.picture.kinds = {{Rgb(0.9, 0.9, 0.6), ""}, {Rgb(0.6, 0.9, 0.9), ""}};
  for (std::size_t i = 0; i < room.plan.size(); ++i)
    room.picture.values[i] = room.plan.at(i).x() > 5 ? 1 : 0;
  // A wall through the middle of the room, and one behind its right half.
  room.picture.shapes = {{PlanShape::Kind::kSolid, {2.4, 0}, {2.6, 6}},
                         {PlanShape::Kind::kSolid, {5.0, 0}, {5.1, 6}}};
  room.picture.labels = {{Vec2(2.5, 3), "room 1"}};
  const std::string svg = planSvg(room.plan, room.picture, {});
  const std::size_t text = svg.find(">room 1<"), place = svg.rfind(" x='", text);
  const double x = (std::stod(svg.substr(place + 4)) - 92) / 22 * 0.25;
  const double half = 0.5 * canvasTextWidth("room 1") / 22 * 0.25;
  EXPECT_TRUE((x + half < 2.4 && x - half > 0) || (x - half > 2.6 && x + half < 5)) << x;
}

TEST(PlanPicture, northHasANeedleWhereItIsKnown) {
  PlanOfRoom room;
  EXPECT_EQ(planSvg(room.plan, room.picture, {}).find(">N<"), std::string::npos);
  // The needle is 40 pixels long and its middle 30 from the map's right end, 66 below it.
  const double x = 92 + 40 * 22 - 30, y = 62 + 24 * 22 + 66;
  for (const auto& [degrees, dx, dy] :
       {std::tuple(0.0, 0.0, -20.0), std::tuple(90.0, 20.0, 0.0), std::tuple(-90.0, -20.0, 0.0),
        std::tuple(180.0, 0.0, 20.0)}) {
    room.picture.north = degrees;
    const std::string svg = planSvg(room.plan, room.picture, {});
    EXPECT_THAT(svg, HasSubstr(">N<"));
    EXPECT_THAT(svg, HasSubstr(fmt::format("<polygon points='{:.2f},{:.2f} ", x + dx, y + dy)))
        << degrees;
  }
}

}  // namespace
}  // namespace volute
