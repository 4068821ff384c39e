// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/lone_frame.hpp"

#include <algorithm>
#include <utility>

#include "volute/grid/rounding_source.hpp"

namespace volute {

class LoneFrame::Source final : public RoundingSource {
 public:
  Source(std::unique_ptr<FrameSource> source, std::shared_ptr<LoneFrame> frame)
      : source_(std::move(source)), frame_(std::move(frame)) {}

  const VolumeInfo& info() const override { return source_->info(); }

  std::vector<std::string> otherGrids() const override { return source_->otherGrids(); }

  Status readFrame(int index, std::span<float> values) override {
    return source_->readFrame(index, values);
  }

  bool readsLayers() const override { return source_->readsLayers(); }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    return source_->readLayers(index, first, end, values);
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    if (first > 0 || end < info().z)
      return source_->readBricks(index, first, end, bricks);
    auto& kept = frame_->kept_;
    const auto found = kept.find(info().name);
    if (found == kept.end()) {
      VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
      if (!frame_->last_)
        kept.emplace(info().name, bricks);
    } else if (!frame_->last_) {
      bricks = found->second;
    } else {
      bricks = std::move(found->second);
      kept.erase(found);
    }
    return {};
  }

  bool hasTopology() const override { return source_->hasTopology(); }

  std::uint64_t brickBytes() const override { return source_->brickBytes(); }

  double rounding() const override { return roundingOf(*source_); }

  double offset() const override { return offsetOf(*source_); }

 private:
  std::unique_ptr<FrameSource> source_;
  std::shared_ptr<LoneFrame> frame_;
};

std::unique_ptr<FrameSource> LoneFrame::keeping(std::unique_ptr<FrameSource> source,
                                                std::shared_ptr<LoneFrame> frame) {
  if (source->info().frames != 1 || !source->hasTopology())
    return source;
  return std::make_unique<Source>(std::move(source), std::move(frame));
}

void LoneFrame::keepOnly(const std::vector<std::string>& grids) {
  std::erase_if(
      kept_, [&](const auto& one) { return std::ranges::find(grids, one.first) == grids.end(); });
}

}  // namespace volute
