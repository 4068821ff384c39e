// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/synth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/base/checksum.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/synth/fluid.hpp"
#include "volute/synth/noise.hpp"
#include "volute/synth/puffs.hpp"

namespace volute {
namespace {

Sequence make(const SynthOptions& options) {
  Progress progress;
  auto sequence = synthesize(options, progress);
  EXPECT_TRUE(sequence) << sequence.error().message;
  return sequence ? *std::move(sequence) : Sequence{};
}

SynthOptions small(SynthKind kind) {
  return {.kind = kind, .size = 16, .frames = 4};
}

// The sequence of `small`, made once for all tests.
const Sequence& smallSequence(SynthKind kind) {
  static const Sequence fire = make(small(SynthKind::kFire));
  static const Sequence smoke = make(small(SynthKind::kSmoke));
  return kind == SynthKind::kFire ? fire : smoke;
}

std::uint32_t checksum(std::span<const float> values) {
  return crc32(std::as_bytes(values));
}

double zeroShare(const Sequence& sequence) {
  const auto& values = sequence.values;
  return static_cast<double>(std::ranges::count(values, 0.0f)) / static_cast<double>(values.size());
}

class Synth : public testing::TestWithParam<SynthKind> {};

INSTANTIATE_TEST_SUITE_P(Kinds, Synth, testing::Values(SynthKind::kFire, SynthKind::kSmoke));

TEST_P(Synth, SameBytesForAnyNumberOfThreadsAndFrozen) {
  const std::uint32_t frozen = GetParam() == SynthKind::kFire ? 3676514153u : 952373907u;
  EXPECT_EQ(checksum(smallSequence(GetParam()).values), frozen);
  for (int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    EXPECT_EQ(checksum(make(small(GetParam())).values), frozen) << threads << " threads";
  }
}

TEST_P(Synth, FiniteNonNegativeAndNotEmpty) {
  const Sequence& sequence = smallSequence(GetParam());
  ASSERT_TRUE(sequence.info.validate("test"));
  float most = 0;
  for (float value : sequence.values) {
    ASSERT_TRUE(std::isfinite(value) && value >= 0);
    most = std::max(most, value);
  }
  EXPECT_GT(most, 1);
  EXPECT_LT(most, 100);
}

TEST_P(Synth, ScalarIsZeroWhereRgbIsZero) {
  const Sequence& rgb = smallSequence(GetParam());
  SynthOptions options = small(GetParam());
  options.channels = 1;
  options.frames = 1;
  const Sequence scalar = make(options);
  for (std::size_t i = 0; i < scalar.values.size(); ++i) {
    const bool dark =
        rgb.values[3 * i] == 0 && rgb.values[3 * i + 1] == 0 && rgb.values[3 * i + 2] == 0;
    ASSERT_EQ(scalar.values[i] == 0, dark) << i;
  }
}

TEST_P(Synth, AnotherSeedIsAnotherSequence) {
  SynthOptions other = small(GetParam());
  other.seed = 2;
  other.frames = 1;
  EXPECT_NE(checksum(make(other).values), checksum(smallSequence(GetParam()).frame(0)));
}

TEST_P(Synth, FramesComeInAnyOrder) {
  const Sequence& sequence = smallSequence(GetParam());
  Progress progress;
  const auto source = SyntheticSource::create(small(GetParam()), progress);
  ASSERT_TRUE(source);
  std::vector<float> frame(sequence.info.frameValues());
  for (int index : {2, 2, 0, 3}) {
    ASSERT_TRUE((*source)->readFrame(index, frame));
    EXPECT_EQ(checksum(frame), checksum(sequence.frame(index))) << index;
  }
  EXPECT_EQ((*source)->readFrame(4, frame).error().code, ErrorCode::kInvalidArgument);
}

TEST(SynthFire, IsMostlyEmptyAndMovesFasterThanSmoke) {
  const auto change = [](const Sequence& s) {
    double sum = 0;
    double total = 0;
    for (std::size_t i = 0; i < s.info.frameValues(); ++i) {
      sum += std::fabs(s.frame(1)[i] - s.frame(0)[i]);
      total += s.frame(0)[i];
    }
    return sum / total;
  };
  const Sequence& fire = smallSequence(SynthKind::kFire);
  const Sequence& smoke = smallSequence(SynthKind::kSmoke);
  EXPECT_GT(zeroShare(fire), 0.85);
  EXPECT_LT(zeroShare(fire), 0.99);
  EXPECT_LT(zeroShare(smoke), zeroShare(fire));
  EXPECT_GT(change(fire), 2 * change(smoke));
}

TEST(SynthOptions, OutOfRangeIsRefusedWithTheValue) {
  Progress progress;
  for (const SynthOptions& bad :
       {SynthOptions{.size = 15}, SynthOptions{.size = 136}, SynthOptions{.size = 20},
        SynthOptions{.frames = 0}, SynthOptions{.channels = 2}}) {
    const auto source = SyntheticSource::create(bad, progress);
    ASSERT_FALSE(source);
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(synthesize({.size = 16, .frames = 2}, progress, 1000).error().code,
            ErrorCode::kTooLarge);
}

TEST(SynthProgress, StopsWhenAsked) {
  struct Stop : Progress {
    bool cancelled() const override { return true; }
  } progress;

  const auto sequence = synthesize({.size = 16, .frames = 2}, progress);
  ASSERT_FALSE(sequence);
  EXPECT_EQ(sequence.error().code, ErrorCode::kCancelled);
}

TEST(Fluid, ProjectionReachesTheAskedDivergenceAndNothingPassesTheFloor) {
  for (int size : {16, 24, 40}) {
    Fluid fluid(size, 2, 0);
    VectorNoise noise(7, 2, 0.2f, 1);
    const float h = fluid.cellSize();
    for (int step = 0; step < 4; ++step) {
      fluid.advect(0.05f);
      for (int k = 0; k < size; ++k) {
        for (int j = 0; j < size; ++j) {
          for (int i = 0; i < size; ++i) {
            const auto value = noise.at(h * static_cast<float>(i), h * static_cast<float>(j),
                                        h * static_cast<float>(k));
            for (int c = 0; c < 3; ++c) fluid.force()[c].at(i, j, k) = 20 * value[c];
            fluid.expansion().at(i, j, k) = std::max(0.0f, value[0]);
          }
        }
      }
      fluid.addForces(0.05f, 0.5f);
      const float before = fluid.divergenceError();
      fluid.project();
      EXPECT_GT(before, 1);
      EXPECT_LT(fluid.divergenceError(), 0.02f * before) << size << ", step " << step;
    }
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i) ASSERT_EQ(fluid.velocity()[2].at(i, j, 0), 0);
    }
  }
}

TEST(Puffs, AreSparseAndTheSameInAnyOrder) {
  PuffSource source({.size = 128, .frames = 3, .seed = 2});
  ASSERT_TRUE(source.info().validate("puffs"));
  EXPECT_TRUE(source.hasTopology());
  Bricks first, second;
  ASSERT_TRUE(static_cast<FrameSource&>(source).readBricks(2, second));
  ASSERT_TRUE(static_cast<FrameSource&>(source).readBricks(0, first));
  EXPECT_NE(first.checksum(), second.checksum());
  const double share =
      static_cast<double>(second.activeVoxels()) / static_cast<double>(source.info().frameValues());
  EXPECT_GT(share, 0.002);
  EXPECT_LT(share, 0.04);
  EXPECT_LT(second.bytes(), source.brickBytes() * 2);
  for (std::size_t l = 0; l < second.leaves().size(); ++l) {
    for (const float value : second.values(l))
      EXPECT_TRUE(value == 0 || (value > 0.02F && value <= 2));
  }
  // A dense frame, and layers of one.
  std::vector<float> values(source.info().frameValues());
  ASSERT_TRUE(source.readFrame(2, values));
  EXPECT_EQ(Bricks::fromDense(source.info(), values).checksum(), second.checksum());
  Bricks upper;
  ASSERT_TRUE(source.readBricks(2, 64, 128, upper));
  for (const Bricks::Leaf& leaf : upper.leaves()) EXPECT_GE(leaf.origin[2], 64);
  const ThreadLimit limit(1);
  Bricks again;
  ASSERT_TRUE(static_cast<FrameSource&>(source).readBricks(2, again));
  EXPECT_EQ(again.checksum(), second.checksum());
}

}  // namespace
}  // namespace volute
