// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

TEST(VolumeInfo, DefaultsAreCubicVoxelsOneMetreAnd25FramesPerSecond) {
  VolumeInfo info;
  info.frames = 3, info.z = 10, info.y = 20, info.x = 40;
  info.frameNumbers = {5, 6, 8};
  info.fillDefaults();
  EXPECT_DOUBLE_EQ(info.bounds.size().x(), 1);
  EXPECT_DOUBLE_EQ(info.bounds.size().z(), 0.25);
  EXPECT_DOUBLE_EQ(info.times[2], 3 / 25.0);
  EXPECT_EQ(info.frameAt(-1), 0);
  EXPECT_EQ(info.frameAt(0.041), 1);
  EXPECT_EQ(info.frameAt(99), 2);
  EXPECT_TRUE(info.validate("test"));
  info.times[1] = 0;
  EXPECT_FALSE(info.validate("test"));
}

TEST(BrickSlice, KeepsEveryValueAndNoEmptyBrick) {
  Sequence sequence = makeSequence(1, 9, 17, 8, 3);
  auto view = sequence.view();
  view(0, 8, 16, 7, 2) = 5;
  view(0, 0, 0, 0, 0) = 1;
  view(0, 0, 1, 1, 1) = 2;
  const BrickSlice slice = BrickSlice::fromDense(sequence.info, sequence.frame(0));
  EXPECT_EQ(slice.storedBricks(), 2u);
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 17; ++y)
      for (int x = 0; x < 8; ++x)
        for (int c = 0; c < 3; ++c) ASSERT_EQ(slice.value(x, y, z, c), view(0, z, y, x, c));
  EXPECT_EQ(slice.value(-1, 0, 0), 0);
}

TEST(ReadAll, RefusesWhatDoesNotFit) {
  const Sequence sequence = makeSequence(4, 8, 8, 8);
  SequenceSource source(sequence);
  EXPECT_TRUE(readAll(source, 8192));
  const auto refused = readAll(source, 8191);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace volute
