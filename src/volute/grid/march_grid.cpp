// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "volute/grid/voxel_march.hpp"

namespace volute {
namespace {

constexpr int kSide = BrickSlice::kSide;
constexpr int kCornerSide = kSide + 1;
constexpr int kCornersOfBrick = kCornerSide * kCornerSide * kCornerSide;

/// Whether any voxel around the cells of brick (bx, by, bz) is in a stored brick: its own, or the
/// one before on any axis.
bool hasCorners(const BrickSlice& slice, int bx, int by, int bz) {
  for (int i = 0; i < 8; ++i) {
    const int x = bx - (i & 1), y = by - (i >> 1 & 1), z = bz - (i >> 2);
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < slice.bricksX() && y < slice.bricksY() &&
                        z < slice.bricksZ();
    if (inside && slice.brickAt(x, y, z) != BrickSlice::kEmpty)
      return true;
  }
  return false;
}

/// Appends the voxels around the cells of a brick, shape (c, z, y, x); takes them back when all are
/// zero.
bool appendCorners(const BrickSlice& slice, int bx, int by, int bz, std::vector<float>& corners) {
  const std::size_t before = corners.size();
  corners.resize(before + static_cast<std::size_t>(kCornersOfBrick) * slice.channels());
  float* out = corners.data() + before;
  bool any = false;
  // Along x there is one voxel of the brick before, and those of this one.
  const int own = std::clamp(slice.x() - bx * kSide, 0, kSide);
  const auto rowOf = [&](int column, int y, int z, int c) -> const float* {
    const int brickY = y < 0 ? -1 : y / kSide, brickZ = z < 0 ? -1 : z / kSide;
    if (column < 0 || y < 0 || z < 0 || column >= slice.bricksX() || y >= slice.y() ||
        z >= slice.z())
      return nullptr;
    const std::int32_t stored = slice.brickAt(column, brickY, brickZ);
    return stored == BrickSlice::kEmpty
               ? nullptr
               : slice.brick(stored) + (c * kSide + z % kSide) * kSide * kSide + y % kSide * kSide;
  };
  for (int c = 0; c < slice.channels(); ++c) {
    for (int z = 0; z < kCornerSide; ++z) {
      for (int y = 0; y < kCornerSide; ++y, out += kCornerSide) {
        const int atY = by * kSide + y - 1, atZ = bz * kSide + z - 1;
        const float* last = rowOf(bx - 1, atY, atZ, c);
        const float* row = rowOf(bx, atY, atZ, c);
        out[0] = last ? last[kSide - 1] : 0;
        std::fill_n(out + 1, kSide, 0.0F);
        if (row)
          std::copy_n(row, own, out + 1);
        any = any || std::any_of(out, out + kCornerSide, [](float value) { return value != 0; });
      }
    }
  }
  if (!any)
    corners.resize(before);
  return any;
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

std::shared_ptr<MarchGrid> makeMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                         const CellGrid& cells, double emissionScale,
                                         double extinctionScale) {
  auto grid = std::make_shared<MarchGrid>();
  grid->slice = slice;
  grid->trilinear = slice->basis() == Basis::kTrilinear;
  grid->channels = slice->channels();
  grid->emissionScale = emissionScale;
  grid->extinctionScale = extinctionScale;
  const int side = grid->trilinear ? kCornerSide : kSide;
  const std::int32_t brickValues = grid->trilinear ? kCornersOfBrick : BrickSlice::kVoxels;
  int bricks[3];
  for (int axis = 0; axis < 3; ++axis) {
    bricks[axis] = (cells.count[axis] + kSide - 1) / kSide;
    grid->stride[axis] = axis == 0 ? 1 : grid->stride[axis - 1] * side;
    grid->tableStride[axis] = axis == 0 ? 1 : grid->tableStride[axis - 1] * (bricks[axis - 1] + 2);
  }
  grid->channelStride = brickValues;
  grid->table.assign(static_cast<std::size_t>(grid->tableStride[2]) * (bricks[2] + 2), -1);
  constexpr auto kMax = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  for (int z = 0; z < bricks[2] && grid->fits; ++z) {
    for (int y = 0; y < bricks[1]; ++y) {
      for (int x = 0; x < bricks[0]; ++x) {
        std::size_t begin = grid->corners.size();
        if (grid->trilinear) {
          if (!hasCorners(*slice, x, y, z) || !appendCorners(*slice, x, y, z, grid->corners))
            continue;
        } else {
          if (slice->brickAt(x, y, z) == BrickSlice::kEmpty)
            continue;
          begin = static_cast<std::size_t>(slice->brickAt(x, y, z)) * brickValues * grid->channels;
        }
        grid->fits =
            grid->fits && begin + static_cast<std::size_t>(brickValues) * grid->channels <= kMax;
        grid->table[(z + 1) * grid->tableStride[2] + (y + 1) * grid->tableStride[1] + x + 1] =
            static_cast<std::int32_t>(begin);
      }
    }
  }
  grid->values = grid->trilinear ? grid->corners.data() : slice->values().data();
  if (grid->trilinear && grid->channels == 3 && extinctionScale != 0) {
    grid->steps = gaussSteps(*slice, cells, extinctionScale);
  }
  return grid;
}

}  // namespace volute
