// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/base/write_file.hpp"
#include "volute/io/testing.hpp"
#include "volute/visibility/area_file.hpp"
#include "volute/visibility/rooms.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using testing::TempFolder;

/// A building of walls, which may be thin, and of doors that are open at the first time.
class Building final : public BasicSightSnapshot {
 public:
  explicit Building(std::vector<PlanShape> shapes) : shapes_(std::move(shapes)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      sights[i] = {};
      for (const PlanShape& wall : shapes_) {
        if (wall.kind == PlanShape::Kind::kSolid)
          sights[i].blocked |= crosses(wall, lines[i]);
      }
    }
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec2 at = points[i].head<2>();
      places[i] = Place::kGas;
      for (const PlanShape& wall : shapes_) {
        if (wall.kind == PlanShape::Kind::kSolid && (at - wall.min).minCoeff() > 0 &&
            (wall.max - at).minCoeff() > 0)
          places[i] = Place::kSolid;
      }
    }
  }

  std::vector<PlanShape> shapes(double) const override { return shapes_; }

  void extinction(std::span<const Vec3>, std::span<double> out) const override {
    std::ranges::fill(out, 0.0);
  }

 private:
  static bool crosses(const PlanShape& wall, const SightLine& line) {
    double begin = 0, end = 1;
    for (int axis = 0; axis < 2; ++axis) {
      const double from = line.eye[axis], along = line.target[axis] - from;
      if (along == 0) {
        if (from < wall.min[axis] || from > wall.max[axis])
          return false;
        continue;
      }
      const double a = (wall.min[axis] - from) / along, b = (wall.max[axis] - from) / along;
      begin = std::max(begin, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    return begin <= end;
  }

  std::vector<PlanShape> shapes_;
};

PlanShape wall(double x0, double y0, double x1, double y1,
               PlanShape::Kind kind = PlanShape::Kind::kSolid) {
  return {kind, Vec2(x0, y0), Vec2(x1, y1)};
}

Rooms roomsOf(const std::vector<PlanShape>& shapes, double x = 20, double y = 10) {
  return findRooms(Building(shapes), {Vec3(0, 0, 0), Vec3(x, y, 3)}, 1.8);
}

TEST(Rooms, AnOpenHallIsOneWithOrWithoutColumns) {
  EXPECT_EQ(roomsOf({}).rooms.size(), 1U);
  std::vector<PlanShape> columns;
  for (int x = 0; x < 3; ++x) columns.push_back(wall(4.8 + 5 * x, 4.8, 5.2 + 5 * x, 5.2));
  const Rooms hall = roomsOf(columns);
  ASSERT_EQ(hall.rooms.size(), 1U);
  EXPECT_NEAR(hall.rooms[0].area, 199.5, 4);
  EXPECT_FALSE(hall.rooms[0].outside);
}

TEST(Rooms, DoorsOfThickAndThinWallsDivide) {
  for (const double thick : {0.0, 0.3}) {
    const Rooms two = roomsOf({wall(8, 0, 8 + thick, 4), wall(8, 4.9, 8 + thick, 10)});
    ASSERT_EQ(two.rooms.size(), 2U) << thick;
    EXPECT_NEAR(two.rooms[0].area, 80, 3);
    EXPECT_NEAR(two.rooms[1].area, 120 - 10 * thick, 3);
    ASSERT_EQ(two.doors.size(), 1U);
    EXPECT_NEAR(two.doors[0].width, 0.9, 0.21);
    EXPECT_NEAR(two.doors[0].place.x(), 8 + thick / 2, 0.4);
    EXPECT_NEAR(two.doors[0].place.y(), 4.45, 0.3);
    EXPECT_EQ(two.at(Vec2(3, 5), 0.2), 0);
    EXPECT_EQ(two.at(Vec2(15, 5), 0.2), 1);
    EXPECT_EQ(two.at(Vec2(25, 5), 0.2), -1);
  }
}

TEST(Rooms, ACorridorIsARoomAndSoIsAHallBehindAWideOpening) {
  // Two offices above a corridor of 1.5 m, with doors of .9 m.
  const Rooms offices = roomsOf({wall(0, 1.5, 4, 1.6), wall(4.9, 1.5, 14, 1.6),
                                 wall(14.9, 1.5, 20, 1.6), wall(10, 1.6, 10.1, 10)});
  EXPECT_EQ(offices.rooms.size(), 3U);
  EXPECT_EQ(offices.doors.size(), 2U);
  // Halls of 10 x 10 m with 3 m of the wall between them open.
  EXPECT_EQ(roomsOf({wall(10, 0, 10.2, 3.5), wall(10, 6.5, 10.2, 10)}).rooms.size(), 2U);
  // And with 8 m of it.
  EXPECT_EQ(roomsOf({wall(10, 0, 10.2, 1), wall(10, 9, 10.2, 10)}).rooms.size(), 1U);
}

TEST(Rooms, ADoorThatIsShutLaterDividesAndSmallNichesDoNot) {
  const auto later = wall(8, 2, 8, 8, PlanShape::Kind::kDoor);
  const Rooms two = roomsOf(
      {wall(8, 0, 8, 2), wall(8, 8, 8, 10), later, wall(20, 0, 20, 10, PlanShape::Kind::kOpening)});
  ASSERT_EQ(two.rooms.size(), 2U);
  ASSERT_EQ(two.doors.size(), 1U);
  EXPECT_TRUE(two.doors[0].shut);
  EXPECT_EQ(two.doors[0].width, 6);
  EXPECT_FALSE(two.rooms[0].outside);
  EXPECT_TRUE(two.rooms[1].outside);
  // A cupboard of .8 x .8 m with a gap of .4 m.
  EXPECT_EQ(roomsOf({wall(0, .8, .4, .9), wall(.8, 0, .9, .9)}).rooms.size(), 1U);
}

std::vector<Vec2> square(double x, double y, double size) {
  return {Vec2(x, y), Vec2(x + size, y), Vec2(x + size, y + size), Vec2(x, y + size)};
}

TEST(Areas, OverlapByMoreThanACentimetre) {
  const auto one = square(0, 0, 2);
  EXPECT_FALSE(overlap(one, square(2, 0, 2)));
  EXPECT_FALSE(overlap(one, square(1.995, 0, 2))) << "drawn 5 mm over";
  EXPECT_FALSE(overlap(one, square(2, 2, 2))) << "a corner";
  EXPECT_TRUE(overlap(one, square(1.9, 0, 2)));
  EXPECT_TRUE(overlap(one, square(1.5, 1.5, 2)));
  EXPECT_TRUE(overlap(one, square(.5, .5, 1))) << "inside";
  EXPECT_TRUE(overlap(one, one)) << "the same";
  const std::vector<Vec2> bar{Vec2(-1, 1), Vec2(3, 1), Vec2(3, 1.2), Vec2(-1, 1.2)};
  EXPECT_TRUE(overlap(one, bar)) << "a cross";
}

class AreaFile : public ::testing::Test {
 protected:
  Result<std::vector<NamedArea>> read(const std::string& text) {
    EXPECT_TRUE(writeFile(folder_ / "areas.json", text));
    return readAreas((folder_ / "areas.json").string());
  }

  std::string error(const std::string& text) {
    const auto areas = read(text);
    return areas ? "" : areas.error().message;
  }

  TempFolder folder_;
};

constexpr const char* kOffice = R"({"name": "office", "polygon": [[0,0],[4,0],[4,3],[0,3]])";

TEST_F(AreaFile, HasStoreysAreasExitsAndRoutes) {
  ASSERT_VALUE(const auto areas, read(fmt::format(
                                     R"({{"storeys": [{{"name": "first", "z": [3, 6]}}],
      "areas": [{}, "storey": "first", "rset": 60, "people": false}}],
      "exits": [{{"name": "door", "line": [[4,1],[4,2]], "radius": 0.5}}],
      "routes": [{{"name": "way", "areas": ["office", "door"]}}, {{"name": "line", "line": [[0,0],[9,0]]}}]}})",
                                     kOffice)));
  ASSERT_EQ(areas.size(), 4U);
  EXPECT_TRUE(areas[0].isAt(4.8));
  EXPECT_FALSE(areas[0].isAt(1.8));
  EXPECT_EQ(areas[0].rset, 60);
  EXPECT_FALSE(areas[0].people);
  EXPECT_TRUE(areas[0].contains(Vec2(2, 2)));
  EXPECT_FALSE(areas[0].contains(Vec2(5, 2)));
  EXPECT_TRUE(areas[1].contains(Vec2(4.4, 1.5)));
  EXPECT_FALSE(areas[1].contains(Vec2(4.6, 1.5)));
  EXPECT_TRUE(areas[3].contains(Vec2(5, .6)));
  EXPECT_FALSE(areas[3].contains(Vec2(5, .7)));
  EXPECT_TRUE(checkStoreys(areas, std::vector{1.8, 4.8}, "areas.json"));
  EXPECT_THAT(checkStoreys(areas, std::vector{1.8}, "areas.json").error().message,
              HasSubstr("'office' is on the storey 'first', z = 3 to 6 m, and no plan is made "
                        "there: the eyes are at 1.8 m"));
}

