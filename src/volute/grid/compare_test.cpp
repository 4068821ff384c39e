// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

TEST(Compare, MeasuresAgainstTheRangeOfTheFirst) {
  Sequence a = makeSequence(2, 1, 1, 2);
  a.values = {-1, 3, 0, 0};
  Sequence b = a;
  b.values = {-1, 3, 0.5, -0.5};
  SequenceSource sourceA(a), sourceB(b);
  Progress progress;
  std::vector<Difference> byFrame;
  const auto difference = compare(sourceA, sourceB, progress, &byFrame);
  ASSERT_TRUE(difference);
  ASSERT_EQ(byFrame.size(), 2U);
  EXPECT_EQ(byFrame[0].rms(), 0);
  EXPECT_DOUBLE_EQ(byFrame[1].rms(), 0.5);
  EXPECT_DOUBLE_EQ(difference->rms(), std::sqrt(0.5 / 4));
  EXPECT_DOUBLE_EQ(difference->relativeRms(), std::sqrt(0.5 / 4) / 4);
  EXPECT_DOUBLE_EQ(difference->psnr(), -20 * std::log10(difference->relativeRms()));
  EXPECT_EQ(difference->maxError, 0.5);
}

TEST(Compare, EqualVolumesHaveInfinitePsnr) {
  Difference difference;
  const std::vector<float> values{1, 1, 1};
  difference.add(values, values);
  EXPECT_EQ(difference.rms(), 0);
  EXPECT_EQ(difference.relativeRms(), 0);
  EXPECT_TRUE(std::isinf(difference.psnr()));
}

TEST(Compare, NanOnOneSideIsNeverAMatch) {
  Difference difference;
  difference.add(std::vector<float>{1, 2}, std::vector<float>{1, std::nanf("")});
  EXPECT_TRUE(std::isinf(difference.maxError));
  EXPECT_TRUE(std::isinf(difference.rms()));
}

TEST(Compare, ConstantFirstHasNoRange) {
  Difference difference;
  difference.add(std::vector<float>{1, 1}, std::vector<float>{1, 2});
  EXPECT_TRUE(std::isinf(difference.relativeRms()));
}

TEST(Compare, DifferentSizesAreRefused) {
  const Sequence a = makeSequence(1, 2, 3, 4), b = makeSequence(2, 2, 3, 4);
  SequenceSource sourceA(a), sourceB(b);
  Progress progress;
  const auto difference = compare(sourceA, sourceB, progress);
  ASSERT_FALSE(difference);
  EXPECT_NE(difference.error().message.find("1 frame of 4 x 3 x 2 voxels"), std::string::npos);
}

}  // namespace
}  // namespace volute
