// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "volute/visibility/rset.hpp"
#include "volute/visibility/sight_engine.hpp"
#include "volute/visibility/testing.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;

/// Stored every 10 s: `value(time, place)`; known for x >= 0.
class Formula final : public PointField {
 public:
  using Value = double (*)(double, const Vec3&);

  /// @param end  the last stored time [s]
  explicit Formula(Value value, double end = 2000) : value_(value) {
    for (int i = 0; 10.0 * i <= end; ++i) times_.push_back(10.0 * i);
  }

  std::string description() const override { return "a formula"; }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    const auto known = storedPlace(times_, time);
    const double t = std::clamp(time, times_.front(), times_.back());
    const double first = 10 * std::floor(t / 10), share = (t - first) / 10;
    for (std::size_t i = 0; i < points.size(); ++i) {
      out[i] = points[i][0] < 0 || !known
                   ? std::nan("")
                   : (1 - share) * value_(first, points[i]) + share * value_(first + 10, points[i]);
    }
    return {};
  }

 private:
  Value value_;
  std::vector<double> times_;
};

/// A room whose smoke grows by 0.01 1/m each second, with gases.
class BurningRoom final : public SightField {
 public:
  /// @param end  of what is stored of carbon dioxide and of the temperature [s]
  explicit BurningRoom(double end = 2000) : end_(end) {}

  std::string description() const override { return "a room"; }

  std::span<const double> times() const override { return times_; }

  Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override {
    if (quantity == "carbon-monoxide")
      return std::make_unique<Formula>([](double, const Vec3&) { return 0.001; });
    if (quantity == "carbon-dioxide")
      return std::make_unique<Formula>([](double, const Vec3&) { return 0.02; }, end_);
    if (quantity == "oxygen")
      return std::make_unique<Formula>([](double, const Vec3&) { return 0.15; });
    if (quantity == "temperature")
      return std::make_unique<Formula>([](double t, const Vec3& p) { return 20 + t * p[0] / 100; },
                                       end_);
    return fail(ErrorCode::kNotFound, "no {} here", quantity);
  }

 protected:
  Box3 ownBounds() const override { return Room::bounds(); }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    return std::make_shared<const Room>(0.01 * times_[time]);
  }

 private:
  double end_;
  std::vector<double> times_{0, 10, 20, 30, 40};
};

Criterion fdsDose(double limit) {
  return {.name = "fed", .law = DoseLaw::kFdsGas, .person = {}, .limit = limit, .source = "test"};
}

Criterion hot(double limit) {
  return {.name = "hot",
          .law = {},
          .quantity = Air::kTemperature,
          .person = {},
          .limit = limit,
          .source = "test"};
}

ExposureMeter::Places standing(std::vector<Vec3> places) {
  return [places](double, std::span<Vec3> out) { std::ranges::copy(places, out.begin()); };
}

// pyFDS-Evac's worked example, through the meter: FED reaches 1 at 981.7 s.
TEST(ExposureMeter, ReachesADoseWhenTheClosedFormDoes) {
  BurningRoom room;
  const std::vector criteria{fdsDose(1), hot(60)};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 2);
  const auto places = standing({Vec3(10, 1, 1), Vec3(20, 1, 1)});
  for (int t = 0; t <= 1200; t += 400) ASSERT_TRUE(meter.advance(t, places));
  Exposure air;
  air[Air::kCarbonMonoxide] = 0.001;
  air[Air::kCarbonDioxide] = 0.02;
  air[Air::kOxygen] = 0.15;
  const double rate = doseRate(DoseLaw::kFdsGas, {}, air);
  EXPECT_NEAR(meter.values(0)[0], 1200 * rate, 1e-9);
  EXPECT_NEAR(meter.times(0).none[0], 1 / rate, 1e-6 / rate);
  EXPECT_NEAR(meter.times(0).none[0], 981.7, 0.05);
  EXPECT_NEAR(meter.times(0).down[0], 980, 1e-9);
  EXPECT_NEAR(meter.times(0).up[0], 990, 1e-9);
  // 20 + t x / 100 = 60 degrees C.
  EXPECT_NEAR(meter.times(1).none[0], 400, 1e-9);
  EXPECT_NEAR(meter.times(1).none[1], 200, 1e-9);
}

// Who is there from 3.1 s to 7.6 s, at a rate that does not change.
TEST(ExposureMeter, DosesEndWhereSomebodyGoes) {
  BurningRoom room;
  const std::vector criteria{fdsDose(1)};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 2);
  const auto places = [](double time, std::span<Vec3> out) {
    out[0] = Vec3(10, 1, 1);
    out[1] = time < 3.1 || time > 7.6 ? Vec3::Constant(std::nan("")) : Vec3(10, 1, 1);
  };
  const std::vector<ExposureMeter::Turn> turns{{3.1, 1}, {7.6, 1}};
  for (const double t : {0, 10, 20}) ASSERT_TRUE(meter.advance(t, places, {}, 0.5, nullptr, turns));
  EXPECT_NEAR(meter.values(0)[1] / meter.values(0)[0], 4.5 / 20, 1e-9);
  EXPECT_FALSE(meter.unknown(0, 1));
}

