// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace volute {

/// A plane for each channel: vectors of neighbours along x lie together in memory.
using ColourPlanes = std::array<std::vector<float>, 3>;

/// Differences of a colour along x, y and z: that of channel c along `axis` is in plane
/// 3 * axis + c.
using SlopePlanes = std::array<std::vector<float>, 9>;

/// What the dual steps of total variation work on: planes over a lattice, of whose nodes those
/// outside of all blocks are 0.
struct VariationPlanes {
  static constexpr std::size_t kBlock = 16;  ///< nodes

  std::array<std::int32_t, 3> stride{};  ///< of the lattice on x, y, z, in nodes
  std::vector<std::int32_t> blocks;      ///< the first node of each; no node is in two
  ColourPlanes target, primal;
  SlopePlanes dual, ahead;
  std::vector<float> weight;  ///< of each node; 0 where no unknown is
  std::vector<float> rate;    ///< of each node's slopes; 0 where no unknown is at either end

  explicit VariationPlanes(std::size_t latticeSize);

  /// primal = target - weight * D' `slopes` in blocks [begin, end), and at least 0 if
  /// `nonNegative`.
  void updatePrimal(const SlopePlanes& slopes, bool nonNegative, std::size_t begin,
                    std::size_t end);

  /// dual = ahead + rate * D primal, no singular value above 1; ahead = dual + beta * (dual - the
  /// dual before), in blocks [begin, end).
  void updateDual(float beta, std::size_t begin, std::size_t end);
};

/// Replaces the matrices of 3 axes by 3 channels by the nearest ones (Frobenius norm) none of whose
/// singular values is above 1: larger ones become 1. To about 1e-5 of the matrix.
void clipSingularValues(SlopePlanes& slopes);

}  // namespace volute
