// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/value_histogram.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace volute {
namespace {

/// So many values from .01 to 1.
ValueHistogram puff(int count) {
  ValueHistogram histogram;
  for (int i = 0; i < count; ++i)
    histogram.add(0.01F + 0.99F * static_cast<float>(i) / static_cast<float>(count - 1), 1);
  return histogram;
}

TEST(ValueHistogram, AHundredthFarFromAllOthersIsLeftOut) {
  for (const auto& [count, above, below] :
       {std::array{5000, 1, 0}, {5000, 20, 0}, {5000, 0, 30}, {5000, 40, 40}, {200, 1, 1}}) {
    ValueHistogram histogram = puff(count);
    for (int i = 0; i < above; ++i) histogram.add(1e6F + 1e4F * static_cast<float>(i), 1);
    for (int i = 0; i < below; ++i) histogram.add(-50.0F - static_cast<float>(i), 1);
    const auto range = histogram.robustRange(below > 0 ? -100 : 0.01, above > 0 ? 1.5e6 : 1);
    ASSERT_TRUE(range) << count << ", " << above << ", " << below;
    EXPECT_NEAR(range->first, 0.01, 0.006);
    EXPECT_NEAR(range->second, 1, 0.02);
  }
}

TEST(ValueHistogram, WhatIsNotFarOrNotFewStays) {
  EXPECT_FALSE(puff(5000).robustRange(0.01, 1));
  ValueHistogram many = puff(5000);
  for (int i = 0; i < 200; ++i) many.add(1e6F + 1e4F * static_cast<float>(i), 1);
  EXPECT_FALSE(many.robustRange(0.01, 3e6)) << "a part of its own";
  ValueHistogram labels;
  for (const float label : {1.0F, 2.0F, 3.0F, 100.0F}) labels.add(label, 500);
  EXPECT_FALSE(labels.robustRange(1, 100)) << "none varies";
  ValueHistogram wide;  // a flame: few are great, with all between
  for (int i = 0; i < 5000; ++i) wide.add(std::exp(-7 + 14 * static_cast<float>(i) / 5000), 1);
  EXPECT_FALSE(wide.robustRange(std::exp(-7), std::exp(7)));
  ValueHistogram zeros;  // a dense array that is nearly empty
  zeros.add(0, 100000);
  zeros.add(0.5F, 300);
  EXPECT_FALSE(zeros.robustRange(0, 0.5));
  EXPECT_FALSE(ValueHistogram().robustRange(0, 0));
}

TEST(ValueHistogram, ValuesThatStandForSomethingElseAreLeftOutHoweverMany) {
  for (const auto& [below, above] : {std::pair(0, 1), {2, 0}, {1, 1}, {2, 2}}) {
    ValueHistogram histogram = puff(5000);
    for (int i = 0; i < below; ++i) histogram.add(i == 0 ? -999.0F : -9999.0F, 3000);
    for (int i = 0; i < above; ++i) histogram.add(i == 0 ? 1e4F : 3.4e38F, 20000);
    const auto range = histogram.robustRange(-9999, 3.4e38);
    ASSERT_TRUE(range) << below << ", " << above;
    EXPECT_NEAR(range->first, 0.01, 0.006);
    EXPECT_NEAR(range->second, 1, 0.02);
  }
}

TEST(ValueHistogram, WhatVariesIsNotWhatFillsMostOfIt) {
  ValueHistogram histogram;
  for (int i = 0; i < 5000; ++i) histogram.addVoxel(299.25F + 0.2F * static_cast<float>(i));
  EXPECT_EQ(histogram.varied(1000), 5000);
  for (int i = 0; i < 100000; ++i) histogram.addVoxel(299);
  histogram.add(500, 1000000);  // a tile
  EXPECT_NEAR(static_cast<double>(histogram.varied(1000)), 5000, 50);
  for (int i = 0; i < 100000; ++i)
    histogram.addVoxel(299.5F + 0.4F * static_cast<float>(i % 64) / 64);
  EXPECT_NEAR(static_cast<double>(histogram.varied(1000)), 5000, 50) << "noise";
  EXPECT_NEAR(static_cast<double>(histogram.varied(900)), 5000, 50) << "noise, finer than bins are";
  EXPECT_NEAR(static_cast<double>(histogram.varied(20)), 105000, 5) << "detail";
}

}  // namespace
}  // namespace volute
