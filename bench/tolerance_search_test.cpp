// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/tolerance_search.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace volute::bench {
namespace {

TEST(ToleranceSearch, ComesCloseFromBelowInFewTries) {
  for (const double power : {0.7, 1.0, 1.5}) {
    for (const double start : {1e-4, 1e-2, 1.0}) {
      int tries = 0;
      auto error = [&](double t) -> Result<double> { return ++tries, 0.5 * std::pow(t, power); };
      const auto found = searchTolerance(3e-3, start, error);
      ASSERT_TRUE(found);
      EXPECT_LE(*error(*found), 3e-3);
      EXPECT_GE(*error(*found), 0.98 * 3e-3);
      EXPECT_LE(tries, 12);
    }
  }
}

TEST(ToleranceSearch, StopsBelowAStep) {
  auto error = [](double t) -> Result<double> { return t < 0.7 ? 1e-4 : 1e-1; };
  const auto found = searchTolerance(1e-2, 1.0, error);
  ASSERT_TRUE(found);
  EXPECT_LT(*found, 0.7);
  EXPECT_GT(*found, 0.69);
}

TEST(ToleranceSearch, SaysWhenNothingHelps) {
  EXPECT_FALSE(searchTolerance(1e-2, 1.0, [](double) -> Result<double> { return 1.0; }));
  EXPECT_FALSE(searchTolerance(
      1e-2, 1.0, [](double) -> Result<double> { return fail(ErrorCode::kIo, "full"); }));
}

TEST(ToleranceSearch, TakesWhatNeverReachesTheTarget) {
  EXPECT_TRUE(searchTolerance(1e-2, 1.0, [](double) -> Result<double> { return 0.0; }));
}

}  // namespace
}  // namespace volute::bench
