// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "volute/grid/volume_info.hpp"

// The inner loops of the projector, apart from it so that the SIMD code is one translation unit.
// Voxels and pixels are four floats, R G B 0, one vector.

namespace volute {

/// A ray as the walk wants it, from where it enters the first cell that an unknown reaches into.
/// Positions are relative to the present cell, 0..1, so that rounding stays at 1e-7 of a cell.
struct WalkRay {
  float position[3];
  float velocity[3];  ///< cells per metre
  float length;       ///< [m] to where it leaves the last such cell; 0: it meets none
  std::int32_t node;  ///< Support::nodeOf the first cell
};

struct WalkLattice {
  Basis basis = Basis::kTrilinear;
  std::int32_t stride[3]{};  ///< in nodes
};

/// sums[0..3] of each row: the mean over its rays of the line integrals through `lattice`.
/// @param rays  rows * raysPerRow of them.
void walkForward(const WalkLattice& lattice, const float* values, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* sums);

/// The transpose: adds each row's four values, spread along its rays, to `gradient`.
void walkAdjoint(const WalkLattice& lattice, const float* rowValues, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* gradient);

/// Which nodes a row reads, with what weight.
struct NodeWeight {
  std::int32_t node;
  float weight;
};

/// Appends the weights of each row to out[row]: several for a node that several rays reach, and 0
/// for some beside them.
void walkWeights(const WalkLattice& lattice, const WalkRay* rays, std::size_t rows, int raysPerRow,
                 std::vector<NodeWeight>* out);

/// The same as a walk with the weights written down: row i has those of [begin[i], begin[i+1]).
void tableSums(const NodeWeight* table, const std::uint64_t* begin, std::size_t rows,
               const float* values, float* sums);

}  // namespace volute
