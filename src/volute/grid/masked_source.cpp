// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/masked_source.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "volute/grid/bricks.hpp"
#include "volute/grid/wrapped_source.hpp"

namespace volute {
namespace {

bool hasValue(float value) {
  return std::isfinite(value);
}

void setVoxel(BrickMask& mask, std::size_t at, bool on) {
  const std::uint64_t bit = std::uint64_t{1} << at % 64;
  mask[at / 64] = on ? mask[at / 64] | bit : mask[at / 64] & ~bit;
}

class MaskedSource final : public WrappedSource {
 public:
  using WrappedSource::WrappedSource;

  Status readFrame(int index, std::span<float> values) override {
    return readLayers(index, 0, info().z, values);
  }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    VOLUTE_TRY(source_->readLayers(index, first, end, values));
    if (std::ranges::all_of(values, hasValue))
      return {};
    const auto channels = static_cast<std::size_t>(info().channels);
    auto background = zero();
    if (source_->hasTopology()) {
      Bricks bricks;
      VOLUTE_TRY(source_->readBricks(index, 0, 1, bricks));
      background = bricks.background();
    }
    for (std::size_t at = 0; at < values.size(); at += channels) {
      const auto voxel = values.subspan(at, channels);
      if (!std::ranges::all_of(voxel, hasValue))
        std::copy_n(background.begin(), channels, voxel.begin());
    }
    return {};
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    if (!source_->hasTopology())
      return readActive(index, first, end, bricks);
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    const auto background = bricks.background();
    const auto channels = static_cast<std::size_t>(bricks.channels());
    Bricks finite(bricks.channels(), background);
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      const auto from = std::as_const(bricks).values(i);
      Bricks::Leaf leaf = bricks.leaves()[i];
      const auto isHole = [&](std::size_t at) {
        for (std::size_t c = 0; c < channels; ++c) {
          if (!hasValue(from[c * Bricks::kVoxels + at]))
            return true;
        }
        return false;
      };
      for (std::size_t at = 0; at < Bricks::kVoxels; ++at) {
        if (!isHole(at))
          continue;
        setVoxel(leaf.active, at, false);
        setVoxel(leaf.valued, at, false);
      }
      const auto to = finite.addLeaf(leaf);
      for (std::size_t k = 0; k < from.size(); ++k)
        to[k] = isHole(k % Bricks::kVoxels) ? background[k / Bricks::kVoxels] : from[k];
    }
    for (const Bricks::Tile& tile : bricks.tiles()) {
      if (std::all_of(tile.value.begin(), tile.value.begin() + bricks.channels(), hasValue))
        finite.addTile(tile);
    }
    finite.setLeftOut(bricks.leftOut());
    bricks = std::move(finite);
    return {};
  }

  bool hasTopology() const override { return true; }

 private:
  std::array<float, 3> zero() const {
    std::array<float, 3> background{};
    background.fill(static_cast<float>(0 - offset()));
    return background;
  }

  Status readActive(int index, int first, int end, Bricks& bricks) {
    const auto channels = static_cast<std::size_t>(info().channels);
    const std::int64_t width = info().x, rows = info().y;
    std::vector<float> values(static_cast<std::size_t>(width * rows * (end - first)) * channels);
    VOLUTE_TRY(source_->readLayers(index, first, end, values));
    bricks = Bricks(info().channels, zero());
    constexpr std::int64_t kSide = Bricks::kSide;
    /// call(place in the leaf, values) for each voxel of the leaf at `origin` that is there.
    const auto eachVoxel = [&](const VoxelIndex& origin, auto&& call) {
      const std::int64_t endZ = std::min<std::int64_t>(origin[2] + kSide, end);
      for (std::int64_t z = std::max<std::int64_t>(origin[2], first); z < endZ; ++z) {
        for (std::int64_t y = origin[1]; y < std::min(origin[1] + kSide, rows); ++y) {
          for (std::int64_t x = origin[0]; x < std::min(origin[0] + kSide, width); ++x) {
            const auto voxel = static_cast<std::size_t>(((z - first) * rows + y) * width + x);
            const auto value = std::span(values).subspan(voxel * channels, channels);
            if (std::ranges::all_of(value, hasValue)) {
              call(static_cast<std::size_t>(((z - origin[2]) * kSide + y - origin[1]) * kSide + x -
                                            origin[0]),
                   value);
            }
          }
        }
      }
    };
    for (std::int64_t z = first / kSide * kSide; z < end; z += kSide) {
      for (std::int64_t y = 0; y < rows; y += kSide) {
        for (std::int64_t x = 0; x < width; x += kSide) {
          Bricks::Leaf leaf{{x, y, z}};
          eachVoxel(leaf.origin, [&](std::size_t at, auto&&) { setVoxel(leaf.active, at, true); });
          if (leaf.active == BrickMask{})
            continue;
          leaf.valued = leaf.active;
          const auto to = bricks.addLeaf(leaf);
          eachVoxel(leaf.origin, [&](std::size_t at, std::span<const float> value) {
            for (std::size_t c = 0; c < channels; ++c) to[c * Bricks::kVoxels + at] = value[c];
          });
        }
      }
    }
    bricks.sort();
    return {};
  }
};

}  // namespace

std::unique_ptr<FrameSource> withoutHoles(std::unique_ptr<FrameSource> source) {
  return std::make_unique<MaskedSource>(std::move(source));
}

}  // namespace volute
