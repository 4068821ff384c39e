// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/sight.hpp"

#include <gtest/gtest.h>

#include <array>

namespace volute {
namespace {

/// The same value everywhere on one side of x = 0, or on both.
class Constant final : public PointField {
 public:
  Constant(std::vector<double> times, double value, bool everywhere)
      : times_(std::move(times)), value_(value), everywhere_(everywhere) {}

  std::string description() const override { return std::to_string(value_); }

  std::span<const double> times() const override { return times_; }

  Status at(double, std::span<const Vec3> points, std::span<double> out) override {
    for (std::size_t i = 0; i < points.size(); ++i)
      out[i] = everywhere_ || points[i].x() > 0 ? value_ : std::nan("");
    return {};
  }

 private:
  std::vector<double> times_;
  double value_;
  bool everywhere_;
};

TEST(StoredPlace, EndsWithTheStoredTimes) {
  const std::vector<double> times{10, 12, 20};
  EXPECT_FALSE(storedPlace(times, 9.8));
  EXPECT_TRUE(storedPlace(times, 9.95));  // a time step of another file
  EXPECT_EQ(storedPlace(times, 12)->share, 0);
  EXPECT_EQ(storedPlace(times, 12)->span.until, 12);
  const auto between = storedPlace(times, 14).value();
  EXPECT_EQ(between.first, 1U);
  EXPECT_EQ(between.second, 2U);
  EXPECT_DOUBLE_EQ(between.share, 0.25);
  EXPECT_EQ(between.span.from, 12);
  EXPECT_EQ(between.span.until, 20);
  EXPECT_TRUE(storedPlace(times, 20.3));
  EXPECT_FALSE(storedPlace(times, 20.5));
  const std::vector<double> one{10};
  EXPECT_TRUE(storedPlace(one, 10));
  EXPECT_FALSE(storedPlace(one, 10.1));
}

TEST(BestPoints, TheOneThatKnowsAPlaceAndTimeBestServes) {
  std::vector<std::unique_ptr<PointField>> sources;
  std::vector<double> often;
  for (int t = 20; t <= 70; ++t) often.push_back(t);
  sources.push_back(std::make_unique<Constant>(std::vector<double>{50, 110}, 1, true));
  sources.push_back(std::make_unique<Constant>(often, 2, false));
  BestPoints best(std::move(sources));
  EXPECT_EQ(best.times().front(), 20);
  EXPECT_EQ(best.times().back(), 110);
  const std::vector<Vec3> points{Vec3(1, 0, 0), Vec3(-1, 0, 0)};
  const auto valuesAt = [&](double time, StoredSpan* spans) {
    PointValue answers[2];
    EXPECT_TRUE(best.answer(time, points, answers));
    std::ranges::transform(answers, spans, &PointValue::span);
    return std::vector{answers[0].value, answers[1].value};
  };
  StoredSpan spans[2];
  EXPECT_TRUE(std::isnan(valuesAt(10, spans)[0]));
  EXPECT_EQ(valuesAt(30, spans)[0], 2);
  EXPECT_TRUE(std::isnan(valuesAt(30, spans)[1]));
  EXPECT_EQ(valuesAt(60.5, spans), (std::vector<double>{2, 1}));  // 1 s apart, not 60
  EXPECT_EQ(spans[0].from, 60);
  EXPECT_EQ(spans[1].from, 50);
  EXPECT_EQ(valuesAt(80, spans)[0], 1);
  EXPECT_TRUE(std::isnan(valuesAt(130, spans)[0]));
  const auto served = best.sources();
  ASSERT_EQ(served.size(), 2U);
  EXPECT_EQ(served[0].served->from, 60.5);
  EXPECT_EQ(served[0].served->until, 80);
  EXPECT_EQ(served[1].served->from, 30);
}

/// As a mean that leaves something open.
class Open final : public PointField {
 public:
  Open(std::vector<double> times, PointValue value) : times_(std::move(times)), value_(value) {}

