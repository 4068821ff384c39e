// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "volute/grid/bricks.hpp"
#include "volute/grid/one_frame_testing.hpp"
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

/// 2 x 2 x 4 tiles beside a leaf, so that no face is at a multiple of their side.
Bricks tilesBesideALeaf(std::int64_t side, float odd) {
  Bricks bricks;
  for (int i = 0; i < 16; ++i)
    bricks.addTile({{8 + side * (i & 1), side * (i >> 1 & 1), side * (i >> 2)},
                    side,
                    true,
                    {i == 13 ? odd : 0.5F, 0, 0}});
  Bricks::Leaf leaf;
  leaf.active[0] = leaf.valued[0] = 3;
  const auto values = bricks.addLeaf(leaf);
  values[0] = 1, values[1] = 2;
  bricks.sort();
  return bricks;
}

TEST(Compare, TilesAreComparedWithoutTheirVoxels) {
  const auto compareAt = [](std::int64_t side, bool crop) {
    VolumeInfo info;
    info.x = static_cast<int>(2 * side + 8), info.y = static_cast<int>(2 * side),
    info.z = static_cast<int>(4 * side) - (crop ? 3 : 0);
    info.frames = 1;
    info.fillDefaults();
    gridtest::OneFrame a(info, tilesBesideALeaf(side, 0.5F)),
        b(info, tilesBesideALeaf(side, 0.75F));
    Progress progress;
    return compare(a, b, progress).value();
  };
  // Against every voxel.
  VolumeInfo info;
  info.x = 40, info.y = 32, info.z = 61;
  Sequence a = makeSequence(1, 61, 32, 40), b = a;
  tilesBesideALeaf(16, 0.5F).toDense({{0, 0, 0}, {40, 32, 61}}, a.values);
  tilesBesideALeaf(16, 0.75F).toDense({{0, 0, 0}, {40, 32, 61}}, b.values);
  SequenceSource sourceA(a), sourceB(b);
  Progress progress;
  const Difference dense = compare(sourceA, sourceB, progress).value();
  const Difference small = compareAt(16, true);
  EXPECT_DOUBLE_EQ(small.rms(), dense.rms());
  EXPECT_EQ(small.supportValues, dense.supportValues);
  EXPECT_EQ(small.values, dense.values);
  // 10^12 voxels.
  const Difference large = compareAt(4096, false);
  EXPECT_EQ(large.supportValues, (std::uint64_t{16} << 36) + 2);
  EXPECT_DOUBLE_EQ(large.supportSquares, std::ldexp(0.25 * 0.25, 36));
  EXPECT_EQ(large.worst, (VoxelIndex{8 + 4096, 0, 3 * 4096}));
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
