// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/masked_source.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "volute/grid/array_source.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/one_frame_testing.hpp"

namespace volute {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Two frames of 11 x 9 x 10 voxels: numbers, some of them 0, and some NaN.
class MaskedSourceTest : public ::testing::Test {
 protected:
  MaskedSourceTest() {
    info_.frames = 2, info_.x = 11, info_.y = 9, info_.z = 10;
    info_.fillDefaults();
    values_.resize(info_.values());
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i] = i % 7 == 0 ? kNan : i % 5 == 0 ? 0.0F : static_cast<float>(i);
  }

  std::unique_ptr<FrameSource> opened() {
    const NumberType type{NumberKind::kFloat32, false};
    return std::make_unique<ArraySource>(
        info_, NumberArray{reinterpret_cast<const std::byte*>(values_.data()), type,
                           denseStrides(info_, type)});
  }

  VolumeInfo info_;
  std::vector<float> values_;
};

TEST_F(MaskedSourceTest, VoxelsThatAreNotThereAreInactiveAndZerosAreActive) {
  const auto source = withoutHoles(opened());
  EXPECT_TRUE(source->hasTopology());
  for (int frame = 0; frame < 2; ++frame) {
    const std::size_t begin = static_cast<std::size_t>(frame) * info_.frameValues();
    // In layers that are no multiple of a leaf, too.
    for (const auto& [first, end] : {std::pair(0, 10), std::pair(3, 9), std::pair(8, 10)}) {
      Bricks bricks;
      ASSERT_TRUE(source->readBricks(frame, first, end, bricks));
      const std::size_t layer = 11 * 9;
      std::uint64_t active = 0;
      for (std::size_t i = first * layer; i < end * layer; ++i)
        active += !std::isnan(values_[begin + i]);
      EXPECT_EQ(bricks.activeVoxels(), active);
      std::vector<float> dense(layer * static_cast<std::size_t>(end - first));
      bricks.toDense({{0, 0, first}, {11, 9, end}}, dense);
      for (std::size_t i = 0; i < dense.size(); ++i) {
        const float value = values_[begin + first * layer + i];
        ASSERT_EQ(dense[i], std::isnan(value) ? 0 : value) << i;
      }
    }
  }
}

TEST_F(MaskedSourceTest, OfATopologyVoxelsAreTakenOut) {
  Bricks bricks;
  ASSERT_TRUE(opened()->readBricks(0, bricks));
  const auto all = bricks.activeVoxels();
  std::uint64_t holes = 0;
  for (std::size_t i = 0; i < info_.frameValues(); ++i) holes += std::isnan(values_[i]);
  info_.frames = 1, info_.times = {}, info_.frameNumbers = {};
  info_.fillDefaults();
  const auto source = withoutHoles(std::make_unique<gridtest::OneFrame>(info_, bricks));
  Bricks finite;
  ASSERT_TRUE(source->readBricks(0, finite));
  EXPECT_EQ(finite.activeVoxels(), all - holes);
  std::vector<float> dense(info_.frameValues()), frame(info_.frameValues());
  finite.toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}}, dense);
  ASSERT_TRUE(source->readFrame(0, frame));
  EXPECT_EQ(dense, frame);
}

}  // namespace
}  // namespace volute
