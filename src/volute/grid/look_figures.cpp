// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/look_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <vector>

#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

Result<LookFigures> lookFigures(FrameSource& source) {
  constexpr int kSide = Bricks::kSide, kPlane = kSide * kSide;
  constexpr std::int64_t kLargest = 512;  // of a tile beyond one column stands for all
  const VolumeInfo& info = source.info();
  const IndexBox whole{{0, 0, 0}, {info.x, info.y, info.z}};
  const double offset = offsetOf(source);
  LookFigures range;
  const std::set<int> frames{info.frames / 4, info.frames / 2, info.frames - 1};
  const double step = info.bounds.size().z() / info.z;
  const auto channels = static_cast<std::size_t>(info.channels);
  // A dense frame may be larger than memory.
  constexpr std::size_t kValues = std::size_t{1} << 22;
  const std::size_t layer = info.frameValues() / static_cast<std::size_t>(info.z);
  const bool byLayers = !source.hasTopology() && source.readsLayers();
  const int together =
      byLayers
          ? static_cast<int>(std::clamp<std::size_t>(kValues / layer / kSide, 1, info.z)) * kSide
          : info.z;
  for (const int frame : frames) {
    std::map<std::array<std::int64_t, 2>, std::vector<double>> columns;  // of leaves, by x and y
    const auto columnsAt = [&](std::int64_t x, std::int64_t y) -> std::vector<double>& {
      auto& found = columns[{x, y}];
      found.resize(kPlane * channels, 0);
      return found;
    };
    const auto extend = [&](float value) {
      range.least = std::min<double>(range.least, value);
      range.most = std::max<double>(range.most, value);
    };
    const auto add = [&](const Bricks& bricks) {
      for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
        const VoxelIndex& origin = bricks.leaves()[i].origin;
        const BrickMask inside = maskInside(origin, whole);
        std::vector<double>& sums = columnsAt(origin[0], origin[1]);
        for (std::size_t c = 0; c < channels; ++c) {
          for (std::size_t at = 0; at < Bricks::kVoxels; ++at) {
            const float value = bricks.values(i)[c * Bricks::kVoxels + at];
            if (!std::isfinite(value) || (inside[at / kPlane] >> (at % kPlane) & 1) == 0)
              continue;
            extend(value);
            sums[at % kPlane * channels + c] += step * std::max(value, 0.0F);
          }
        }
      }
      for (const Bricks::Tile& tile : bricks.tiles()) {
        const IndexBox part = tile.box().intersection(whole);
        for (std::size_t c = 0; c < channels && !part.empty(); ++c) {
          if (std::isfinite(tile.value[c]))
            extend(tile.value[c]);
        }
        if (part.empty() || !(tile.value[0] > 0))
          continue;
        const std::int64_t apart = tile.side > kLargest ? tile.side : kSide;
        for (std::int64_t y = 0; y < tile.side; y += apart) {
          for (std::int64_t x = 0; x < tile.side; x += apart) {
            for (double& sum : columnsAt(tile.origin[0] + x, tile.origin[1] + y))
              sum += step * static_cast<double>(part.size(2)) * tile.value[0];
          }
        }
      }
    };
    for (int first = 0; first < info.z; first += together) {
      Bricks bricks;
      VOLUTE_TRY(source.readBricks(frame, first, std::min(info.z, first + together), bricks));
      add(offset == 0 ? bricks : raised(bricks, offset));
    }
    std::vector<double> sums;
    for (const auto& [place, those] : columns)
      std::ranges::copy_if(those, std::back_inserter(sums), [](double sum) { return sum > 0; });
    if (sums.empty())
      continue;
    const auto rank = static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(sums.size() - 1));
    std::ranges::nth_element(sums, sums.begin() + rank);
    range.column = std::max(range.column, sums[static_cast<std::size_t>(rank)]);
  }
  return range;
}

}  // namespace volute
