// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/select_frames.hpp"

#include <utility>

namespace volute {
namespace {

class SelectedFrames final : public FrameSource {
 public:
  SelectedFrames(std::unique_ptr<FrameSource> source, std::vector<int> positions)
      : source_(std::move(source)), positions_(std::move(positions)), info_(source_->info()) {
    info_.frames = static_cast<int>(positions_.size());
    info_.frameNumbers.clear();
    info_.times.clear();
    for (const int position : positions_) {
      info_.frameNumbers.push_back(source_->info().frameNumbers[position]);
      info_.times.push_back(source_->info().times[position]);
    }
  }

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override {
    return source_->readFrame(positions_[index], values);
  }

  bool readsLayers() const override { return source_->readsLayers(); }

  [[nodiscard]] Status readLayers(int index, int first, int end, std::span<float> values) override {
    return source_->readLayers(positions_[index], first, end, values);
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::vector<int> positions_;
  VolumeInfo info_;
};

}  // namespace

Result<std::vector<int>> selectPositions(const VolumeInfo& info, const FrameRange& range) {
  const int first = range.begin.value_or(info.frameNumbers.front());
  std::vector<int> positions;
  for (int i = 0; i < info.frames; ++i) {
    const std::int64_t offset = static_cast<std::int64_t>(info.frameNumbers[i]) - first;
    const bool inside = offset >= 0 && (!range.end || info.frameNumbers[i] < *range.end);
    if (inside && offset % range.step == 0)
      positions.push_back(i);
  }
  if (positions.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "frames {} select nothing; the input has frames {} to {}", toString(range),
                info.frameNumbers.front(), info.frameNumbers.back());
  }
  return positions;
}

Result<std::unique_ptr<FrameSource>> selectFrames(std::unique_ptr<FrameSource> source,
                                                  const FrameRange& range) {
  VOLUTE_ASSIGN(auto positions, selectPositions(source->info(), range));
  return std::make_unique<SelectedFrames>(std::move(source), std::move(positions));
}

std::string toString(const FrameRange& range) {
  std::string text = fmt::format("{}:", range.begin ? std::to_string(*range.begin) : "");
  if (range.end)
    text += std::to_string(*range.end);
  if (range.step != 1)
    text += fmt::format(":{}", range.step);
  return text;
}

}  // namespace volute
