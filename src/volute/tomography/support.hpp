// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/grid/traversal.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// The unknown voxels as a compact list, in the order of the volume (z, y, x), and the lattice that
/// rays walk through: the box around them with one layer of voxels more on each side, whose values
/// stay zero.
class Support {
 public:
  /// @param hull  (z, y, x), not 0 for unknown voxels; empty: all of them.
  Support(const VolumeGeometry& geometry, Basis basis, std::span<const std::uint8_t> hull);

  /// The number of unknown voxels.
  std::size_t size() const { return voxel_.size(); }

  Basis basis() const { return basis_; }

  const VolumeGeometry& geometry() const { return geometry_; }

  /// Index in the volume of each unknown.
  std::span<const std::int32_t> voxels() const { return voxel_; }

  /// Index in the lattice of each unknown.
  std::span<const std::int32_t> nodes() const { return node_; }

  /// What rays cross: voxels (box), or cells between voxel centres (trilinear), of the whole
  /// volume.
  const CellGrid& cells() const { return cells_; }

  /// The part of cells() that any unknown reaches into.
  const CellRange& range() const { return range_; }

  /// Lattice index of a cell: its voxel (box), or the lowest of its eight corners.
  std::int32_t nodeOf(const std::array<int, 3>& cell) const {
    return first_ + stride_[0] * (cell[0] - range_.begin[0]) +
           stride_[1] * (cell[1] - range_.begin[1]) + stride_[2] * (cell[2] - range_.begin[2]);
  }

  /// Whether any unknown reaches into the cell.
  bool touches(const std::array<int, 3>& cell) const { return away(cell) == 0; }

  /// How many cells away, along the axis on which it is furthest, the nearest is that any unknown
  /// reaches into, and at most kFurthest.
  int away(const std::array<int, 3>& cell) const { return away_[nodeOf(cell)]; }

  static constexpr int kFurthest = 255;

  const std::array<std::int32_t, 3>& stride() const { return stride_; }  ///< in nodes, on x, y, z

  /// In the lattice with x and y exchanged, where nodes that follow each other along y do so in
  /// memory: the strides on x, y, z, and a node of the other lattice.
  std::array<std::int32_t, 3> turnedStride() const { return {box_[1] + 2, 1, stride_[2]}; }

  std::int32_t turned(std::int32_t node) const;

  /// The reverse of turned().
  std::int32_t turnedBack(std::int32_t node) const;

  /// Lattice nodes, with a margin at both ends for a ray that rounding carries one cell too far.
  std::size_t latticeSize() const { return latticeSize_; }

  /// Voxels of the box around the unknowns on x, y, z, without the layer around it.
  std::array<int, 3> boxSize() const { return box_; }

  /// Lattice index of the box's first voxel.
  std::int32_t firstVoxel() const { return firstVoxel_; }

 private:
  void findAway();

  VolumeGeometry geometry_;
  Basis basis_;
  CellGrid cells_;
  CellRange range_;
  std::array<std::int32_t, 3> stride_{};
  std::array<int, 3> box_{};
  std::int32_t first_ = 0;
  std::int32_t firstVoxel_ = 0;
  std::size_t latticeSize_ = 0;
  std::vector<std::int32_t> voxel_;
  std::vector<std::int32_t> node_;
  std::vector<std::uint8_t> away_;  ///< of each cell, at nodeOf() it
};

/// The part of a segment from the first to the last cell that an unknown reaches into.
struct TouchedPart {
  Interval part;  ///< empty when it meets none
  std::array<int, 3> firstCell{};

  bool empty() const { return part.empty(); }
};

TouchedPart touchedPart(const Support& support, const Segment& segment);

/// The least box around the voxels of a hull that are not 0, one voxel where none is; all of them
/// when `hull` is empty.
CellRange boxAround(const VolumeGeometry& geometry, std::span<const std::uint8_t> hull);

/// The cells of a basis over a volume: its voxels, or the cells between their centres with one
/// layer around.
CellGrid basisCells(const VolumeGeometry& geometry, Basis basis);

}  // namespace volute
