// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/level_set_surface.hpp"

#include <array>
#include <bit>
#include <cmath>

namespace volute {
namespace {

constexpr int kSide = Bricks::kSide;
constexpr int kCorners = kSide + 1;  // of the cells of a leaf, along an axis

/// Values at the corners of a cell; bits 0, 1, 2 of a corner are its x, y, z.
using Cell = std::array<double, 8>;

/// Around the diagonal from corner 0 to corner 7, the same in all cells: neighbours share faces.
/// Each edge leads to a corner that has all bits of where it begins.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

/// Where the trilinear function is 0 between two corners of unlike signs, 0..1. Cells that share
/// the edge find the same to the last bit: they sum up the same values in the same order.
double crossing(const Cell& cell, int from, int to) {
  const int axes = to ^ from;
  std::array<double, 4> sums{};  // by how many axes are gone along
  for (int some = 0; some < 8; ++some) {
    if ((some & ~axes) == 0)
      sums[static_cast<std::size_t>(std::popcount(static_cast<unsigned>(some)))] +=
          cell[static_cast<std::size_t>(from | some)];
  }
  const int degree = std::popcount(static_cast<unsigned>(axes));
  if (degree == 1)
    return sums[0] / (sums[0] - sums[1]);
  const auto at = [&](double t) {
    const double s = 1 - t;
    return degree == 2 ? s * s * sums[0] + t * s * sums[1] + t * t * sums[2]
                       : s * s * s * sums[0] + t * s * s * sums[1] + t * t * s * sums[2] +
                             t * t * t * sums[3];
  };
  const bool inside = sums[0] < 0;
  double low = 0, high = 1;
  for (int i = 0; i < 52; ++i) {
    const double middle = 0.5 * (low + high);
    ((at(middle) < 0) == inside ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Calls piece(a, b, c), in the cell's own coordinates.
template <class Piece>
void cutCell(const Cell& cell, const Piece& piece) {
  const auto between = [&](int a, int b) {
    const int from = std::min(a, b), to = std::max(a, b);
    const double t = crossing(cell, from, to);
    Vec3 at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = (from >> axis & 1) + ((to ^ from) >> axis & 1) * t;
    return at;
  };
  for (const auto& corners : kTetrahedra) {
    std::array<int, 4> in{}, out{};
    std::size_t inside = 0, outside = 0;
    for (const int corner : corners)
      (cell[static_cast<std::size_t>(corner)] < 0 ? in[inside++] : out[outside++]) = corner;
    if (inside == 0 || outside == 0)
      continue;
    if (inside == 2) {
      const Vec3 a = between(in[0], out[0]), b = between(in[0], out[1]);
      const Vec3 c = between(in[1], out[1]), d = between(in[1], out[0]);
      piece(a, b, c), piece(a, c, d);
      continue;
    }
    const int alone = inside == 1 ? in[0] : out[0];
    const auto& others = inside == 1 ? out : in;
    piece(between(alone, others[0]), between(alone, others[1]), between(alone, others[2]));
  }
}

/// The values of a leaf and of those before it on all axes' upper sides; NaN where there is none.
class LeafCorners {
 public:
  LeafCorners(const Bricks& bricks, std::size_t leaf) {
    const VoxelIndex& origin = bricks.leaves()[leaf].origin;
    const std::size_t none = bricks.leaves().size();
    std::array<std::size_t, 8> leaves{};
    for (std::size_t i = 0; i < 8; ++i) {
      VoxelIndex at = origin;
      for (std::size_t axis = 0; axis < 3; ++axis)
        at[axis] += static_cast<std::int64_t>(i >> axis & 1) * kSide;
      leaves[i] = i == 0 ? leaf : bricks.find(at);
    }
    for (int z = 0; z < kCorners; ++z)
      for (int y = 0; y < kCorners; ++y)
        for (int x = 0; x < kCorners; ++x) {
          const int which = (x / kSide) + 2 * (y / kSide) + 4 * (z / kSide);
          const std::size_t from = leaves[static_cast<std::size_t>(which)];
          at(x, y, z) = from == none ? std::numeric_limits<double>::quiet_NaN()
                                     : bricks.values(from)[static_cast<std::size_t>(
                                           (z % kSide * kSide + y % kSide) * kSide + x % kSide)];
        }
  }

  /// False: it reaches out, or has no surface.
  bool cell(int x, int y, int z, Cell& cell) const {
    int inside = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const double value =
          values_[index(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))];
      if (!std::isfinite(value))
        return false;
      cell[static_cast<std::size_t>(corner)] = value;
      inside += value < 0;
    }
    return inside > 0 && inside < 8;
  }

 private:
  static std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>((z * kCorners + y) * kCorners + x);
  }

  double& at(int x, int y, int z) { return values_[index(x, y, z)]; }

  std::array<double, std::size_t{kCorners} * kCorners * kCorners> values_{};
};

}  // namespace

Status addLevelSet(const Bricks& distances, const VolumeInfo& info,
                   const std::optional<GridMatrix>& place, std::uint32_t material,
                   std::uint64_t maxMemory, std::vector<Triangle>& triangles) {
  const Vec3 voxel = info.voxelSize(), first = info.bounds.min + 0.5 * voxel;
  const Mat3 linear =
      place ? Mat3(linearOf(*place) * voxel.asDiagonal()) : Mat3(voxel.asDiagonal());
  const Vec3 offset = place ? Vec3(linearOf(*place) * first + offsetOf(*place)) : first;
  Cell cell{};
  for (std::size_t leaf = 0; leaf < distances.leaves().size(); ++leaf) {
    const LeafCorners corners(distances, leaf);
    const VoxelIndex& origin = distances.leaves()[leaf].origin;
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          if (!corners.cell(x, y, z, cell))
            continue;
          const Vec3 begin(static_cast<double>(origin[0] + x), static_cast<double>(origin[1] + y),
                           static_cast<double>(origin[2] + z));
          cutCell(cell, [&](const Vec3& a, const Vec3& b, const Vec3& c) {
            Triangle triangle;
            const Vec3* const all[] = {&a, &b, &c};
            for (int i = 0; i < 3; ++i) triangle.corners[i] = linear * (begin + *all[i]) + offset;
            triangle.material = material;
            triangles.push_back(triangle);
          });
        }
    if (triangles.size() > maxMemory / sizeof(Triangle)) {
      return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                  "the surface of '{}' has more triangles than the {} MiB of memory allowed hold",
                  info.name, maxMemory >> 20);
    }
  }
  return {};
}

}  // namespace volute
