// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/plain_number.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace volute {
namespace {

TEST(PlainNumber, HasHundredthsOfWhatIsLarge) {
  EXPECT_EQ(plainNumber(5700006.318), "5700006.32");
  EXPECT_EQ(plainNumber(-500000.5), "-500000.5");
  EXPECT_EQ(plainNumber(5700000), "5700000");
  EXPECT_EQ(plainNumber(86400.1F), "86400.1");
  EXPECT_EQ(plainNumber(12345.678, 4), "12345.68");
  EXPECT_EQ(plainNumber(999.96, 4), "999.96");
}

TEST(PlainNumber, HasItsDigitsElse) {
  EXPECT_EQ(plainNumber(0), "0");
  EXPECT_EQ(plainNumber(1.7F), "1.7");
  EXPECT_EQ(plainNumber(12.3456, 4), "12.35");
  EXPECT_EQ(plainNumber(1.0 / 3), "0.333333");
  EXPECT_EQ(plainNumber(9.96921e36), "9.96921e+36");
  EXPECT_EQ(plainNumber(std::numeric_limits<double>::infinity()), "inf");
}

}  // namespace
}  // namespace volute
