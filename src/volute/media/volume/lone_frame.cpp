// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/lone_frame.hpp"

#include <algorithm>
#include <utility>

#include "volute/grid/wrapped_source.hpp"

namespace volute {

class LoneFrame::Source final : public WrappedSource {
 public:
  Source(std::unique_ptr<FrameSource> source, std::shared_ptr<LoneFrame> frame)
      : WrappedSource(std::move(source)), frame_(std::move(frame)) {}

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

 private:
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
