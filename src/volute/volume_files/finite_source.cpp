// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/finite_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "volute/base/plain_number.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/masked_source.hpp"
#include "volute/grid/wrapped_source.hpp"

namespace volute {
namespace {

bool isFinite(float value) {
  return std::isfinite(value);
}

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

/// Counts what is replaced in the layers that are read.
class CountedSource final : public WrappedSource {
 public:
  CountedSource(std::unique_ptr<FrameSource> source, std::shared_ptr<ReplacedValues> counts)
      : WrappedSource(std::move(source)), counts_(std::move(counts)) {}

  Status readFrame(int index, std::span<float> values) override {
    VOLUTE_TRY(source_->readFrame(index, values));
    count(index, 0, values);
    return {};
  }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    VOLUTE_TRY(source_->readLayers(index, first, end, values));
    count(index, first, values);
    return {};
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    if (!notFiniteIn(bricks))
      return {};
    std::map<std::int64_t, std::uint64_t> layers;
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      const auto& leaf = bricks.leaves()[i];
      const auto values = std::as_const(bricks).values(i);
      for (std::size_t k = 0; k < values.size(); ++k) {
        const std::size_t at = k % Bricks::kVoxels;
        if (!isFinite(values[k]) && (leaf.valued[at / 64] >> at % 64 & 1) != 0)
          ++layers[leaf.origin[2] + static_cast<std::int64_t>(at / 64)];
      }
    }
    const IndexBox slab{{0, 0, first}, {info().x, info().y, end}};
    for (const Bricks::Tile& tile : bricks.tiles()) {
      const auto bad = static_cast<std::uint64_t>(std::count_if(
          tile.value.begin(), tile.value.begin() + bricks.channels(), std::not_fn(isFinite)));
      const IndexBox part = tile.box().intersection(slab);
      for (std::int64_t z = part.begin[2]; bad > 0 && z < part.end[2]; ++z)
        layers[z] += bad * static_cast<std::uint64_t>(part.size(0) * part.size(1));
    }
    for (const auto& [layer, count] : layers) {
      if (layer >= first && layer < end)
        counts_->set(index, static_cast<int>(layer), count);
    }
    return {};
  }

 private:
  void count(int index, int first, std::span<const float> values) {
    const std::size_t layer = info().frameValues() / static_cast<std::size_t>(info().z);
    for (std::size_t at = 0; at < values.size(); at += layer) {
      const auto bad = std::ranges::count_if(values.subspan(at, layer), std::not_fn(isFinite));
      counts_->set(index, first + static_cast<int>(at / layer), static_cast<std::uint64_t>(bad));
    }
  }

  std::shared_ptr<ReplacedValues> counts_;
};

class FiniteSource final : public WrappedSource {
 public:
  FiniteSource(std::unique_ptr<FrameSource> source, NotFinite what, std::string path)
      : WrappedSource(std::move(source)),
        placed_(dynamic_cast<const PlacedFrames*>(source_.get())),
        refuses_(what == NotFinite::kRefuse),
        path_(std::move(path)) {}

  Status readFrame(int index, std::span<float> values) override {
    VOLUTE_TRY(source_->readFrame(index, values));
    return replace(index, 0, values);
  }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    VOLUTE_TRY(source_->readLayers(index, first, end, values));
    return replace(index, first, values);
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    const auto bad = notFiniteIn(bricks);
    if (!bad)
      return {};
    if (refuses_)
      return refuse(index, bad->first, bad->second);
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
    finite.setLeftOut(bricks.leftOut());
    bricks = std::move(finite);
    return {};
  }

 private:
  /// @param first  layer of the values
  Status replace(int index, int first, std::span<float> values) {
    const auto bad = std::ranges::find_if_not(values, isFinite);
    if (bad == values.end())
      return {};
    const auto channels = static_cast<std::size_t>(info().channels);
    if (refuses_) {
      const std::int64_t x = info().x, y = info().y;
      const auto voxel = (bad - values.begin()) / static_cast<std::int64_t>(channels);
      return refuse(index, {voxel % x, voxel / x % y, voxel / x / y + first}, *bad);
    }
    std::array<float, 3> background{};
    background.fill(static_cast<float>(0 - offset()));
    if (source_->hasTopology()) {
      Bricks bricks;
      VOLUTE_TRY(source_->readBricks(index, 0, 1, bricks));
      background = bricks.background();
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = isFinite(values[i]) ? values[i] : background[i % channels];
    return {};
  }

  Status refuse(int index, VoxelIndex voxel, float value) const {
    const VolumeInfo& of = info();
    Vec3 place = of.bounds.min;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t a = axis;
      place[a] += (static_cast<double>(voxel[axis]) + 0.5) * of.voxelSize()[a];
    }
    std::string file = path_, what = "voxel";
    if (placed_) {
      const auto& [name, first] = placed_->fileOf(index);
      file = name, what = "index";
      for (std::size_t axis = 0; axis < 3; ++axis) voxel[axis] += first[axis];
      if (!placed_->places().empty()) {
        const GridMatrix& matrix = placed_->places()[static_cast<std::size_t>(index)];
        place = linearOf(matrix) * place + offsetOf(matrix);
      }
    }
    Hints hints{Hint::set("not_finite", "background").so("takes the background for them"),
                Hint::set("not_finite", "inactive").so("makes their voxels inactive, too")};
    if (placed_)
      hints.push_back(Hint::set("keep", of.name).so("keeps the grid as it is"));
    return fail(ErrorCode::kInvalidData, std::move(hints),
                "{}: grid '{}', frame {}: the value at {} ({}, {}, {}), which is ({}, {}, "
                "{}) m, is {}; expected finite values: mend the input, or compress it without "
                "them",
                file, of.name, of.frameText(static_cast<std::size_t>(index)), what, voxel[0],
                voxel[1], voxel[2], plainNumber(place.x()), plainNumber(place.y()),
                plainNumber(place.z()), std::isnan(value) ? "not a number" : "infinite");
  }

  const PlacedFrames* placed_;
  bool refuses_;
  std::string path_;
};

}  // namespace

void ReplacedValues::set(int frame, int layer, std::uint64_t count) {
  if (count > 0)
    counts_[{frame, layer}] = count;
}

std::uint64_t ReplacedValues::count() const {
  std::uint64_t all = 0;
  for (const auto& [layer, count] : counts_) all += count;
  return all;
}

std::unique_ptr<FrameSource> asFinite(std::unique_ptr<FrameSource> source, NotFinite what,
                                      const std::string& path,
                                      std::shared_ptr<ReplacedValues> counts) {
  if (what == NotFinite::kKeep)
    return source;
  if (counts && what != NotFinite::kRefuse)
    source = std::make_unique<CountedSource>(std::move(source), std::move(counts));
  if (what == NotFinite::kInactive)
    return withoutHoles(std::move(source));
  return std::make_unique<FiniteSource>(std::move(source), what, path);
}

}  // namespace volute
