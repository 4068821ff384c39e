// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/tree4d.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>
#include <hwy/targets.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "volute/base/parallel.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/tree4d/tree_node.hpp"
#include "volute/wavelet/quantiser.hpp"
#include "volute/wavelet/transform4d.hpp"

namespace volute {
namespace {

/// A moving soft ball with noise inside and exact zeros outside.
Sequence ball(int frames, int z, int y, int x, int channels, unsigned seed = 1) {
  Sequence sequence = makeSequence(frames, z, y, x, channels);
  std::mt19937 random(seed);
  auto view = sequence.view();
  for (int t = 0; t < frames; ++t)
    for (int k = 0; k < z; ++k)
      for (int j = 0; j < y; ++j)
        for (int i = 0; i < x; ++i) {
          const double centre = x * (0.3 + 0.4 * t / frames);
          const double r = std::hypot((i - centre) / x, (j - y / 2.0) / y, (k - z / 2.0) / z) * 3;
          for (int c = 0; c < channels; ++c) {
            const double noise = static_cast<double>(random() % 1000) / 5000;
            view(t, k, j, i, c) =
                r < 1 ? static_cast<float>((1 - r * r) * (1 + 0.2 * c) * (1 + noise)) : 0.0f;
          }
        }
  return sequence;
}

Tree4d treeOf(const Sequence& sequence, double step) {
  SequenceSource source(sequence);
  Progress quiet;
  auto tree = Tree4d::build(source, {.relativeRms = 0, .step = step}, quiet);
  EXPECT_TRUE(tree) << tree.error().message;
  return std::move(*tree);
}

double relativeRms(const Tree4d& tree, const Sequence& sequence) {
  double sum = 0, low = sequence.values[0], high = low;
  std::vector<float> frame(sequence.info.frameValues());
  for (int t = 0; t < sequence.info.frames; ++t) {
    tree.extractFrame(t, frame);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const double v = sequence.frame(t)[i];
      sum += (frame[i] - v) * (frame[i] - v);
      low = std::min(low, v), high = std::max(high, v);
    }
  }
  return std::sqrt(sum / static_cast<double>(sequence.values.size())) / (high - low);
}

/// Every way to read a tree gives what the walk from the root gives.
void expectAllReadsAgree(const Tree4d& tree) {
  const VolumeInfo& info = tree.info();
  const int channels = info.channels;
  std::vector<float> frame(info.frameValues()), line(static_cast<std::size_t>(info.x) * channels);
  for (int t = 0; t < info.frames; ++t) {
    tree.extractFrame(t, frame);
    const BrickSlice slice = tree.extractSlice(t);
    const VoxelBox& box = tree.occupiedBox(t);
    std::size_t i = 0;
    for (int z = 0; z < info.z; ++z)
      for (int y = 0; y < info.y; ++y) {
        std::vector<std::array<int, 4>> voxels;
        for (int x = 0; x < info.x; ++x) voxels.push_back({t, z, y, x});
        tree.values(voxels, line);
        for (int x = 0; x < info.x; ++x)
          for (int c = 0; c < channels; ++c, ++i) {
            const double expected = tree.valueFromRoot(t, z, y, x, c);
            ASSERT_NEAR(line[x * channels + c], expected,
                        1e-6 * std::max(1.0f, tree.data().maximum))
                << t << ' ' << z << ' ' << y << ' ' << x;
            ASSERT_EQ(tree.value(t, z, y, x, c), line[x * channels + c]);
            ASSERT_EQ(frame[i], line[x * channels + c]) << t << ' ' << z << ' ' << y << ' ' << x;
            ASSERT_EQ(slice.value(x, y, z, c), frame[i]);
            const bool inBox = z >= box.begin[0] && z < box.end[0] && y >= box.begin[1] &&
                               y < box.end[1] && x >= box.begin[2] && x < box.end[2];
            if (!inBox && info.z % 8 == 0 && info.y % 8 == 0 && info.x % 8 == 0 && frame[i] != 0) {
              // Outside the box only bricks that it shares may hold traces of the quantisation.
              ASSERT_TRUE(tree.data().isOccupied(t, z, y, x));
            }
          }
      }
  }
}

TEST(Tree4d, AllReadsAgreeOnManySizes) {
  const int sizes[][5] = {{1, 1, 1, 1, 1},     {2, 2, 2, 2, 1},     {1, 7, 5, 3, 1},
                          {16, 16, 16, 16, 1}, {17, 16, 16, 16, 1}, {5, 37, 20, 33, 1},
                          {40, 9, 17, 24, 3},  {3, 64, 8, 8, 3}};
  for (const auto& s : sizes) {
    SCOPED_TRACE(
        fmt::format("{} frames of {} x {} x {}, {} channels", s[0], s[3], s[2], s[1], s[4]));
    expectAllReadsAgree(treeOf(ball(s[0], s[1], s[2], s[3], s[4]), 0.02));
  }
}

TEST(Tree4d, WideCoefficientsAndEscapesKeepTheirValues) {
  Sequence sequence = ball(16, 32, 32, 32, 1);
  sequence.view()(3, 16, 16, 16, 0) = 4000;
  const Tree4d tree = treeOf(sequence, 1e-3);
  bool wide = false, escapes = false;
  for (const auto& level : tree.data().levels) {
    wide |= level.wide;
    escapes |= !level.escapeIndex.empty();
  }
  EXPECT_TRUE(wide);
  EXPECT_TRUE(escapes);
  expectAllReadsAgree(tree);
  EXPECT_NEAR(tree.value(3, 16, 16, 16), 4000, 0.01);
}

TEST(Tree4d, DecodesWhatTheGenericTransformQuantises) {
  const Sequence sequence = ball(16, 16, 16, 16, 1);
  constexpr float kStep = 0.05f;
  std::vector<double> coefficients(sequence.values.begin(), sequence.values.end());
  const View<double, 4> view(std::span<double>(coefficients), {16, 16, 16, 16});
  transformForward(view, Wavelet::kHaar, {4, 4, 4, 4});
  for (std::size_t i = 1; i < coefficients.size(); ++i) {
    coefficients[i] =
        static_cast<double>(quantise(static_cast<float>(coefficients[i]), 1 / kStep)) * kStep;
  }
  transformInverse(view, Wavelet::kHaar, {4, 4, 4, 4});
  // What the transform gives back holds whole steps only, so the tree must keep every coefficient.
  Sequence quantised = sequence;
  for (std::size_t i = 0; i < coefficients.size(); ++i)
    quantised.values[i] = static_cast<float>(coefficients[i]);
  const Tree4d tree = treeOf(quantised, kStep);
  for (int t = 0; t < 16; ++t)
    for (int z = 0; z < 16; ++z)
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) ASSERT_NEAR(tree.value(t, z, y, x), view(t, z, y, x), 1e-4);
}

