// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/response.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/capture/testing.hpp"

namespace volute {
namespace {

using testing::failsWith;

TEST(Response, KnownValues) {
  EXPECT_EQ(Response().linear(0.3), 0.3);
  EXPECT_NEAR(Response::srgb().linear(0.5), 0.21404114, 1e-8);
  EXPECT_NEAR(Response::gamma(2.2).linear(0.5), std::pow(0.5, 2.2), 1e-15);
  const Response table = Response::table({0, 0.1, 0.5, 2}).value();
  EXPECT_NEAR(table.linear(1.0 / 3), 0.1, 1e-15);
  EXPECT_NEAR(table.linear(0.5), 0.3, 1e-15);
  EXPECT_EQ(table.linear(1), 2);
  EXPECT_EQ(table.linear(7), 2);
}

TEST(Response, GoesOnBeyondZeroAndOne) {
  for (const Response& response : {Response::srgb(), Response::gamma(1.8)}) {
    EXPECT_NEAR(response.linear(1.5), 1.5, 1e-12);
    EXPECT_NEAR(response.linear(-0.25), -0.25, 1e-12);
  }
}

TEST(Response, Names) {
  for (const char* name : {"linear", "srgb", "gamma:2.2"})
    EXPECT_EQ(Response::byName(name).value().name(), name);
  for (const char* name : {"", "rgb", "gamma:", "gamma:0", "gamma:2,2", "gamma:nan"})
    EXPECT_TRUE(failsWith(Response::byName(name), "expected linear, srgb, or gamma:G")) << name;
}

TEST(Response, TablesAscend) {
  EXPECT_TRUE(failsWith(Response::table({1}), "at least two"));
  EXPECT_TRUE(failsWith(Response::table({0, 2, 1}), "ascending"));
  EXPECT_TRUE(failsWith(Response::table({0, std::nan(""), 1}), "finite"));
}

}  // namespace
}  // namespace volute
