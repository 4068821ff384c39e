// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/fitted_source.hpp"

#include <gtest/gtest.h>

#include "volute/grid/grid_description.hpp"
#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

/// Values 1, 2, 3, ... in voxels of `size` from `min` on.
Sequence counting(int z, int y, int x, const Vec3& min, double size, int channels = 1) {
  Sequence sequence = makeSequence(2, z, y, x, channels);
  sequence.info.bounds = {min, min + size * Vec3(x, y, z)};
  float next = 1;
  for (float& value : sequence.values) value = next++;
  return sequence;
}

std::vector<float> fitted(const Sequence& from, const VolumeInfo& to, int frame = 0) {
  const auto source = fitTo(std::make_unique<SequenceSource>(from), to);
  std::vector<float> values(source->info().frameValues());
  EXPECT_TRUE(source->readFrame(frame, values));
  return values;
}

TEST(FittedSource, VoxelsOfOneLatticeAreCopiedAndOthersZero) {
  const Sequence small = counting(2, 2, 3, {1, 1, 1}, 0.5, 3);
  const VolumeInfo wide = widenedTo(small.info, {{0.1, 1, 1}, {2.6, 2, 2.4}});
  EXPECT_EQ(wide.x, 6);  // two before, one after
  EXPECT_EQ(wide.y, 2);
  EXPECT_EQ(wide.z, 3);
  EXPECT_NEAR(wide.bounds.min.x(), 0, 1e-12);
  EXPECT_NEAR(wide.bounds.max.z(), 2.5, 1e-12);
  EXPECT_TRUE(onOneLattice(small.info, wide));
  const auto values = fitted(small, wide, 1);
  for (int z = 0; z < 3; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 6; ++x)
        for (int c = 0; c < 3; ++c) {
          const bool inside = z < 2 && x >= 2 && x < 5;
          const float expected = inside ? small.view()(1, z, y, x - 2, c) : 0;
          EXPECT_EQ(values[((z * 2 + y) * 6 + x) * 3 + c], expected);
        }
}

TEST(FittedSource, WhatLiesOutsideHasItsOwnValue) {
  const Sequence small = counting(1, 1, 2, {0, 0, 0}, 1);
  const auto source = fitTo(std::make_unique<SequenceSource>(small),
                            widenedTo(small.info, {{-1, 0, 0}, {3, 1, 1}}), {293, 0, 0});
  std::vector<float> values(4);
  ASSERT_TRUE(source->readFrame(1, values));
  EXPECT_EQ(values, (std::vector<float>{293, 3, 4, 293}));
}

TEST(FittedSource, OtherLatticesAreInterpolated) {
  // Linear in x, y and z: what lies between centres is exact.
  Sequence linear = makeSequence(1, 6, 7, 8);
  linear.info.bounds = {Vec3(0, 0, 0), Vec3(8, 7, 6)};
  auto view = linear.view();
  const auto at = [](double x, double y, double z) { return 1 + 2 * x - y + 0.5 * z; };
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 8; ++x)
        view(0, z, y, x, 0) = static_cast<float>(at(x + 0.5, y + 0.5, z + 0.5));
  for (const double size : {0.7, 1.9}) {
    VolumeInfo other = linear.info;
    other.x = other.y = other.z = 2;
    const Vec3 min(1.13, 1.4, 1.2);
    other.bounds = {min, min + 2 * size * Vec3::Ones()};
    EXPECT_FALSE(onOneLattice(linear.info, other));
    const auto values = fitted(linear, other);
    for (int i = 0; i < 8; ++i) {
      const Vec3 centre = min + size * (Vec3(i % 2, i / 2 % 2, i / 4) + 0.5 * Vec3::Ones());
      EXPECT_NEAR(values[static_cast<std::size_t>(i)], at(centre.x(), centre.y(), centre.z()),
                  1e-5);
    }
  }
}

TEST(FittedSource, LargerVoxelsKeepTheIntegral) {
  const Sequence fine = counting(4, 4, 4, {0, 0, 0}, 0.25);
  VolumeInfo coarse = fine.info;
  coarse.x = coarse.y = coarse.z = 3;
  coarse.bounds = {Vec3(-1, -1, -1), Vec3(2, 2, 2)};
  const auto values = fitted(fine, coarse);
  double sum = 0, expected = 0;
  for (const float value : values) sum += value;
  for (int i = 0; i < 64; ++i) expected += fine.values[static_cast<std::size_t>(i)] / 64;
  EXPECT_NEAR(sum, expected, 1e-4);
}

TEST(GridDescription, FramesWithTheSameMetadataShareThem) {
  const MetadataList a{{"x", "int32", "1234"}}, b{{"x", "int32", "5678"}};
  FrameMetadata metadata;
  for (const MetadataList* list : {&a, &a, static_cast<const MetadataList*>(nullptr), &a, &b, &a})
    metadata.add(list);
  EXPECT_EQ(metadata.lists, (std::vector<MetadataList>{a, b}));
  EXPECT_EQ(metadata.listOf, (std::vector{0, 0, -1, 0, 1, 0}));
  EXPECT_EQ(*metadata.at(4), b);
  EXPECT_EQ(metadata.at(2), nullptr);
  EXPECT_EQ(metadata.of({2, 4}).listOf, (std::vector{-1, 0}));
}

}  // namespace
}  // namespace volute
