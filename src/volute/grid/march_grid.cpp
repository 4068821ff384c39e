// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "volute/base/parallel.hpp"
#include "volute/grid/voxel_march.hpp"

namespace volute {
namespace {

constexpr int kBrickSide = BrickSlice::kSide;
constexpr int kCornerSide = kBrickSide + 1;
constexpr int kCornersOfBrick = kCornerSide * kCornerSide * kCornerSide;

/// The stored bricks around a brick's cells: its own and those before it on any axes.
using BricksAround = std::array<std::int32_t, 8>;

BricksAround bricksAround(const BrickSlice& slice, const BrickPlace& place) {
  BricksAround around;
  const BrickPlace count{slice.bricksX(), slice.bricksY(), slice.bricksZ()};
  for (int i = 0; i < 8; ++i) {
    const BrickPlace at{place[0] - (i & 1), place[1] - (i >> 1 & 1), place[2] - (i >> 2)};
    const bool inside = at[0] < count[0] && at[1] < count[1] && at[2] < count[2];
    around[static_cast<std::size_t>(i)] = inside ? slice.table().at(at) : BrickSlice::kEmpty;
  }
  return around;
}

/// Fills in the trilinear bricks: all into whose cells a stored brick reaches.
void makeCorners(const BrickSlice& slice, const BrickPlace& count, MarchGrid& grid) {
  // Where all around is of one value or empty, bricks with the same around them are equal.
  std::map<BricksAround, std::int32_t> uniform;
  std::vector<BrickPlace> distinct;
  for (const BrickPlace& place : slice.reached(count, grid.table)) {
    auto number = static_cast<std::int32_t>(distinct.size());
    if (slice.firstUniform() < static_cast<std::int32_t>(slice.storedBricks())) {
      const BricksAround around = bricksAround(slice, place);
      if (std::ranges::all_of(around, [&](std::int32_t stored) {
            return stored == BrickSlice::kEmpty || stored >= slice.firstUniform();
          }))
        number = uniform.try_emplace(around, number).first->second;
    }
    if (number == static_cast<std::int32_t>(distinct.size()))
      distinct.push_back(place);
    grid.bricks.push_back({place, number});
  }
  const std::size_t each = static_cast<std::size_t>(kCornersOfBrick) * slice.channels();
  std::vector<float> corners(distinct.size() * each);
  std::vector<std::int32_t> number(distinct.size());
  parallelRanges(distinct.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      number[i] = copyCorners(slice, distinct[i], &corners[i * each]) ? 0 : -1;
  });
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0)
      continue;
    number[i] = grid.stored++;
    if (static_cast<std::size_t>(number[i]) != i)
      std::copy_n(&corners[i * each], each, &corners[static_cast<std::size_t>(number[i]) * each]);
  }
  corners.resize(static_cast<std::size_t>(grid.stored) * each);
  if (corners.size() < corners.capacity() / 4 * 3)  // else the copy costs more than the memory
    corners.shrink_to_fit();
  grid.corners = std::make_shared<const std::vector<float>>(std::move(corners));
  for (BrickSlice::Entry& entry : grid.bricks) {
    entry.stored = number[static_cast<std::size_t>(entry.stored)];
    grid.table.set(entry.place, entry.stored);
  }
  std::erase_if(grid.bricks, [](const auto& entry) { return entry.stored < 0; });
}

/// How many Gauss rules keep the optical depth of each at 1.5 on the longest way through a cell.
int gaussSteps(const BrickSlice& slice, const CellGrid& cells, double extinctionScale) {
  constexpr double kMaxDepth = 1.5;
  constexpr double kMaxSteps = 64;
  double largest = 0;
  for (float value : slice.values())
    largest = std::max(largest, std::abs(static_cast<double>(value)));
  const double steps =
      std::ceil(largest * std::abs(extinctionScale) * cells.cell.norm() / kMaxDepth);
  return static_cast<int>(steps < kMaxSteps ? std::max(steps, 1.0) : kMaxSteps);
}

}  // namespace

float packLight(const Rgb& shares) {
  std::uint32_t bits = 0;
  constexpr int kShift[3] = {0, 11, 22};
  for (int c = 0; c < 3; ++c) {
    const double level = kPackedLevels[c] * std::sqrt(std::clamp(shares[c], 0.0, 1.0));
    bits |= static_cast<std::uint32_t>(static_cast<std::int32_t>(level + 0.5)) << kShift[c];
  }
  return std::bit_cast<float>(bits);
}

Rgb unpackLight(float packed) {
  const auto bits = std::bit_cast<std::uint32_t>(packed);
  const Rgb levels((bits & 2047) / 2047.0, (bits >> 11 & 2047) / 2047.0, (bits >> 22) / 1023.0);
  return levels * levels;
}

