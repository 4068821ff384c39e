// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/eyes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "volute/visibility/testing.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST(FloorPlan, HasPointsInTheMiddleOfSquares) {
  const auto plan = floorPlan(Room(0), Room::bounds(), 2, 0.5).value();
  ASSERT_EQ(plan.nx, 60);
  ASSERT_EQ(plan.ny, 20);
  EXPECT_EQ(plan.at(0), Vec3(0.25, 0.25, 2));
  EXPECT_EQ(plan.at(61), Vec3(0.75, 0.75, 2));
  int solid = 0;
  for (const Place place : plan.places) solid += place == Place::kSolid;
  EXPECT_EQ(solid, 2 * 12);
  EXPECT_TRUE(plan.walkable(0));
  EXPECT_FALSE(plan.walkable(10 * 60 + 40));
  EXPECT_EQ(floorPlan(Room(0), Room::bounds(), 5, 0.5).value().places[0], Place::kOutside);
  // The last squares reach beyond the bounds.
  EXPECT_EQ(floorPlan(Room(0), Room::bounds(), 2, 4).value().nx, 8);
  EXPECT_THAT(floorPlan(Room(0), Room::bounds(), 2, 1e-6).error().message,
              HasSubstr("larger step"));
}

TEST(Points, AreReadWithAndWithoutNames) {
  const auto plain = parsePoints("1,2,3\n# remark\n\n4, 5 ,6\r\n", "e.csv", {}).value();
  ASSERT_EQ(plain.size(), 2U);
  EXPECT_EQ(plain[1].position, Vec3(4, 5, 6));
  const auto named =
      parsePoints("\xEF\xBB\xBFroute,z [m],x,y\n\"A, no\",3,1,2\nA,3,1,2\n", "e.csv", {}).value();
  EXPECT_EQ(named[0].name, "A, no");
  EXPECT_EQ(named[0].position, Vec3(1, 2, 3));
  const auto columns = parsePoints("route;z [m];x;y\nA;3;1;2\n", "e.csv", {}).value();
  EXPECT_EQ(columns[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(columns[0].name, "A");
  const auto flat = parsePoints("x,y\n1,2\n", "e.csv", 1.8).value();
  EXPECT_EQ(flat[0].position, Vec3(1, 2, 1.8));
  EXPECT_EQ(parsePoints("1,2\n", "e.csv", 1.8).value()[0].position, Vec3(1, 2, 1.8));
}

TEST(Points, ColumnsThatAreMissingOrTooManyAreNamed) {
  const auto message = [](const char* text) {
    const auto points = parsePoints(text, "eyes.csv", 1.8);
    return points ? std::string() : points.error().message;
  };
  EXPECT_THAT(message("x,y,z,name\n1,2,3,a\n4,5,6\n"), HasSubstr("line 3: 3 columns; expected 4"));
  EXPECT_THAT(message("x,y,z\n1,2,3\n4,5,6,7\n"), HasSubstr("line 3: 4 columns; expected 3"));
  EXPECT_THAT(message("1,2,3,4\n"), HasSubstr("line 1: 4 columns without names"));
  EXPECT_THAT(message("1,2\n1,2,3\n"), HasSubstr("line 2: 3 columns; expected 2"));
  // Spreadsheets end lines in empty fields; columns that mean nothing here are marked.
  EXPECT_EQ(message("x,y,z\n1,2,3,,\n4,5,6\n"), "");
  EXPECT_EQ(message("x,y,z,#law\n1,2,3,\n4,5,6,Jin\n"), "");
  EXPECT_THAT(message("x,y,z,nam\n1,2,3,a\n"),
              HasSubstr("unknown column 'nam': did you mean 'name'?"));
  EXPECT_THAT(message("x,y,x\n1,2,3\n"), HasSubstr("two columns are called 'x'"));
}

TEST(Points, HaveTheUnitsOfTheirColumns) {
  const auto points = parsePoints("x [cm],y/mm,z (ft)\n150,2500,10\n", "e.csv", {}).value();
  EXPECT_NEAR((points[0].position - Vec3(1.5, 2.5, 3.048)).norm(), 0, 1e-12);
  EXPECT_THAT(parsePoints("x [s],y,z\n1,2,3\n", "e.csv", {}).error().message,
              HasSubstr("line 1: x is in 's'; expected m"));
}

TEST(Points, DamageIsNamedWithItsLine) {
  const auto message = [](const char* text) {
    return parsePoints(text, "eyes.csv", {}).error().message;
  };
  EXPECT_THAT(message("x,y,z\n1,2,3\n1,abc,3\n"), HasSubstr("eyes.csv: line 3: y is 'abc'"));
  EXPECT_THAT(message("1,2,3\n1,2\n"), HasSubstr("line 2: 2 columns; expected 3"));
  EXPECT_THAT(message("1,2\n"), HasSubstr("state the height of the eyes"));
  EXPECT_THAT(message("1,2,nan\n"), HasSubstr("line 1: z is 'nan'"));
  EXPECT_THAT(message("1,2,1e300\n"), HasSubstr("line 1: z is '1e300'"));
  EXPECT_THAT(message(""), HasSubstr("no point"));
  EXPECT_THAT(message("x,y,z\n"), HasSubstr("no point"));
}

TEST(Routes, HaveStationsFromStartToEnd) {
  const auto points =
      parsePoints("route,x,y,z\na,0,0,1\nb,9,9,9\na,3,0,1\nb,9,9,8\na,3,1,1\n", "r.csv", {})
          .value();
  const auto routes = routesOf(points, "r.csv").value();
  ASSERT_EQ(routes.size(), 2U);
  EXPECT_DOUBLE_EQ(routes[0].length(), 4);
  EXPECT_EQ(routes[0].at(3.5), Vec3(3, 0.5, 1));
  EXPECT_EQ(routes[0].at(-1), Vec3(0, 0, 1));
  EXPECT_EQ(routes[0].at(9), Vec3(3, 1, 1));
  const auto stations = stationsOf(routes[0], 0.7);
  EXPECT_EQ(stations.front(), 0);
  EXPECT_DOUBLE_EQ(stations.back(), 4);
  EXPECT_NE(std::ranges::find(stations, 3.0), stations.end()) << "corners are stations";
  for (std::size_t i = 1; i < stations.size(); ++i)
    EXPECT_LE(stations[i] - stations[i - 1], 0.7 + 1e-9);
  EXPECT_THAT(routesOf({{"x", Vec3(1, 1, 1)}}, "r.csv").error().message,
              HasSubstr("route 'x' has no length"));
}

auto says(const std::string& text) {
  return ::testing::Field(&Remark::sentence, HasSubstr(text));
}

TEST(Trajectories, AreReadAsJuPedSimWritesThem) {
  constexpr const char* kText =
      "#description: jpscore (0.9.6)\n#framerate: 8.00\n#ID: the agent ID\n"
      "#ID\tFR\tX\tY\tZ\tA\tB\tANGLE\tCOLOR\n"
      "6\t0\t4.20\t3.33\t0.00\t0.18\t0.25\t-90.00\t0\n"
      "6\t8\t5.20\t3.33\t0.00\t0.18\t0.25\t-90.00\t0\n"
      "7\t8\t1.00\t1.00\t0.00\t0.18\t0.25\t-90.00\t0\n";
  const auto walk = Trajectories::parse(kText, "t.txt", 1.8).value();
  EXPECT_EQ(walk.people(), 2);
  EXPECT_EQ(walk.end(), 1);
  const auto half = walk.at(0.5);
  ASSERT_EQ(half.size(), 1U);
  EXPECT_EQ(half[0].id, 6);
  EXPECT_NEAR((half[0].eye - Vec3(4.7, 3.33, 1.8)).norm(), 0, 1e-12);
  EXPECT_EQ(walk.at(1).size(), 2U);
  EXPECT_TRUE(walk.at(1.01).empty());
  const auto measured =
      Trajectories::parse(
          "# grid from left to right\n# framerate: 2\n# PersID Frame X[in cm] Y[in cm] "
          "Z[in cm] more\n1 2 100 200 176\n",
          "t.txt", {})
          .value();
  EXPECT_NEAR((measured.at(1)[0].eye - Vec3(1, 2, 1.76)).norm(), 0, 1e-12);
  const auto centimetres =
      Trajectories::parse("# framerate: 25 fps\n#ID frame x/cm y/cm z/cm\n1 0 100 200 176\n",
                          "t.txt", {})
          .value();
  EXPECT_NEAR((centimetres.at(0)[0].eye - Vec3(1, 2, 1.76)).norm(), 0, 1e-12) << "heads, measured";
  for (const char* text : {"#framerate: 2\n#frame id x y z\n2 7 1 2 0\n",
                           "#framerate: 2\n#FRAME, X, Y, Z, ID\n2,1,2,0,7\n"}) {
    const auto ordered = Trajectories::parse(text, "t.txt", 1.8).value();
    ASSERT_EQ(ordered.at(1).size(), 1U) << text;
    EXPECT_EQ(ordered.at(1)[0].id, 7);
    EXPECT_NEAR((ordered.at(1)[0].eye - Vec3(1, 2, 1.8)).norm(), 0, 1e-12);
  }
  const auto flat = Trajectories::parse(
                        "# framerate: 25\n#ID\tFR\tX/cm\tY/cm\tZ/cm\n1 0 100 200 0\n", "t.txt", {})
                        .value();
  EXPECT_NEAR((flat.at(0)[0].eye - Vec3(1, 2, 1.8)).norm(), 0, 1e-12) << "nobody's head";
  EXPECT_THAT(flat.remarks(), Contains(says("z is the floor there")));
  const auto floor = Trajectories::parse(kText, "t.txt", {}).value();
  EXPECT_NEAR(floor.at(0)[0].eye[2], 1.8, 1e-12);
  EXPECT_THAT(floor.remarks(), Contains(says("z is the floor there: eyes are 1.8 m")));
}

TEST(Trajectories, AreReadAsPathfinderWritesThem) {
  constexpr const char* kText =
      "\"t\",\"id\",\"name\",\"active\",\"x\",\"y\",\"z\",\"v\",\"distance\",\"location\"\n"
      "\"s\",\"\",\"\",\"\",\"m\",\"m\",\"m\",\"m/s\",\"m\",\"\"\n"
      "0,3,\"00003\",0,0,0,0,0,0,\"Floor 3.0 m\"\n"
      "1,3,\"00003\",1,1,2,3,0.5,0,\"Floor 3.0 m\"\n"
      "2,3,\"00003\",1,2,2,3,0.5,1,\"Floor 3.0 m\"\n"
      "3,3,\"00003\",0,9,9,0,0,1,\"\"\n";
  const auto walk = Trajectories::parse(kText, "occupants.csv", {}).value();
  EXPECT_EQ(walk.begin(), 1) << "before, the person is not there";
  EXPECT_EQ(walk.end(), 2);
  EXPECT_NEAR((walk.at(1.5)[0].eye - Vec3(1.5, 2, 4.8)).norm(), 0, 1e-12);
  EXPECT_THAT(walk.remarks(), Contains(says("z is the floor there: eyes are 1.8 m above it")));
  EXPECT_THAT(walk.remarks(), Contains(says("not used of its columns: v, distance")));
  EXPECT_EQ(Trajectories::parse(kText, "o.csv", {}, 1.2)->at(1)[0].eye[2], 4.2);
  const auto level = Trajectories::parse(kText, "o.csv", 2.5).value();
  EXPECT_EQ(level.at(1)[0].eye[2], 2.5);
  EXPECT_THAT(level.remarks(),
              Contains(says("o.csv: its z is not used: all eyes are at z = 2.5 m")));
  // Without ids; time goes back for the first person.
  const auto named =
      Trajectories::parse("t,name,active,x,y,z\n2,Ann,1,1,2,0\n1,Bob,1,5,2,0\n1,Ann,1,3,2,0\n",
                          "o.csv", {})
          .value();
  EXPECT_EQ(named.people(), 2);
  EXPECT_EQ(named.at(1)[0].eye.x(), 3);
  EXPECT_EQ(named.at(1)[1].eye.x(), 5);
  EXPECT_THAT(named.remarks(), Contains(says("people are numbered from 1")));
  EXPECT_THAT(named.remarks(), Contains(says("o.csv: line 4: time goes back there")));
  EXPECT_EQ(named.outside([](double z) { return z > 2; }), 2U);
}

TEST(Trajectories, OfATableAreEyesOrStandOnFloors) {
  const auto eyes =
      Trajectories::parse("id,time/min,x [cm],y,z\n1,0,100,2,1.7\n1,0.5,500,2,1.7\n", "t.csv", {})
          .value();
  EXPECT_EQ(eyes.end(), 30);
  EXPECT_EQ(eyes.at(30)[0].eye, Vec3(5, 2, 1.7));
  EXPECT_TRUE(eyes.remarks().empty());
  const auto floors =
      Trajectories::parse("id,t,x,y,floor,eye_height\n1,0,1,2,3,1.1\n", "t.csv", {}).value();
  EXPECT_EQ(floors.at(0)[0].eye, Vec3(1, 2, 4.1)) << "somebody in a wheelchair";
  EXPECT_FALSE(floors.areAboveFloors());
  EXPECT_THAT(
      floors.remarks(),
      ::testing::ElementsAre(says("floor is the floor there: eyes are as far as eye_height says")));
  EXPECT_THAT(Trajectories::parse("id,t,x,y\n1,0,1,2\n", "t.csv", {}).error().message,
              HasSubstr("the height of the eyes stated"));
}

TEST(Trajectories, ColumnsThatAreNotUsedAreTold) {
  const auto leftOut = [](const char* text, std::optional<double> height = {}) {
    const auto walk = Trajectories::parse(text, "t.csv", height).value();
    std::string sentences;
    for (const Remark& remark : walk.remarks())
      sentences += remark.code == RemarkCode::kLeftOut ? remark.sentence + "\n" : "";
    return sentences;
  };
  EXPECT_THAT(leftOut("id,t,x,y,z,floor\n1,0,1,2,1.2,0\n"), HasSubstr("its z is not used: floor"));
  EXPECT_THAT(leftOut("id,t,x,y,z,eye_height\n1,0,1,2,1.2,1\n"),
              HasSubstr("its eye_height is not used: z is that of the eyes"));
  EXPECT_THAT(leftOut("id,t,x,y,eye_height\n1,0,1,2,1\n", 2), HasSubstr("its eye_height is not"));
  EXPECT_THAT(leftOut("id,t,x,y,floor\n1,0,1,2,1\n", 2), HasSubstr("its floor is not used"));
  EXPECT_THAT(leftOut("id,t,x,y,z,colour\n1,0,1,2,1,red\n"), HasSubstr("colour"));
  EXPECT_EQ(leftOut("id,t,x,y,z,active,v,distance\n1,0,1,2,1,1,0,0\n"), "");
}

TEST(Trajectories, WhoIsThereAndWhoItIsMustBeClear) {
  const auto active = [](const std::string& word) {
    return Trajectories::parse("id,t,x,y,z,active\n1,0,1,2,0,1\n1,1,1,2,0," + word + "\n", "t.csv",
                               {});
  };
  for (const char* word : {"1", "true", "Yes", "1.0"}) EXPECT_EQ(active(word)->end(), 1) << word;
  for (const char* word : {"0", "FALSE", "no"}) EXPECT_EQ(active(word)->end(), 0) << word;
  for (const char* word : {"f", "", "2"})
    EXPECT_THAT(active(word).error().message, HasSubstr("line 3: active is '")) << word;
  EXPECT_THAT(Trajectories::parse("id,name,t,x,y,z\n1,Ann,0,1,2,1\n1,Bob,1,1,2,1\n", "t.csv", {})
                  .error()
                  .message,
              HasSubstr("line 3: person 1 is called 'Bob', and 'Ann' before"));
}

TEST(Trajectories, DamageIsNamed) {
  const auto message = [](const char* text) {
    return Trajectories::parse(text, "t.txt", 1.8).error().message;
  };
  EXPECT_THAT(message("1 0 1 1 0\n"), HasSubstr("t.txt: no frame rate"));
  EXPECT_THAT(message("#framerate: 125 ms\n1 0 1 1 0\n"), HasSubstr("t.txt: no frame rate"));
  EXPECT_THAT(message("#framerate: 8\n1 0 1\n"), HasSubstr("t.txt: line 2"));
  EXPECT_THAT(message("#framerate: 8\n1 0.5 1 1 0\n"), HasSubstr("line 2"));
  EXPECT_THAT(message("#framerate: 8\n"), HasSubstr("nobody"));
  EXPECT_THAT(message("#framerate: 8\n#framerate: 9\n1 0 1 1 0\n"),
              HasSubstr("line 2: a second frame rate, 9 after 8"));
  EXPECT_THAT(message("#framerate: 8\n1 0 1 1 0\n1 0 2 1 0\n"),
              HasSubstr("line 3: person 1 is at two places at once"));
  EXPECT_THAT(message("id,time,x,y,z\n1,0,1,1,0\n1,0,2,1,0\n"), HasSubstr("two places at once"));
  EXPECT_THAT(message("id,time [km],x,y,z\n1,0,1,1,0\n"), HasSubstr("time is in 'km'"));
  EXPECT_THAT(message("#framerate: 8\n1 0 1 1 0 0.2\n1 1 1 1 0\n"),
              HasSubstr("line 3: 5 columns; expected 6"));
}

TEST(Trajectories, NobodyRunsAThousandTimesTooFast) {
  const auto walk = [](double scale) {
    std::string text = "#framerate: 8\n";
    for (int frame = 0; frame < 20; ++frame)
      text += fmt::format("1 {} {} 2 0\n2 {} 3 4 0\n", frame, scale * frame * 0.16, frame);
    text += "2 20 30 4 0\n";  // one jump of one person
    return Trajectories::parse(text, "t.txt", 1.8);
  };
  EXPECT_THAT(walk(1000).error().message, HasSubstr("expected places in metres"));
  ASSERT_TRUE(walk(1));
  EXPECT_THAT(walk(1)->remarks(), ::testing::Not(Contains(says("people move"))));
  const auto slow = Trajectories::parse("#framerate: 8\n1 0 0 0 0\n1 8 0.001 0 0\n", "t.txt", 1.8);
  ASSERT_TRUE(slow);
  EXPECT_THAT(slow->remarks(), Contains(says("people move at 0.001 m/s")));
}

/// Calls check for a text with every bit flipped once, and for every beginning of it.
template <class Check>
void forEachDamage(const std::string& text, Check&& check) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    check(text.substr(0, i));
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      check(damaged);
    }
  }
}

TEST(Damage, NoFlippedBitGivesAPlaceThatIsNone) {
  int read = 0, refused = 0;
  const auto count = [&](const auto& result) { ++(result ? read : refused); };
  forEachDamage("route,x,y,z\na,1.5,2,-3e1\na,4,5.25,6\n", [&](const std::string& text) {
    const auto points = parsePoints(text, "d.csv", 1.8);
    count(points);
    if (!points)
      return;
    for (const NamedPoint& point : *points) ASSERT_TRUE(point.position.allFinite());
    if (const auto routes = routesOf(*points, "d.csv")) {
      ASSERT_GT((*routes)[0].length(), 0);
    }
  });
  forEachDamage("#framerate: 8.00\n#ID frame x/m y/m z/m\n1 0 1.5 2 0\n1 8 3 4 0\n",
                [&](const std::string& text) {
                  const auto people = Trajectories::parse(text, "d.txt", {});
                  count(people);
                  if (!people)
                    return;
                  for (const double time : {0.0, 0.5, 1.0, people->end()}) {
                    for (const auto& person : people->at(time)) ASSERT_TRUE(person.eye.allFinite());
                  }
                });
  EXPECT_GT(read, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace volute
