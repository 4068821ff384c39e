// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/finite_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

bool isFinite(float value) {
  return std::isfinite(value);
}

class FiniteSource final : public RoundingSource {
 public:
  explicit FiniteSource(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  const VolumeInfo& info() const override { return source_->info(); }

  std::vector<std::string> otherGrids() const override { return source_->otherGrids(); }

  Status readFrame(int index, std::span<float> values) override {
    VOLUTE_TRY(source_->readFrame(index, values));
    return replace(index, values);
  }

  bool readsLayers() const override { return source_->readsLayers(); }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    VOLUTE_TRY(source_->readLayers(index, first, end, values));
    return replace(index, values);
  }

  double rounding() const override { return roundingOf(*source_); }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    Bricks finite(bricks.channels(), bricks.background());
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      const auto from = std::as_const(bricks).values(i);
      const auto to = finite.addLeaf(bricks.leaves()[i]);
      for (std::size_t k = 0; k < from.size(); ++k)
        to[k] = isFinite(from[k]) ? from[k] : bricks.background()[k / Bricks::kVoxels];
    }
    for (Bricks::Tile tile : bricks.tiles()) {
      for (std::size_t c = 0; c < tile.value.size(); ++c)
        tile.value[c] = isFinite(tile.value[c]) ? tile.value[c] : bricks.background()[c];
      finite.addTile(tile);
    }
    bricks = std::move(finite);
    return {};
  }

  bool hasTopology() const override { return source_->hasTopology(); }

  std::uint64_t brickBytes() const override { return source_->brickBytes(); }

 private:
  Status replace(int index, std::span<float> values) {
    if (std::ranges::all_of(values, isFinite))
      return {};
    std::array<float, 3> background{};
    if (source_->hasTopology()) {
      Bricks bricks;
      VOLUTE_TRY(source_->readBricks(index, 0, 1, bricks));
      background = bricks.background();
    }
    const auto channels = static_cast<std::size_t>(info().channels);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = isFinite(values[i]) ? values[i] : background[i % channels];
    return {};
  }

  std::unique_ptr<FrameSource> source_;
};

/// Of a frame, in its volume.
std::optional<std::pair<VoxelIndex, float>> notFiniteIn(const Bricks& bricks) {
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
    const auto& leaf = bricks.leaves()[i];
    const auto values = bricks.values(i);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t at = k % Bricks::kVoxels;
      if (!isFinite(values[k]) && (leaf.valued[at / 64] >> at % 64 & 1) != 0)
        return std::pair(VoxelIndex{leaf.origin[0] + static_cast<std::int64_t>(at % 8),
                                    leaf.origin[1] + static_cast<std::int64_t>(at / 8 % 8),
                                    leaf.origin[2] + static_cast<std::int64_t>(at / 64)},
                         values[k]);
    }
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    for (int c = 0; c < bricks.channels(); ++c) {
      const float value = tile.value[static_cast<std::size_t>(c)];
      if (!isFinite(value))
        return std::pair(tile.origin, value);
    }
  }
  return std::nullopt;
}

}  // namespace

std::unique_ptr<FrameSource> asFinite(std::unique_ptr<FrameSource> source) {
  return std::make_unique<FiniteSource>(std::move(source));
}

std::optional<std::string> firstNotFinite(FrameSource& source, const GridDescription* description) {
  const VolumeInfo& info = source.info();
  Bricks bricks;
  for (int frame = 0; frame < info.frames; ++frame) {
    if (!source.readBricks(frame, bricks))
      return std::nullopt;
    const auto found = notFiniteIn(bricks);
    if (!found)
      continue;
    VoxelIndex index = found->first;
    Vec3 place = info.bounds.min;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      place[a] += (static_cast<double>(index[axis]) + 0.5) * info.voxelSize()[a];
      if (!description)
        continue;
      index[axis] += description->begin[axis];
      if (!description->shifts.empty())
        index[axis] -= description->shifts[static_cast<std::size_t>(frame)][axis];
    }
    if (description && !description->matrices.empty()) {
      const auto matrix = description->places()[static_cast<std::size_t>(frame)];
      place = linearOf(matrix) * place + offsetOf(matrix);
    }
    return fmt::format(
        "frame {}: the value at index ({}, {}, {}), which is ({:.6g}, {:.6g}, {:.6g}) m, is {}",
        info.frameText(static_cast<std::size_t>(frame)), index[0], index[1], index[2], place.x(),
        place.y(), place.z(), std::isnan(found->second) ? "not a number" : "infinite");
  }
  return std::nullopt;
}

}  // namespace volute