bool copyCorners(const BrickSlice& slice, const BrickPlace& place, float* out) {
  const auto [bx, by, bz] = place;
  bool any = false;
  // Along x there is one voxel of the brick before, and those of this one.
  const int own = std::clamp(slice.x() - bx * kBrickSide, 0, kBrickSide);
  const auto rowOf = [&](int column, int y, int z, int c) -> const float* {
    const int brickY = y < 0 ? -1 : y / kBrickSide, brickZ = z < 0 ? -1 : z / kBrickSide;
    if (column < 0 || y < 0 || z < 0 || column >= slice.bricksX() || y >= slice.y() ||
        z >= slice.z())
      return nullptr;
    const std::int32_t stored = slice.brickAt(column, brickY, brickZ);
    return stored == BrickSlice::kEmpty
               ? nullptr
               : slice.brick(stored) + (c * kBrickSide + z % kBrickSide) * kBrickSide * kBrickSide +
                     y % kBrickSide * kBrickSide;
  };
  for (int c = 0; c < slice.channels(); ++c) {
    for (int z = 0; z < kCornerSide; ++z) {
      for (int y = 0; y < kCornerSide; ++y, out += kCornerSide) {
        const int atY = by * kBrickSide + y - 1, atZ = bz * kBrickSide + z - 1;
        const float* last = rowOf(bx - 1, atY, atZ, c);
        const float* row = rowOf(bx, atY, atZ, c);
        out[0] = last ? last[kBrickSide - 1] : 0;
        std::fill_n(out + 1, kBrickSide, 0.0F);
        if (row)
          std::copy_n(row, own, out + 1);
        any = any || std::any_of(out, out + kCornerSide, [](float value) { return value != 0; });
      }
    }
  }
  return any;
}

namespace {

/// Without bricks. @param count  of them on each axis
std::shared_ptr<MarchGrid> emptyMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                          const CellGrid& cells, BrickPlace& count) {
  auto grid = std::make_shared<MarchGrid>();
  grid->slice = slice;
  grid->trilinear = slice->basis() == Basis::kTrilinear;
  grid->channels = slice->channels();
  const int side = grid->trilinear ? kCornerSide : kBrickSide;
  grid->channelStride = grid->trilinear ? kCornersOfBrick : BrickSlice::kVoxels;
  grid->brickStride = grid->channelStride * grid->channels;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    count[axis] = (cells.count[axis] + kBrickSide - 1) / kBrickSide;
    grid->stride[axis] = axis == 0 ? 1 : grid->stride[axis - 1] * side;
  }
  return grid;
}

bool fits(const MarchGrid& grid) {
  return static_cast<std::int64_t>(grid.stored) * grid.brickStride <=
         std::numeric_limits<std::int32_t>::max();
}

}  // namespace

std::shared_ptr<MarchGrid> makeMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                         const CellGrid& cells, double emissionScale,
                                         double extinctionScale) {
  BrickPlace count;
  auto grid = emptyMarchGrid(slice, cells, count);
  grid->emissionScale = emissionScale;
  grid->extinctionScale = extinctionScale;
  if (grid->trilinear) {
    makeCorners(*slice, count, *grid);
    grid->values = grid->corners->data();
  } else {
    grid->table = slice->table();
    grid->bricks.assign(slice->entries().begin(), slice->entries().end());
    grid->stored = static_cast<std::int32_t>(slice->storedBricks());
    grid->values = slice->values().data();
  }
  grid->fits = fits(*grid);
  if (grid->trilinear && grid->channels == 3 && extinctionScale != 0)
    grid->steps = gaussSteps(*slice, cells, extinctionScale);
  return grid;
}

std::shared_ptr<MarchGrid> layMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                        const CellGrid& cells, const BrickTable* without) {
  BrickPlace count;
  auto grid = emptyMarchGrid(slice, cells, count);
  const std::vector<BrickPlace> places = slice->reached(count, grid->table);
  std::vector<std::uint8_t> any(places.size());
  parallelRanges(places.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<float> corners(static_cast<std::size_t>(grid->brickStride));
    for (std::size_t i = begin; i < end; ++i) {
      const bool in = !without || without->at(places[i]) == BrickTable::kEmpty;
      any[i] = in && copyCorners(*slice, places[i], corners.data());
    }
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    grid->table.set(places[i], any[i] ? grid->stored : BrickTable::kEmpty);
    if (any[i])
      grid->bricks.push_back({places[i], grid->stored++});
  }
  grid->fits = fits(*grid);
  return grid;
}

std::shared_ptr<const MarchGrid> filled(const MarchGrid& laid) {
  auto grid = std::make_shared<MarchGrid>(laid);
  const auto each = static_cast<std::size_t>(grid->brickStride);
  std::vector<float> corners(grid->bricks.size() * each);
  parallelRanges(grid->bricks.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      copyCorners(*grid->slice, grid->bricks[i].place, &corners[i * each]);
  });
  grid->corners = std::make_shared<const std::vector<float>>(std::move(corners));
  grid->values = grid->corners->data();
  return grid;
}

}  // namespace volute
