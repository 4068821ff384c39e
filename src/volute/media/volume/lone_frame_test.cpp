// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/lone_frame.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

/// One leaf in each frame, whose values count how often it was read.
class CountingSource final : public FrameSource {
 public:
  CountingSource(int frames, std::string name, int& reads) : reads_(reads) {
    info_.x = info_.y = info_.z = 8;
    info_.frames = frames;
    info_.name = std::move(name);
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int, std::span<float>) override { return {}; }

  Status readBricks(int, int, int, Bricks& bricks) override {
    Bricks made;
    Bricks::Leaf leaf;
    leaf.active[0] = leaf.valued[0] = 1;
    made.addLeaf(leaf)[0] = static_cast<float>(++reads_);
    bricks = std::move(made);
    return {};
  }

  bool hasTopology() const override { return true; }

 private:
  VolumeInfo info_;
  int& reads_;
};

float firstValue(FrameSource& source) {
  Bricks bricks;
  EXPECT_TRUE(source.readBricks(0, bricks).has_value());
  EXPECT_EQ(bricks.leaves().size(), 1u);
  return std::as_const(bricks).values(0)[0];
}

TEST(LoneFrame, IsReadOnceByAllUntilItIsDrawn) {
  int reads = 0;
  const auto frame = std::make_shared<LoneFrame>();
  const auto preset =
      LoneFrame::keeping(std::make_unique<CountingSource>(1, "density", reads), frame);
  const auto medium =
      LoneFrame::keeping(std::make_unique<CountingSource>(1, "density", reads), frame);
  EXPECT_EQ(firstValue(*preset), 1);
  EXPECT_EQ(firstValue(*medium), 1);
  frame->handOver();
  EXPECT_EQ(firstValue(*medium), 1);
  EXPECT_EQ(reads, 1);
  EXPECT_EQ(firstValue(*medium), 2) << "nothing is kept for ever";
  EXPECT_EQ(firstValue(*medium), 3);
}

TEST(LoneFrame, GridsAreKeptApartAndThoseThatNobodyDrawsAreForgotten) {
  int density = 0, heat = 0;
  const auto frame = std::make_shared<LoneFrame>();
  const auto one =
                 LoneFrame::keeping(std::make_unique<CountingSource>(1, "density", density), frame),
             other = LoneFrame::keeping(std::make_unique<CountingSource>(1, "heat", heat), frame);
  firstValue(*one), firstValue(*other);
  frame->keepOnly({"density"});
  firstValue(*one), firstValue(*other);
  EXPECT_EQ(density, 1);
  EXPECT_EQ(heat, 2);
}

TEST(LoneFrame, FramesOfASequenceAreNotKept) {
  int reads = 0;
  const auto frame = std::make_shared<LoneFrame>();
  const auto source =
      LoneFrame::keeping(std::make_unique<CountingSource>(2, "density", reads), frame);
  firstValue(*source), firstValue(*source);
  EXPECT_EQ(reads, 2);
}

}  // namespace
}  // namespace volute
