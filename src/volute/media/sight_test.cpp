// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/sight.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace volute