TEST(ExposureMeter, SaysWhatIsMissingAssumedOrUnknown) {
  BurningRoom room;
  Criterion irritants{
      .name = "fec", .law = DoseLaw::kIsoIrritants, .person = {}, .limit = 0.3, .source = "test"};
  const std::vector criteria{fdsDose(1), irritants};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 2);
  ASSERT_EQ(meter.criteria().size(), 1U);
  ASSERT_EQ(meter.missing().size(), 1U);
  EXPECT_THAT(meter.missing()[0].why, HasSubstr("no hydrogen-chloride here"));
  EXPECT_FALSE(meter.assumed(0).empty());
  ASSERT_TRUE(meter.advance(0, standing({Vec3(1, 1, 1), Vec3(-1, 1, 1)})));
  ASSERT_TRUE(meter.advance(100, standing({Vec3(1, 1, 1), Vec3(-1, 1, 1)})));
  EXPECT_FALSE(meter.unknown(0, 0));
  EXPECT_TRUE(meter.unknown(0, 1));
}

TEST(ExposureMeter, NothingIsExtendedBeyondItsData) {
  BurningRoom room(300);
  const std::vector criteria{fdsDose(1), hot(60)};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 2);
  const auto places = standing({Vec3(10, 1, 1), Vec3(20, 1, 1)});
  for (int t = 0; t <= 2000; t += 400) ASSERT_TRUE(meter.advance(t, places));
  // 20 + t x / 100 = 60 at 400 s, which is not stored, and at 200 s, which is.
  EXPECT_EQ(meter.times(1).known[0], 300);
  EXPECT_EQ(meter.times(1).none[0], std::numeric_limits<double>::infinity());
  EXPECT_TRUE(meter.times(1).complete(1));
  EXPECT_NEAR(meter.times(1).none[1], 200, 1e-9);
  // Without carbon dioxide, which is stored, but not any more, the dose is a lower bound.
  EXPECT_TRUE(meter.unknown(0, 0));
  EXPECT_EQ(meter.times(0).known[0], 300);
  EXPECT_GT(meter.times(0).up[0], 981.7);  // at the latest
}

TEST(ExposureMeter, ALossIsBetweenTheStoredTimesAroundIt) {
  BurningRoom room;
  const std::vector criteria{hot(60)};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 1);
  for (double t = 0; t <= 500; t += 2.5)
    ASSERT_TRUE(meter.advance(t, standing({Vec3(10.1, 1, 1)})));
  EXPECT_NEAR(meter.times(0).none[0], 4000 / 10.1, 1e-6);  // 396.04
  EXPECT_EQ(meter.times(0).down[0], 390);
  EXPECT_EQ(meter.times(0).up[0], 400);
}

/// Temperature along a way: 1 m/s from x = 0 on, T = 20 + t x / 100.
TEST(ExposureMeter, FollowsPeopleWhoWalk) {
  BurningRoom room;
  const std::vector criteria{hot(21)};
  ExposureMeter meter(AirField::open(room, criteria), criteria, 1);
  const auto walking = [](double time, std::span<Vec3> out) {
    out[0] = time > 25 ? Vec3::Constant(std::nan("")) : Vec3(time, 1, 1);
  };
  for (int t = 0; t <= 40; t += 20) ASSERT_TRUE(meter.advance(t, walking, {}, 0.01));
  EXPECT_NEAR(meter.times(0).none[0], 10, 1e-3);  // t^2 / 100 = 1
}

/// A burning room with a sign in its east.
SightEngine engineInTheRoom() {
  std::vector<SafetySign> signs{{.name = "east",
                                 .position = Vec3(30, 2, 2),
                                 .normal = Vec3(-1, 0, 0),
                                 .law = visibilityLaw("jin-reflecting").value(),
                                 .angle = {}}};
  Progress quiet;
  return SightEngine::open(std::make_shared<BurningRoom>(), signs, std::vector{fdsDose(1)}, quiet)
      .value();
}

