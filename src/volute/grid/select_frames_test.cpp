// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/select_frames.hpp"

#include <gtest/gtest.h>

#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

Sequence numbered(int first, int frames) {
  Sequence sequence = makeSequence(frames, 1, 1, 2);
  for (int i = 0; i < frames; ++i) {
    sequence.info.frameNumbers[i] = first + 2 * i;  // every second number is missing
    sequence.frame(i)[0] = static_cast<float>(first + 2 * i);
  }
  return sequence;
}

TEST(SelectFrames, GoesByNumbersHalfOpen) {
  const Sequence sequence = numbered(10, 6);  // 10 12 14 16 18 20
  EXPECT_EQ(*selectPositions(sequence.info, {12, 18, 1}), (std::vector{1, 2, 3}));
  EXPECT_EQ(*selectPositions(sequence.info, {std::nullopt, 14, 1}), (std::vector{0, 1}));
  EXPECT_EQ(*selectPositions(sequence.info, {17, std::nullopt, 1}), (std::vector{4, 5}));
  EXPECT_EQ(*selectPositions(sequence.info, {std::nullopt, std::nullopt, 4}),
            (std::vector{0, 2, 4}));
  EXPECT_EQ(*selectPositions(sequence.info, {-2000000000, 2000000000, 1}),
            (std::vector{0, 1, 2, 3, 4, 5}));
}

TEST(SelectFrames, NothingSelectedNamesWhatThereIs) {
  const auto none = selectPositions(numbered(10, 6).info, {0, 10, 1});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(none.error().message, "frames 0:10 select nothing; the input has frames 10 to 20");
}

TEST(SelectFrames, KeepsNumbersTimesAndValues) {
  const Sequence sequence = numbered(10, 6);
  auto selected = selectFrames(std::make_unique<SequenceSource>(sequence), {12, 20, 4});
  ASSERT_TRUE(selected);
  EXPECT_EQ((*selected)->info().frameNumbers, (std::vector{12, 16}));
  EXPECT_EQ((*selected)->info().times,
            (std::vector{sequence.info.times[1], sequence.info.times[3]}));
  EXPECT_TRUE((*selected)->info().validate("selected"));
  std::vector<float> values(2);
  ASSERT_TRUE((*selected)->readFrame(1, values));
  EXPECT_EQ(values[0], 16);
}

}  // namespace
}  // namespace volute
