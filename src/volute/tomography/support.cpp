// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/support.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace volute {
namespace {

/// A cell on a segment's way, and where it passes it [m].
struct PassedCell {
  std::array<int, 3> cell;
  double begin, end;
};

/// Takes the entry out of the cube of cells around its own in which no unknown is, `away` cells to
/// each side less one; false when it leaves the range or the segment before.
bool leaveEmpty(const CellGrid& grid, const CellRange& range, const Segment& segment, int away,
                CellEntry& entry) {
  int axis = 0;
  std::array<double, 3> leaves{};
  for (int a = 0; a < 3; ++a) {
    leaves[a] = entry.step[a] == 0 ? entry.crossing[a]
                                   : CellEntry::leaves(grid, segment, a,
                                                       entry.cell[a] + entry.step[a] * (away - 1));
    if (leaves[a] < leaves[axis])
      axis = a;
  }
  if (!(leaves[axis] < entry.end))
    return false;
  const Vec3 point = segment.at(leaves[axis]);
  for (int a = 0; a < 3; ++a) {
    if (entry.step[a] == 0)
      continue;
    const int most = entry.cell[a] + entry.step[a] * (away - 1);
    if (a == axis) {
      entry.cell[a] = most + entry.step[a];
      if (entry.cell[a] < range.begin[a] || entry.cell[a] >= range.end[a])
        return false;
    } else {
      const double place = std::floor((point[a] - grid.origin[a]) / grid.cell[a]);
      const auto [low, high] = std::minmax(entry.cell[a], most);
      entry.cell[a] =
          static_cast<int>(std::clamp(place, static_cast<double>(std::max(low, range.begin[a])),
                                      static_cast<double>(std::min(high, range.end[a] - 1))));
    }
    entry.crossing[a] = CellEntry::leaves(grid, segment, a, entry.cell[a]);
  }
  entry.begin = std::max(entry.begin, leaves[axis]);
  return true;
}

/// The first cell that any unknown reaches into, as traverseCells would come to it.
std::optional<PassedCell> firstTouched(const Support& support, const Segment& segment) {
  const CellGrid& grid = support.cells();
  const CellRange& range = support.range();
  CellEntry entry;
  if (!enterCells(grid, range, segment, entry))
    return {};
  constexpr int kWorthIt = 3;  // a leap costs as much as so many cells
  while (entry.begin < entry.end) {
    const int away = support.away(entry.cell);
    if (away >= kWorthIt) {
      if (!leaveEmpty(grid, range, segment, away, entry))
        return {};
      continue;
    }
    int axis = entry.crossing[1] < entry.crossing[0] ? 1 : 0;
    if (entry.crossing[2] < entry.crossing[axis])
      axis = 2;
    const double end = std::min(entry.crossing[axis], entry.end);
    if (end > entry.begin) {
      if (away == 0)
        return PassedCell{entry.cell, entry.begin, end};
      entry.begin = end;
    }
    int& index = entry.cell[axis];
    index += entry.step[axis];
    if (index < range.begin[axis] || index >= range.end[axis])
      return {};
    entry.crossing[axis] = CellEntry::leaves(grid, segment, axis, index);
  }
  return {};
}

}  // namespace

CellRange boxAround(const VolumeGeometry& geometry, std::span<const std::uint8_t> hull) {
  const auto& n = geometry.resolution;
  if (hull.empty())
    return {{0, 0, 0}, n};
  CellRange box{n, {0, 0, 0}};
  std::size_t i = 0;
  for (int z = 0; z < n[2]; ++z) {
    for (int y = 0; y < n[1]; ++y) {
      for (int x = 0; x < n[0]; ++x, ++i) {
        if (hull[i] == 0)
          continue;
        const std::array<int, 3> voxel{x, y, z};
        for (int a = 0; a < 3; ++a) {
          box.begin[a] = std::min(box.begin[a], voxel[a]);
          box.end[a] = std::max(box.end[a], voxel[a] + 1);
        }
      }
    }
  }
  return box.empty() ? CellRange{{0, 0, 0}, {1, 1, 1}} : box;
}

CellGrid basisCells(const VolumeGeometry& geometry, Basis basis) {
  CellGrid cells{geometry.bounds.min, geometry.voxelSize(), geometry.resolution};
  if (basis == Basis::kTrilinear) {
    cells.origin -= 0.5 * cells.cell;
    for (int& count : cells.count) ++count;
  }
  return cells;
}

