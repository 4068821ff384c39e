// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/support.hpp"

#include <algorithm>
#include <optional>

namespace volute {
namespace {

/// The voxels around those that are not 0; all when `hull` is empty.
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

/// A cell on a segment's way, and where it passes it [m].
struct PassedCell {
  std::array<int, 3> cell;
  double begin, end;
};

/// The first cell that any unknown reaches into, as traverseCells would come to it.
std::optional<PassedCell> firstTouched(const Support& support, const Segment& segment) {
  const CellGrid& grid = support.cells();
  const CellRange& range = support.range();
  CellEntry entry;
  if (!enterCells(grid, range, segment, entry))
    return {};
  while (entry.begin < entry.end) {
    int axis = entry.crossing[1] < entry.crossing[0] ? 1 : 0;
    if (entry.crossing[2] < entry.crossing[axis])
      axis = 2;
    const double end = std::min(entry.crossing[axis], entry.end);
    if (end > entry.begin) {
      if (support.touches(entry.cell))
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
  touched_.assign(latticeSize_, 0);

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
          touched_[node - (corner & 1) * stride_[0] - (corner >> 1 & 1) * stride_[1] -
                   (corner >> 2) * stride_[2]] = 1;
      }
    }
  }
}

}  // namespace volute
