// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"

namespace volute {

/// A list of voxels; of those that are corners of bricks of cells in 4 bytes each. A view.
class VoxelPlaces {
 public:
  using Place = std::array<std::int32_t, 3>;

  static constexpr std::uint32_t kSide = BrickSlice::kSide + 1;
  static constexpr std::uint32_t kCorners = kSide * kSide * kSide;

  VoxelPlaces() = default;

  VoxelPlaces(const std::vector<Place>& places) : places_(places) {}

  /// @param corners  of bricks: kCorners times the brick, and which one it is, x fastest; a cell's
  /// first corner is the voxel before it
  /// @param places  those behind them
  VoxelPlaces(std::span<const std::uint32_t> corners, std::span<const BrickSlice::Entry> bricks,
              std::span<const Place> places)
      : corners_(corners), bricks_(bricks), places_(places) {}

  std::size_t size() const { return corners_.size() + places_.size(); }

  Place operator[](std::size_t i) const {
    if (i >= corners_.size())
      return places_[i - corners_.size()];
    const BrickPlace& brick = bricks_[corners_[i] / kCorners].place;
    const std::uint32_t at = corners_[i] % kCorners;
    return {BrickSlice::kSide * brick[0] + static_cast<std::int32_t>(at % kSide) - 1,
            BrickSlice::kSide * brick[1] + static_cast<std::int32_t>(at / kSide % kSide) - 1,
            BrickSlice::kSide * brick[2] + static_cast<std::int32_t>(at / kSide / kSide) - 1};
  }

 private:
  std::span<const std::uint32_t> corners_;
  std::span<const BrickSlice::Entry> bricks_;
  std::span<const Place> places_;
};

}  // namespace volute
