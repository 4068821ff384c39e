// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <utility>

#include "volute/grid/bricks.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute::gridtest {

/// One frame with its topology, as it is given.
class OneFrame final : public FrameSource {
 public:
  OneFrame(VolumeInfo info, Bricks bricks) : info_(std::move(info)), bricks_(std::move(bricks)) {}

  using FrameSource::readBricks;

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int, std::span<float> values) override {
    bricks_.toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}}, values);
    return {};
  }

  Status readBricks(int, int, int, Bricks& bricks) override {
    bricks = bricks_;
    return {};
  }

  bool hasTopology() const override { return true; }

 private:
  VolumeInfo info_;
  Bricks bricks_;
};

}  // namespace volute::gridtest
