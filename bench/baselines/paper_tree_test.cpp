// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/baselines/paper_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace volute {
namespace {

Sequence noiseInABox(int frames, int z, int y, int x, int channels) {
  Sequence sequence = makeSequence(frames, z, y, x, channels);
  std::mt19937 random(7);
  auto view = sequence.view();
  for (int t = 0; t < frames; ++t)
    for (int k = z / 4; k < z / 2; ++k)
      for (int j = y / 4; j < y; ++j)
        for (int i = 0; i < x / 2 + 1; ++i)
          for (int c = 0; c < channels; ++c)
            view(t, k, j, i, c) = static_cast<float>(random() % 1000) / 1000;
  return sequence;
}

double measuredRms(const PaperTree& tree, const Sequence& sequence) {
  double sum = 0, low = 0, high = 0;
  const VolumeInfo& info = sequence.info;
  for (int t = 0; t < info.frames; ++t)
    for (int z = 0; z < info.z; ++z)
      for (int y = 0; y < info.y; ++y)
        for (int x = 0; x < info.x; ++x)
          for (int c = 0; c < info.channels; ++c) {
            const double v = sequence.view()(t, z, y, x, c);
            sum += std::pow(tree.value(t, z, y, x, c) - v, 2);
            low = std::min(low, v), high = std::max(high, v);
          }
  return std::sqrt(sum / static_cast<double>(info.values())) / (high > low ? high - low : 1);
}

TEST(PaperTree, WithoutAThresholdGivesTheDataBack) {
  for (const auto& s :
       {std::array{4, 8, 8, 8, 1}, std::array{3, 5, 9, 6, 3}, std::array{1, 1, 1, 1, 1}}) {
    const Sequence sequence = noiseInABox(s[0], s[1], s[2], s[3], s[4]);
    const PaperTransform transform(sequence);
    EXPECT_LT(measuredRms(transform.build(0), sequence), 1e-6);
  }
}

TEST(PaperTree, CountsItsBytesAndPredictsItsError) {
  const Sequence sequence = noiseInABox(16, 16, 16, 16, 3);
  const PaperTransform transform(sequence);
  for (double threshold : {0.1, 1.0, 3.0}) {
    const PaperTree tree = transform.build(threshold);
    EXPECT_EQ(tree.bytes().size(), transform.bytesAt(threshold));
    EXPECT_NEAR(measuredRms(tree, sequence) / transform.relativeRmsAt(threshold), 1, 1e-4);
  }
  const double threshold = transform.thresholdForRms(0.02);
  EXPECT_LE(transform.relativeRmsAt(threshold), 0.02);
  EXPECT_GT(transform.relativeRmsAt(threshold * 1.01), 0.02 * 0.99);
}

TEST(PaperTree, RendersOrthographicSums) {
  const Sequence sequence = noiseInABox(2, 16, 16, 16, 1);
  const PaperTree tree = PaperTransform(sequence).build(0);
  const auto view = paperViewMatrix(Eigen::Matrix3d::Identity(), 1);
  const auto image = renderByTraversal(tree, view, 16, nullptr);
  for (int row = 0; row < 16; ++row)
    for (int x = 0; x < 16; ++x) {
      double sum = 0;
      for (int y = 0; y < 16; ++y) sum += sequence.view()(1, 15 - row, y, x, 0) / 16;
      EXPECT_NEAR(image[row * 16 + x], sum, 1e-5);
    }
  const VoxelBox box{{4, 4, 0}, {8, 16, 9}};
  const auto boxed = renderByTraversal(tree, view, 16, &box);
  for (std::size_t i = 0; i < image.size(); ++i) EXPECT_NEAR(boxed[i], image[i], 1e-5);
}

}  // namespace
}  // namespace volute
