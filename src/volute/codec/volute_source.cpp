// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "volute/codec/volute_reader.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

class VoluteSource final : public RoundingSource {
 public:
  explicit VoluteSource(std::shared_ptr<const VoluteReader> reader) : reader_(std::move(reader)) {}

  const VolumeInfo& info() const override { return reader_->info(); }

  double rounding() const override { return 0; }

  double offset() const override { return reader_->offset(); }

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
    const BlockGrid& grid = reader_->blocks();
    const int row = grid.rowOf(index);
    const int first = row * grid.frames();
    if (row == brickRow_) {
      brickRow_ = -1;
      bricks_.clear();
    }
    const auto frames = static_cast<std::size_t>(grid.endOfRow(row) - first);
    if (row != row_ && (isAlone(index) || 4 * frames * volume.frameValues() > reader_->maxMemory()))
      return reader_->readRegion(index, {0, 0, 0}, {volume.z, volume.y, volume.x}, values);
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

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    const BlockGrid& grid = reader_->blocks();
    const int row = grid.rowOf(index);
    const int begin = row * grid.frames();
    if (row != brickRow_) {
      brickRow_ = -1;
      row_ = -1;
      values_ = {};
      if (isAlone(index) || reader_->brickBytes(row) > reader_->maxMemory()) {
        VOLUTE_TRY(reader_->readBricks(index, index + 1, std::span(&bricks, 1)));
        return cropLayers(first, end, bricks);
      }
      const int last = grid.endOfRow(row);
      bricks_.resize(static_cast<std::size_t>(last - begin));
      VOLUTE_TRY(reader_->readBricks(begin, last, bricks_));
      brickRow_ = row;
    }
    bricks = bricks_[static_cast<std::size_t>(index - begin)];
    return cropLayers(first, end, bricks);
  }

  bool hasTopology() const override { return reader_->hasTopology(); }

  std::uint64_t brickBytes() const override {
    std::uint64_t most = 0;
    const BlockGrid& grid = reader_->blocks();
    for (int row = 0; row < grid.counts()[0]; ++row) {
      const int frames = grid.endOfRow(row) - row * grid.frames();
      most = std::max(most, reader_->brickBytes(row) / static_cast<std::uint64_t>(frames));
    }
    return std::min(most, FrameSource::brickBytes());
  }

 private:
  /// Frames beside each other, in either order, are decoded together, a row of blocks at a time.
  /// One that is beside none is decoded for itself, in half of the time; the first of a small row,
  /// which costs little and which others mostly follow, with its row.
  bool isAlone(int index) {
    constexpr std::uint64_t kSmallRow = 64 << 20;
    const bool beside = std::abs(index - last_) == 1;
    last_ = index;
    const BlockGrid& grid = reader_->blocks();
    return !beside &&
           (index % grid.frames() != 0 || reader_->brickBytes(grid.rowOf(index)) > kSmallRow);
  }

  Status cropLayers(int first, int end, Bricks& bricks) const {
    if (first > 0 || end < info().z)
      bricks.crop({{0, 0, first}, {info().x, info().y, end}});
    return {};
  }

  std::shared_ptr<const VoluteReader> reader_;
  std::vector<Bricks> bricks_;  // of row brickRow_
  int brickRow_ = -1;
  std::vector<float> values_;  // the frames of row row_
  int row_ = -1;
  int last_ = -2;  // frame that was asked for last
};

}  // namespace

std::unique_ptr<FrameSource> frameSource(std::shared_ptr<const VoluteReader> reader) {
  return std::make_unique<VoluteSource>(std::move(reader));
}

}  // namespace volute
