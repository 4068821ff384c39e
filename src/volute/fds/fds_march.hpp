// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/fds/fds_grid.hpp"

namespace volute {

/// A lattice as the march wants it.
struct MarchLattice {
  MarchLattice() = default;

  /// `values` as FdsValues have them, `gas` 1 for each cell of gas, else 0; `low` and `high` bound
  /// the values, or are empty.
  MarchLattice(const FdsLattice& lattice, std::span<const float> values,
               std::span<const std::uint8_t> gas, std::span<const float> low = {},
               std::span<const float> high = {});

  /// Of cells that are all gas, for low and high ends alone; where planes are evenly spaced (the
  /// last cell on an axis may be smaller) rounding differs from traversePlanes().
  MarchLattice(const FdsLattice& lattice, std::span<const float> least,
               std::span<const float> most);

  std::vector<double> planes;           ///< of x, y, z one after the other, with two more all round
  std::array<std::int64_t, 3> first{};  ///< of each axis' planes
  std::array<double, 3> perPlane{};     ///< cells a metre, on average
  std::array<std::int64_t, 3> cells{};
  std::array<std::int64_t, 3> stride{};  ///< from value to value
  bool nodal = false;
  int thinAxis = -1;  ///< nodal, and both nodes on this axis have the same values: a 2D slice
  const float* values = nullptr;  ///< must outlive this
  const float* low = nullptr;     ///< as many as values; null: they are exact
  const float* high = nullptr;
  std::vector<float> own;            ///< of each cell: its value, or 1 if nodal; -1 where no gas is
  std::vector<std::uint64_t> pairs;  ///< of all-gas cells: the bits of least and, above, most
  bool even = false;                 ///< such cells, evenly spaced
  std::array<double, 3> spacing{};   ///< [m]
};

/// A part of a segment in one lattice.
struct MarchPart {
  std::uint32_t segment = 0;
  double begin = 0, end = 0;
};

/// The integral over a part, and how much of it is gas [m].
struct MarchSum {
  double depth = 0;
  double gas = 0;
  double low = 0, high = 0;  ///< of the bounds, where the lattice has some; `high` may be infinite
};

/// Several parts at once, one in each lane, exact as traversePlanes() is and in the same order of
/// sums: of cells the same bits on every target.
void marchParts(const FdsLattice& lattice, const MarchLattice& march,
                std::span<const Segment> segments, std::span<const MarchPart> parts,
                std::span<MarchSum> sums);

}  // namespace volute