  std::string description() const override { return "open"; }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  bool isExact() const override { return false; }

  Status answer(double time, std::span<const Vec3>, std::span<PointValue> out) override {
    const auto place = storedPlace(times_, time);
    for (PointValue& one : out) {
      one = place ? value_ : PointValue{};
      one.span = place ? place->span : one.span;
    }
    return {};
  }

 private:
  std::vector<double> times_;
  PointValue value_;
};

TEST(BestPoints, WhatIsExactAtItsTimesNarrowsWhatIsStoredMoreOften) {
  const auto answer = [](std::vector<double> times, PointValue other, double time) {
    std::vector<std::unique_ptr<PointField>> sources;
    sources.push_back(std::make_unique<Open>(std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
                                             PointValue{60, 50, 80}));
    sources.push_back(std::make_unique<Open>(std::move(times), other));
    BestPoints best(std::move(sources));
    const std::vector<Vec3> point{Vec3(1, 0, 0)};
    std::vector<PointValue> out(1);
    EXPECT_TRUE(best.answer(time, point, out));
    return out.front();
  };
  const PointValue exact{70, 70, 70};
  const std::vector<double> few{0, 5, 10};
  PointValue one = answer(few, exact, 5);
  EXPECT_EQ((std::array{one.value, one.low, one.high}), (std::array{70.0, 70.0, 70.0}));
  EXPECT_EQ(one.span.from, 5);
  one = answer(few, exact, 6);
  EXPECT_EQ((std::array{one.value, one.low, one.high}), (std::array{60.0, 50.0, 80.0}))
      << "it may have been more between its times";
  EXPECT_EQ(one.span.until, 6);
  one = answer({0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5}, exact, 6);
  EXPECT_EQ(one.high, 70) << "as often";
  one = answer(few, {55, 40, 58}, 5);
  EXPECT_EQ((std::array{one.value, one.low, one.high}), (std::array{58.0, 50.0, 58.0}));
  one = answer(few, {30, 20, 40}, 5);
  EXPECT_EQ((std::array{one.low, one.high}), (std::array{50.0, 80.0})) << "a contradiction";
  one = answer(few, {.value = 70, .low = 70, .high = 70, .ofPlace = false}, 5);
  EXPECT_EQ(one.high, 80) << "from nearby";
}

/// The rise of a fire with an open band, everywhere or on one side of x = 0.
class Rising final : public PointField {
 public:
  Rising(std::vector<double> times, double band, bool everywhere)
      : times_(std::move(times)), band_(band), everywhere_(everywhere) {}

  std::string description() const override { return "rising"; }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  bool isExact() const override { return band_ == 0; }

  Status answer(double time, std::span<const Vec3> points, std::span<PointValue> out) override {
    const auto place = storedPlace(times_, time);
    for (std::size_t i = 0; i < points.size(); ++i) {
      out[i] = {.span = out[i].span};
      if (!place || !(everywhere_ || points[i].x() > 0))
        continue;
      const auto of = [&](auto&& part) {
        return (1 - place->share) * part(times_[place->first]) +
               place->share * part(times_[place->second]);
      };
      const auto wide = [&](double t) { return band_ * (1 + std::sin(t)); };
      out[i] = {of(riseAt), of([&](double t) { return riseAt(t) - wide(t); }),
                of([&](double t) { return riseAt(t) + wide(t); }), place->span};
    }
    return {};
  }

  static double riseAt(double time) { return 20 + time * time / 10; }

