// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <string>
#include <vector>

#include "volute/codec/volute_reader.hpp"

namespace volute {
namespace {

class VoluteSource final : public FrameSource {
 public:
  explicit VoluteSource(std::shared_ptr<const VoluteReader> reader) : reader_(std::move(reader)) {}

  const VolumeInfo& info() const override { return reader_->info(); }

  std::vector<std::string> otherGrids() const override {
    std::vector<std::string> names;
    for (const VoluteGrid& grid : reader_->grids()) {
      if (grid.info.name != info().name)
        names.push_back(grid.info.name);
    }
    return names;
  }

  Status readFrame(int index, std::span<float> values) override {
    const VolumeInfo& volume = info();
    if (index < 0 || index >= volume.frames || values.size() != volume.frameValues()) {
      return fail(ErrorCode::kInvalidArgument,
                  "frame {} of {} was asked for with room for {} values", index, volume.frames,
                  values.size());
    }
    const int row = index / BlockGrid::kSide;
    const int first = row * BlockGrid::kSide;
    const std::size_t frames =
        static_cast<std::size_t>(std::min(BlockGrid::kSide, volume.frames - first));
    if (4 * frames * volume.frameValues() > reader_->maxMemory()) {
      // No room for a row: its blocks are decoded again for each of its frames.
      return reader_->readRegion(index, {0, 0, 0}, {volume.z, volume.y, volume.x}, values);
    }
    if (row != row_) {
      row_ = -1;
      values_.resize(frames * volume.frameValues());
      VOLUTE_TRY(reader_->readRow(row, values_));
      row_ = row;
    }
    const auto from =
        values_.begin() + static_cast<std::ptrdiff_t>((index - first) * volume.frameValues());
    std::copy_n(from, values.size(), values.begin());
    return {};
  }

 private:
  std::shared_ptr<const VoluteReader> reader_;
  std::vector<float> values_;  // the frames of row row_
  int row_ = -1;
};

}  // namespace

std::unique_ptr<FrameSource> frameSource(std::shared_ptr<const VoluteReader> reader) {
  return std::make_unique<VoluteSource>(std::move(reader));
}

}  // namespace volute