TEST(Tree4d, MeetsTheErrorAskedForAndComesCloseToIt) {
  for (int channels : {1, 3}) {
    const Sequence sequence = ball(20, 24, 33, 30, channels);
    SequenceSource source(sequence);
    Progress quiet;
    for (double target : {3e-2, 3e-3}) {
      const auto tree = Tree4d::build(source, {.relativeRms = target}, quiet);
      ASSERT_TRUE(tree);
      const double reached = relativeRms(*tree, sequence);
      EXPECT_LE(reached, target);
      EXPECT_GE(reached, 0.9 * target);
    }
  }
}

TEST(Tree4d, DegenerateContentIsExact) {
  for (float value : {0.0f, 3.25f, -1.5f}) {
    Sequence sequence = makeSequence(5, 6, 7, 40);
    std::ranges::fill(sequence.values, value);
    SequenceSource source(sequence);
    Progress quiet;
    const auto tree = Tree4d::build(source, {.relativeRms = 1e-3}, quiet);
    ASSERT_TRUE(tree);
    std::vector<float> frame(sequence.info.frameValues());
    tree->extractFrame(4, frame);
    for (float v : frame) ASSERT_EQ(v, value);
    EXPECT_EQ(tree->occupiedBox(0).empty(), value == 0);
    EXPECT_LT(tree->memoryBytes(), 4000u);
  }
}

TEST(Tree4d, TheOccupiedBoxIsTight) {
  Sequence sequence = makeSequence(2, 20, 20, 20);
  sequence.view()(1, 3, 5, 7, 0) = 1;
  sequence.view()(1, 12, 5, 9, 0) = 1;
  const Tree4d tree = treeOf(sequence, 0.01);
  EXPECT_TRUE(tree.occupiedBox(0).empty());
  EXPECT_EQ(tree.occupiedBox(1).begin, (std::array<int, 3>{3, 5, 7}));
  EXPECT_EQ(tree.occupiedBox(1).end, (std::array<int, 3>{13, 6, 10}));
}

TEST(Tree4d, PrefixesAreCoarserAndConsistent) {
  const Sequence sequence = ball(16, 40, 40, 40, 1);
  const Tree4d tree = treeOf(sequence, 0.01);
  double before = 1e9;
  for (std::size_t nodes : {std::size_t{1}, std::size_t{10}, tree.nodeCount() / 10,
                            tree.nodeCount() / 2, tree.nodeCount()}) {
    const Tree4d prefix = tree.prefix(nodes);
    EXPECT_LE(prefix.nodeCount(), nodes);
    const double error = relativeRms(prefix, sequence);
    EXPECT_LE(error, before * 1.0001) << nodes;
    before = error;
    expectAllReadsAgree(prefix);
  }
  EXPECT_EQ(before, relativeRms(tree, sequence));
}

TEST(Tree4d, IsTheSameForAnyNumberOfThreads) {
  const Sequence sequence = ball(33, 20, 40, 40, 3);
  const Tree4d one = [&] {
    const ThreadLimit limit(1);
    return treeOf(sequence, 0.01);
  }();
  const Tree4d many = treeOf(sequence, 0.01);
  EXPECT_EQ(one.data().masks, many.data().masks);
  EXPECT_EQ(one.data().childMasks, many.data().childMasks);
  for (std::size_t l = 0; l < one.data().levels.size(); ++l) {
    EXPECT_EQ(one.data().levels[l].narrow8, many.data().levels[l].narrow8);
  }
}

TEST(Tree4d, ReadsTheSameBitsOnEveryInstructionSet) {
  const Tree4d tree = treeOf(ball(8, 32, 32, 32, 3), 0.01);
  const std::int64_t targets = hwy::SupportedTargets();
  std::vector<float> first, frame(tree.info().frameValues());
  for (std::int64_t rest = targets; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    tree.extractFrame(5, frame);
    if (first.empty())
      first = frame;
    EXPECT_EQ(frame, first) << hwy::TargetName(rest & -rest);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(Tree4d, RefusesNotANumber) {
  Sequence sequence = ball(2, 8, 8, 8, 1);
  sequence.values[77] = NAN;
  SequenceSource source(sequence);
  Progress quiet;
  EXPECT_FALSE(Tree4d::build(source, {}, quiet));
}

}  // namespace
}  // namespace volute