TEST(SightEngine, SeesBetweenStoredTimesWhatTheClosedFormDoes) {
  SightEngine engine = engineInTheRoom();
  const std::vector<Vec3> eyes{Vec3(10, 2, 2), Vec3(10, 9, 2), Vec3(25, 2, 2)};
  std::vector<Seen> seen(3);
  // Depths of 0.8 to 1.2 times K d; C = 3.
  for (const double t : {0.0, 5.0, 12.4, 12.6, 15.0, 18.6, 18.9, 25.0, 100.0}) {
    ASSERT_TRUE(engine.sees(eyes, t, seen));
    const double depth = 0.01 * t * 20;
    if (t > 41) {  // nothing is stored any more
      EXPECT_THAT(seen, ::testing::Each(Seen::kCannotTell));
      std::vector<double> k(3);
      ASSERT_TRUE(engine.extinction(eyes, t, k));
      EXPECT_TRUE(std::isnan(k[0]));
      continue;
    }
    EXPECT_EQ(seen[0], 1.2 * depth <= 3   ? Seen::kYes
                       : 0.8 * depth <= 3 ? Seen::kCannotTell
                                          : Seen::kNo)
        << t;
    EXPECT_EQ(seen[1], Seen::kNo);  // the wall
    EXPECT_EQ(seen[2], Seen::kYes);
  }
}

TEST(SightEngine, DosesGoOnWithThePerson) {
  SightEngine engine = engineInTheRoom();
  ASSERT_EQ(engine.criteria().size(), 1U);
  std::vector<double> dose(2);
  const std::vector<Vec3> eyes{Vec3(10, 2, 2), Vec3(11, 2, 2)};
  for (int t = 0; t <= 60; ++t)
    ASSERT_TRUE(engine.dose(std::vector<std::int64_t>{7, 9}, eyes, t, dose));
  EXPECT_NEAR(dose[0], 60 / 981.69, 1e-5);
  std::vector<double> one(1);
  ASSERT_TRUE(engine.dose(std::vector<std::int64_t>{9}, std::span(eyes).last(1), 61, one));
  EXPECT_NEAR(one[0], 61 / 981.69, 1e-5);
  // 7 was away for a second.
  ASSERT_TRUE(engine.dose(std::vector<std::int64_t>{7, 9}, eyes, 62, dose));
  EXPECT_NEAR(dose[0], 60 / 981.69, 1e-5);
  EXPECT_NEAR(dose[1], 62 / 981.69, 1e-5);
}

/// Carbon monoxide that is a mean of up to twice as much.
class MeanOfTwo final : public PointField {
 public:
  std::string description() const override { return "means"; }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  Status answer(double, std::span<const Vec3>, std::span<PointValue> out) override {
    for (PointValue& one : out) one = {0.001, 0, 0.002, {0, 2000}};
    return {};
  }

  bool isExact() const override { return false; }

 private:
  std::vector<double> times_{0, 2000};
};

class RoomOfMeans final : public SightField {
 public:
  explicit RoomOfMeans(bool means) : means_(means) {}

  std::string description() const override { return "a room"; }

  std::span<const double> times() const override { return times_; }

  Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override {
    if (quantity != "carbon-monoxide")
      return fail(ErrorCode::kNotFound, "no {} here", quantity);
    if (means_)
      return std::make_unique<MeanOfTwo>();
    return std::make_unique<Formula>([](double, const Vec3&) { return 0.002; });
  }

 protected:
  Box3 ownBounds() const override { return Room::bounds(); }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t) override {
    return std::make_shared<const Room>(0.1);
  }

 private:
  bool means_;
  std::vector<double> times_{0, 2000};
};

TEST(SightEngine, TheWorstDoseIsThatOfTheWorstAir) {
  Progress quiet;
  const std::vector<Vec3> eyes{Vec3(10, 2, 2)};
  const std::vector<std::int64_t> ids{7};
  const auto doses = [&](bool means) {
    auto engine =
        SightEngine::open(std::make_shared<RoomOfMeans>(means), {}, std::vector{fdsDose(1)}, quiet)
            .value();
    std::vector<double> dose(1), worst(1), asked(1);
    for (int t = 0; t <= 60; ++t) {
      EXPECT_TRUE(engine.dose(ids, eyes, t, dose));
      EXPECT_TRUE(engine.dose(ids, eyes, t, asked, worst)) << "at the same time again";
      EXPECT_EQ(dose[0], asked[0]);
    }
    return std::array{dose[0], worst[0]};
  };
  const auto cells = doses(false), means = doses(true);
  EXPECT_GT(cells[0], 0);
  EXPECT_DOUBLE_EQ(cells[0], cells[1]);
  EXPECT_LT(means[0], 0.6 * cells[0]);
  EXPECT_DOUBLE_EQ(means[1], cells[0]);
}

TEST(ExposureMeter, CountsTheMemoryOfBoundsToo) {
  const std::vector criteria{fdsDose(1)};
  const auto bytes = [&](bool means) {
    RoomOfMeans room(means);
    return ExposureMeter::bytesOfPerson(AirField::open(room, criteria), criteria);
  };
  EXPECT_GE(bytes(false), LevelWatch::kBytesOfPlace);
  EXPECT_GE(bytes(true), bytes(false) + LevelWatch::kBytesOfPlace + 6 * sizeof(double));
  EXPECT_EQ(ExposureMeter::bytesOfPerson(AirField(), criteria), 0U) << "nothing is stored of it";
}