std::int32_t Support::turned(std::int32_t node) const {
  const std::int32_t origin = nodeOf(range_.begin), place = (node - origin) % stride_[2];
  return node - place + place % stride_[1] * (box_[1] + 2) + place / stride_[1];
}

std::int32_t Support::turnedBack(std::int32_t node) const {
  const std::int32_t origin = nodeOf(range_.begin), place = (node - origin) % stride_[2];
  return node - place + place % (box_[1] + 2) * stride_[1] + place / (box_[1] + 2);
}

TouchedPart touchedPart(const Support& support, const Segment& segment) {
  TouchedPart touched;
  const auto first = firstTouched(support, segment);
  if (!first)
    return touched;
  // Backwards for the last one: what lies between does not matter.
  const auto last =
      firstTouched(support, {segment.origin, -segment.direction, -segment.end, -segment.begin});
  touched.part = {first->begin, last ? -last->begin : first->end};
  touched.firstCell = first->cell;
  return touched;
}

Support::Support(const VolumeGeometry& geometry, Basis basis, std::span<const std::uint8_t> hull)
    : geometry_(geometry), basis_(basis), cells_(basisCells(geometry, basis)) {
  const bool trilinear = basis == Basis::kTrilinear;
  const CellRange box = boxAround(geometry, hull);
  range_ = box;
  std::int32_t nodes = 1;
  for (int a = 0; a < 3; ++a) {
    if (trilinear)
      ++range_.end[a];
    box_[a] = box.end[a] - box.begin[a];
    stride_[a] = nodes;
    nodes *= box_[a] + 2;
  }
  const std::int32_t diagonal = stride_[0] + stride_[1] + stride_[2];
  const std::int32_t margin = 3 * diagonal;  // as far as beams look beyond the lattice
  latticeSize_ = static_cast<std::size_t>(nodes) + 2 * margin;
  firstVoxel_ = margin + diagonal;
  first_ = trilinear ? margin : firstVoxel_;
  away_.assign(latticeSize_, kFurthest);

  const auto& n = geometry.resolution;
  for (int z = box.begin[2]; z < box.end[2]; ++z) {
    for (int y = box.begin[1]; y < box.end[1]; ++y) {
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        const std::int32_t voxel = (z * n[1] + y) * n[0] + x;
        if (!hull.empty() && hull[voxel] == 0)
          continue;
        const std::int32_t node = firstVoxel_ + stride_[0] * (x - box.begin[0]) +
                                  stride_[1] * (y - box.begin[1]) + stride_[2] * (z - box.begin[2]);
        voxel_.push_back(voxel);
        node_.push_back(node);
        for (int corner = 0; corner < (trilinear ? 8 : 1); ++corner)
          away_[node - (corner & 1) * stride_[0] - (corner >> 1 & 1) * stride_[1] -
                (corner >> 2) * stride_[2]] = 0;
      }
    }
  }
  findAway();
}

/// Two passes (Rosenfeld and Pfaltz 1968, "Distance functions on digital pictures"). Cells end one
/// node before the lattice does, so that what lies beside a row is of no cell and stays furthest.
void Support::findAway() {
  std::array<std::int32_t, 13> before{};  // of the 26 neighbours, those that come first
  std::size_t count = 0;
  for (int z = -1; z <= 0; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const std::int32_t way = x * stride_[0] + y * stride_[1] + z * stride_[2];
        if (way < 0 && count < before.size())
          before[count++] = way;
      }
    }
  }
  const auto pass = [&](std::int32_t node, int direction) {
    std::uint8_t nearest = kFurthest - 1;
    for (const std::int32_t way : before)
      nearest = std::min(nearest, away_[static_cast<std::size_t>(node + direction * way)]);
    std::uint8_t& own = away_[static_cast<std::size_t>(node)];
    own = std::min<std::uint8_t>(own, nearest + 1);
  };
  const std::int32_t first = nodeOf(range_.begin),
                     last = nodeOf({range_.end[0] - 1, range_.end[1] - 1, range_.end[2] - 1});
  const auto eachCell = [&](auto&& visit) {
    for (int z = range_.begin[2]; z < range_.end[2]; ++z)
      for (int y = range_.begin[1]; y < range_.end[1]; ++y)
        for (int x = range_.begin[0]; x < range_.end[0]; ++x) visit(nodeOf({x, y, z}));
  };
  eachCell([&](std::int32_t node) { pass(node, 1); });
  eachCell([&](std::int32_t node) { pass(first + last - node, -1); });
}

}  // namespace volute
