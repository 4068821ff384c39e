// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/select_frames.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "volute/grid/wrapped_source.hpp"

namespace volute {
namespace {

class SelectedFrames final : public WrappedSource {
 public:
  SelectedFrames(std::unique_ptr<FrameSource> source, std::vector<int> positions,
                 const StatedInfo& stated = {})
      : WrappedSource(std::move(source)), positions_(std::move(positions)), info_(source_->info()) {
    if (stated.framesPerSecond)
      info_.setRate(*stated.framesPerSecond);
    if (stated.up != 0)
      info_.up = stated.up;
    const std::vector<double> times = std::move(info_.times);
    info_.frames = static_cast<int>(positions_.size());
    info_.frameNumbers.clear();
    info_.times.clear();
    for (const int position : positions_) {
      info_.frameNumbers.push_back(source_->info().frameNumbers[position]);
      info_.times.push_back(times[static_cast<std::size_t>(position)]);
    }
  }

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override {
    return source_->readFrame(positions_[index], values);
  }

  [[nodiscard]] Status readLayers(int index, int first, int end, std::span<float> values) override {
    return source_->readLayers(positions_[index], first, end, values);
  }

  [[nodiscard]] Status readBricks(int index, int first, int end, Bricks& bricks) override {
    return source_->readBricks(positions_[index], first, end, bricks);
  }

 private:
  std::vector<int> positions_;
  VolumeInfo info_;
};

}  // namespace

std::vector<int> selectPositions(std::span<const int> numbers, FrameScale scale,
                                 const FrameRange& range) {
  const double first = range.begin.value_or(numbers.empty() ? 0 : scale.frame(numbers.front()));
  std::vector<int> positions;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double frame = scale.frame(numbers[i]), offset = frame - first;
    const bool inside = offset >= 0 && (!range.end || frame < *range.end);
    const double steps = std::round(offset / range.step) * range.step;
    if (inside && (range.step == 1 || std::abs(offset - steps) < 1e-7))
      positions.push_back(static_cast<int>(i));
  }
  return positions;
}

Result<std::vector<int>> selectPositions(const VolumeInfo& info, const FrameRange& range) {
  auto positions = selectPositions(info.frameNumbers, info.frameScale, range);
  if (positions.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "frames {} select nothing; the input has frames {} to {}", toString(range),
                info.frameText(0), info.frameText(info.frames - 1));
  }
  return positions;
}

Result<std::unique_ptr<FrameSource>> selectFrames(std::unique_ptr<FrameSource> source,
                                                  const FrameRange& range) {
  VOLUTE_ASSIGN(auto positions, selectPositions(source->info(), range));
  return std::make_unique<SelectedFrames>(std::move(source), std::move(positions));
}

std::unique_ptr<FrameSource> asStated(std::unique_ptr<FrameSource> source,
                                      const StatedInfo& stated) {
  if (!stated.framesPerSecond && stated.up == 0)
    return source;
  std::vector<int> all(static_cast<std::size_t>(source->info().frames));
  std::iota(all.begin(), all.end(), 0);
  return std::make_unique<SelectedFrames>(std::move(source), std::move(all), stated);
}

FrameRange FrameRange::only(double frame) {
  return {frame, std::nextafter(frame, std::numeric_limits<double>::infinity()), 1};
}

std::string beyondText(const FrameRange& range, std::span<const int> numbers, FrameScale scale) {
  const double first = scale.frame(numbers.front()), last = scale.frame(numbers.back());
  const double step = std::max((last - first) / std::max(std::ssize(numbers) - 1.0, 1.0), 1.0);
  const double begin = range.begin.value_or(first), end = range.end.value_or(begin);
  const double lastAsked = begin + range.step * (std::ceil((end - begin) / range.step) - 1);
  if (begin >= first - step && lastAsked <= last + step - 1)
    return "";
  return fmt::format("frames {} are asked for; it has {} to {}", toString(range),
                     frameText(numbers.front(), scale), frameText(numbers.back(), scale));
}

std::string toString(const FrameRange& range) {
  const auto number = [](const std::optional<double>& one) {
    return one ? fmt::format("{}", *one) : std::string();
  };
  if (range.begin && range.end && *range.end == FrameRange::only(*range.begin).end)
    return number(range.begin);
  std::string text = number(range.begin) + ':' + number(range.end);
  if (range.step != 1)
    text += fmt::format(":{}", range.step);
  return text;
}

}  // namespace volute
