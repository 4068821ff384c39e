// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <utility>

#include "volute/grid/rounding_source.hpp"

namespace volute {

/// Forwards to another source; derived classes override what they change.
class WrappedSource : public RoundingSource {
 public:
  explicit WrappedSource(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  const VolumeInfo& info() const override { return source_->info(); }

  std::vector<std::string> otherGrids() const override { return source_->otherGrids(); }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override {
    return source_->readFrame(index, values);
  }

  bool readsLayers() const override { return source_->readsLayers(); }

  [[nodiscard]] Status readLayers(int index, int first, int end, std::span<float> values) override {
    return source_->readLayers(index, first, end, values);
  }

  using FrameSource::readBricks;

  [[nodiscard]] Status readBricks(int index, int first, int end, Bricks& bricks) override {
    return source_->readBricks(index, first, end, bricks);
  }

  bool hasTopology() const override { return source_->hasTopology(); }

  std::uint64_t brickBytes() const override { return source_->brickBytes(); }

  double rounding() const override { return roundingOf(*source_); }

  double offset() const override { return offsetOf(*source_); }

 protected:
  std::unique_ptr<FrameSource> source_;
};

}  // namespace volute
