// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/grid/voxel_medium.hpp"

// The fast execution of VoxelMedium, apart from the medium so that the SIMD code is one translation
// unit.

namespace volute {

/// What the SIMD march reads: bricks of 8^3 cells in a table with a border of empty bricks, so that
/// a ray that rounding carries past the last face still finds an entry.
///
/// Box: the values are the slice's own bricks, 8 a side. Trilinear: bricks are 9 a side, each with
/// the voxels around all its cells, so that the eight corners of a cell are always in one brick.
/// Channel c of the i-th voxel of a brick that begins at b is values[b + c * channelStride + i *
/// stride[0]].
struct MarchGrid {
  std::shared_ptr<const BrickSlice> slice;
  bool trilinear = false;
  int channels = 1;
  std::int32_t tableStride[3]{};    ///< in table entries, for a step of one brick on x, y, z
  std::vector<std::int32_t> table;  ///< where the brick's values begin, or -1
  const float* values = nullptr;
  std::vector<float> corners;  ///< the trilinear bricks
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

std::shared_ptr<MarchGrid> makeMarchGrid(const std::shared_ptr<const BrickSlice>& slice,
                                         const CellGrid& cells, double emissionScale,
                                         double extinctionScale);

/// out[i] is the light along segments[i] through the cells of `range`; adds to `counts`. The grid
/// must fit.
void marchRadiance(const MarchGrid& grid, const CellGrid& cells, const CellRange& range,
                   std::span<const Segment> segments, std::span<Radiance> out, MarchCounts& counts);

}  // namespace volute