 private:
  std::vector<double> times_;
  double band_;
  bool everywhere_;
};

/// Multiples of an interval, each later by up to a share of it, as FDS's time steps have it.
std::vector<double> timesOfSteps(double interval, double share, double until) {
  std::vector<double> times;
  for (int i = 0; i * interval <= until; ++i)
    times.push_back(interval * (i + share * std::abs(std::sin(7.0 * i * interval))));
  return times;
}

std::unique_ptr<BestPoints> bestOf(std::vector<std::unique_ptr<PointField>> sources) {
  return std::make_unique<BestPoints>(std::move(sources));
}

TEST(BestPoints, WhoDoesNotKnowAPlaceHasNoSayThere) {
  // Instruments every second, and two kinds of slices every two: all three know what is right of 0.
  const auto sources = [](bool instruments) {
    std::vector<std::unique_ptr<PointField>> all;
    all.push_back(std::make_unique<Rising>(timesOfSteps(2, 0.1, 40), 10, true));
    all.push_back(std::make_unique<Rising>(timesOfSteps(2, 0.1, 40), 4, true));
    if (instruments)
      all.push_back(std::make_unique<Rising>(timesOfSteps(1, 0.2, 40), 0, false));
    return all;
  };
  const auto with = bestOf(sources(true)), without = bestOf(sources(false));
  const std::vector<Vec3> points{Vec3(-1, 0, 0), Vec3(1, 0, 0)};
  for (double time = 0.5; time < 38; time += 0.01) {
    PointValue a[2], b[2];
    ASSERT_TRUE(with->answer(time, points, a));
    ASSERT_TRUE(without->answer(time, points, b));
    EXPECT_EQ((std::array{a[0].value, a[0].low, a[0].high}),
              (std::array{b[0].value, b[0].low, b[0].high}))
        << time;
    EXPECT_LE(a[0].high, a[0].value + 8.1) << "at " << time << " s both kinds count";
    EXPECT_EQ(a[1].low, a[1].high) << "at " << time << " s the instrument is the closest";
  }
}

TEST(BestPoints, TheValueDoesNotDependOnWhoAsksWhen) {
  std::vector<std::unique_ptr<PointField>> all;
  all.push_back(std::make_unique<Rising>(timesOfSteps(2, 0.1, 40), 10, true));
  all.push_back(std::make_unique<Rising>(timesOfSteps(2, 0.15, 40), 10, true));
  all.push_back(std::make_unique<Rising>(std::vector<double>{0, 13, 26, 39}, 0, true));
  const auto best = bestOf(std::move(all));
  const std::vector<Vec3> point{Vec3(1, 0, 0)};
  const auto highAt = [&](double time) {
    std::vector<PointValue> out(1);
    EXPECT_TRUE(best->answer(time, point, out));
    EXPECT_LE(out[0].low, out[0].value);
    EXPECT_LE(out[0].value, out[0].high);
    return out[0].high;
  };
  const auto times = best->times();
  double narrowest = 1e9, before = highAt(times[0]);
  for (std::size_t i = 1; times[i] < 39; ++i) {
    const double now = highAt(times[i]);
    for (const double share : {0.001, 0.25, 0.5, 0.999}) {
      EXPECT_NEAR(highAt(times[i - 1] + share * (times[i] - times[i - 1])),
                  (1 - share) * before + share * now, 1e-9)
          << times[i - 1] << " to " << times[i];
    }
    before = now;
    narrowest = std::min(narrowest, now - Rising::riseAt(times[i]));
  }
  EXPECT_NEAR(narrowest, 0, 0.01) << "where the exact one is stored";
}

TEST(SpacingAt, IsThatOfTheTimesAroundWithoutTheirSteps) {
  const std::vector<double> steps{0, 1.1, 2, 3.15, 4, 5.1, 6};
  EXPECT_NEAR(spacingAt(steps, 2.5), 1.02, 1e-12);
  EXPECT_NEAR(spacingAt(steps, 3.15), 1, 0.03);
  const std::vector<double> gap{0, 1, 2, 30, 31, 32};
  EXPECT_EQ(spacingAt(gap, 1.5), 1);
  EXPECT_EQ(spacingAt(gap, 15), 28);
  EXPECT_EQ(spacingAt(gap, 30), 1) << "itself stored";
  EXPECT_TRUE(std::isinf(spacingAt(std::vector<double>{3}, 3)));
}

}  // namespace
}  // namespace volute
