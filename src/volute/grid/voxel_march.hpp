// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/brick_table.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/grid/voxel_medium.hpp"

// The fast execution of VoxelMedium, apart from the medium so that the SIMD code is one translation
// unit.

namespace volute {

/// What the SIMD march reads: bricks of 8^3 cells in a table, whose border of empty bricks is for
/// rays that rounding carries past the last face.
///
/// Box: the values are the slice's own bricks, 8 a side. Trilinear: bricks are 9 a side, each with
/// the voxels around all its cells, so that the eight corners of a cell are always in one brick.
/// Channel c of the i-th voxel of brick b is values[b * brickStride + c * channelStride + i *
/// stride[0]].
struct MarchGrid {
  std::shared_ptr<const BrickSlice> slice;
  bool trilinear = false;
  int channels = 1;
  BrickTable table;                       ///< the number of each brick
  std::vector<BrickSlice::Entry> bricks;  ///< those of the table, in the order of isBefore()
  std::int32_t stored = 0;                ///< numbers
  const float* values = nullptr;
  std::int32_t brickStride = 0;                       ///< in values, from one number to the next
  std::shared_ptr<const std::vector<float>> corners;  ///< the trilinear bricks; copies share them
  std::int32_t stride[3]{};  ///< in values, for a step of one cell on x, y, z; stride[0] is 1, but
                             ///< 2 where light lies beside extinction
  std::int32_t channelStride = 0;
  double emissionScale = 0;
  double extinctionScale = 0;
  int steps = 1;            ///< Gauss rules in a cell, for absorbing RGB in the trilinear basis
  float lightLost = 1e-6F;  ///< a ray that has no more than this of its light ends
  /// Of ShadedVoxels: channel 0 is the extinction, and from these on there are the emission, three
  /// channels, and the light that is scattered, one; -1: there is none.
  bool shaded = false;
  int emissionChannel = -1;
  int lightChannel = -1;
  /// The light is of one colour: its values are numbers from 0 to 1 and lightScale is the
  /// brightest. Else they are packed: packLight().
  bool oneColor = false;
  float lightScale[3]{};  ///< of the squares of what is packed
  bool fits = true;       ///< the values can be addressed by 31 bits
};

/// Square roots of three shares 0..1 in one float's bits, with 11, 11 and 10 bits: so that one
/// access reads a colour. unpackLight() gives what the march makes of them.
float packLight(const Rgb& shares);
constexpr double kPackedLevels[3] = {2047, 2047, 1023};  ///< the largest numbers that are packed
Rgb unpackLight(float packed);

/// Bricks with equal values may have one number.
std::shared_ptr<MarchGrid> makeMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                         const CellGrid& cells, double emissionScale,
                                         double extinctionScale);

/// Which bricks there are, trilinear, each with a number of its own; `values` is null.
/// @param without  bricks of cells that are left out; null: none
std::shared_ptr<MarchGrid> layMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                        const CellGrid& cells, const BrickTable* without);

/// A grid of laid-out cells, filled with values.
std::shared_ptr<const MarchGrid> filled(const MarchGrid& laid);

/// The voxels around the cells of a brick, shape (c, z, y, x).
/// @return  whether one is not zero
bool copyCorners(const BrickSlice& slice, const BrickPlace& place, float* out);

/// Calls visit(cell, number of its brick, the first of its values, begin, end) for each cell of a
/// brick that is stored on a segment, front to back.
template <class Visit>
void forMarchedCells(const MarchGrid& grid, const CellGrid& cells, const Segment& segment,
                     Visit&& visit) {
  constexpr int kSide = BrickSlice::kSide;
  const CellGrid bricks{cells.origin, kSide * cells.cell, {}};
  grid.table.walk(
      bricks, segment, [&](const BrickPlace& place, std::int32_t number, double begin, double end) {
        CellRange range{.found = true};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          range.begin[axis] = place[axis] * kSide;
          range.end[axis] = std::min(range.begin[axis] + kSide, cells.count[axis]);
        }
        const float* brick = grid.values + static_cast<std::ptrdiff_t>(number) * grid.brickStride;
        traverseCells(cells, range, {segment.origin, segment.direction, begin, end},
                      [&](const std::array<int, 3>& cell, double from, double to) {
                        std::ptrdiff_t first = 0;
                        for (std::size_t axis = 0; axis < 3; ++axis)
                          first += (cell[axis] - range.begin[axis]) * grid.stride[axis];
                        visit(cell, number, brick + first, from, to);
                      });
        return true;
      });
}

/// One of the eight corners of a trilinear cell, from the first of its values.
inline float cornerOf(const MarchGrid& grid, const float* first, int corner, int channel) {
  std::ptrdiff_t at = static_cast<std::ptrdiff_t>(channel) * grid.channelStride;
  for (int axis = 0; axis < 3; ++axis) at += (corner >> axis & 1) * grid.stride[axis];
  return first[at];
}

/// out[i] is the light along segments[i] through the cells of `range`; adds to `counts`. The grid
/// must fit.
void marchRadiance(const MarchGrid& grid, const CellGrid& cells, const CellRange& range,
                   std::span<const Segment> segments, std::span<Radiance> out, MarchCounts& counts);

}  // namespace volute