TEST(Rset, IsANumberAMapOrPeople) {
  const std::vector<Vec3> points{Vec3(0, 0, 2), Vec3(10, 0, 2)};
  EXPECT_EQ(Rset(90).at(points, 1)[1], 90);
  const auto map = Rset::parse("x,y,rset\n0,1,30\n9,0,50\n", "map.csv").value();
  EXPECT_EQ(map.at(points, 1), (std::vector<double>{30, 50}));
  const auto people =
      Rset::parse("id,time,x,y\n1,0,0,0.2\n1,5,0.1,0\n1,9,4,0\n2,7,0,0\n", "walk.csv").value();
  const auto last = people.at(points, 0.5);
  EXPECT_EQ(last[0], 7);
  EXPECT_TRUE(std::isnan(last[1]));
  // People of another storey are not here.
  const auto storeys =
      Rset::parse("id,time,x,y,z\n1,0,0,0,0\n1,10,0,0,0\n2,0,0,0,4.8\n2,60,0,0,4.8\n", "w.csv")
          .value();
  const std::vector<Vec3> heights{Vec3(0, 0, 1.8), Vec3(0, 0, 4.8)};
  EXPECT_EQ(storeys.at(heights, 1), (std::vector<double>{10, 60}));
  // Somebody who passes between two lines of the table.
  const auto passing = Rset::parse("id,time,x,y\n1,0,-10,0\n1,20,10,0\n", "w.csv").value();
  EXPECT_NEAR(passing.at(std::vector{Vec3(0, 0, 2)}, 0.5)[0], 10.5, 1e-9);
  // 2 m in 400 s, past a point that is 0.3 m beside the way.
  const auto queue = Rset::parse("id,time,x,y\n1,0,0,0\n1,400,2,0\n1,401,9,0\n", "w.csv").value();
  EXPECT_NEAR(queue.at(std::vector{Vec3(1, 0.3, 2)}, 0.5)[0], 200 * 1.4, 1e-9);
  EXPECT_TRUE(std::isnan(queue.at(std::vector{Vec3(1, 0.51, 2)}, 0.5)[0]));
  // Down a stair, until it is more than 2.5 m below.
  const auto stair = Rset::parse("id,time,x,y,z\n1,0,0,0,4\n1,100,0.1,0,-1\n", "w.csv").value();
  EXPECT_NEAR(stair.at(std::vector{Vec3(0, 0, 4.5)}, 0.5)[0], 40, 1e-9);
  EXPECT_THAT(Rset::parse("what\n", "bad.csv").error().message, HasSubstr("x,y,rset"));
  EXPECT_THAT(Rset::parse("x,y,rset\n0,1,30\n9,0,50\n0,1,60\n", "map.csv").error().message,
              HasSubstr("map.csv: two times at the place 0, 1: 30 s and 60 s"));
  EXPECT_TRUE(Rset::parse("x,y,rset\n0,1,30\n0,1,30\n", "map.csv"));
  const auto floors = Rset::parse("x,y,z,rset\n0,0,0,30\n0,0,3,50\n", "map.csv").value();
  EXPECT_EQ(floors.at(heights, 1), (std::vector<double>{30, 50}));
  const auto away = floors.remarks(std::vector{1.8});
  ASSERT_EQ(away.size(), 1U);
  EXPECT_EQ(away[0].code, RemarkCode::kLeftOut);
  EXPECT_THAT(away[0].sentence, HasSubstr("1 of 2 places are on no storey"));
  EXPECT_EQ(Rset::parse("x [cm],y,rset [min]\n100,2,0.5\n", "m.csv").value().at(points, 1)[0], 30);
  EXPECT_THAT(Rset::parse("x,y,rset\n1,2,-20\n", "m.csv").error().message,
              HasSubstr("line 2: rset is -20 s; expected 0 or more"));
  EXPECT_EQ(Rset::read("45.5", 100).value().at(points, 1)[0], 45.5);
  EXPECT_THAT(Rset::read("-1", 100).error().message, HasSubstr("-1: expected seconds >= 0"));
  EXPECT_EQ(Rset::read("none.csv", 100).error().code, ErrorCode::kNotFound);
  const Box3 room{Vec3(0, 0, 0), Vec3(9, 4, 3)};
  EXPECT_EQ(map.placesBeside(room), "");
  EXPECT_THAT(Rset::parse("x,y,rset\n0,1,30\n9000,0,50\n", "m.csv").value().placesBeside(room),
              HasSubstr("1 of 2 places of the required times are beside the case"));
}

}  // namespace
}  // namespace volute