TEST_F(AreaFile, RefusesWhatContradictsItself) {
  const auto areas = [](const std::string& list) { return "{\"areas\": [" + list + "]}"; };
  const std::string office = std::string(kOffice) + "}";
  EXPECT_THAT(error(areas(office + ", " + office)),
              HasSubstr("/areas/1: 'office' is the name of "));
  EXPECT_THAT(error(areas(office + R"(, {"name": "b", "polygon": [[3,1],[6,1],[6,2]]})")),
              HasSubstr("/areas/0), at x = "));
  EXPECT_THAT(error(R"({"areas": [)" + office +
                    R"(], "routes": [{"name": "r", "areas": ["office"], "width": 7}]})"),
              HasSubstr("/routes/0/width: has no effect on a route of areas"));
  EXPECT_THAT(error(areas(R"({"name": "b", "polygon": [[0,0],[2,2],[2,0],[0,2]]})")),
              HasSubstr("/areas/0/polygon: crosses itself at x = 1, y = 1 m"));
  EXPECT_THAT(error(areas(R"({"name": "b", "polygon": [[0,0],[2,2],[4,4]]})")),
              HasSubstr("/areas/0/polygon: has no area"));
  EXPECT_THAT(error(areas(R"({"name": "b", "poligon": []})")),
              HasSubstr("did you mean 'polygon'?"));
  EXPECT_THAT(error(areas(std::string(kOffice) + R"(, "storey": "x"})")),
              HasSubstr("there is no storey 'x' in /storeys"));
  EXPECT_THAT(error(areas(std::string(kOffice) + R"(, "rset": -1})")),
              HasSubstr("/areas/0/rset: -1; expected 0 or more"));
  EXPECT_THAT(error(R"({"routes": [{"name": "r", "areas": ["x"]}]})"),
              HasSubstr("/routes/0: there is no area or exit 'x'"));
  EXPECT_THAT(error("{}"), HasSubstr("names no area, route or exit"));
  EXPECT_THAT(error(R"({"storeys": [{"name": "a", "z": [0, 3]}, {"name": "b", "z": [2, 5]}]})"),
              HasSubstr("/storeys/1/z: storey 'b' overlaps storey 'a'"));
  // On two storeys they may be above each other.
  EXPECT_EQ(
      error(R"({"storeys": [{"name": "a", "z": [0, 3]}, {"name": "b", "z": [3, 6]}], "areas": [)" +
            std::string(kOffice) + R"(, "storey": "a"},)" +
            R"({"name": "above", "storey": "b", "polygon": [[0,0],[4,0],[4,3]]}]})"),
      "");
}

}  // namespace
}  // namespace volute
