// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/fds/smv_index.hpp"

namespace volute {

/// 1 for each cell of a mesh that an obstruction fills at a time [s], x fastest. Thin obstructions
/// fill none.
std::vector<std::uint8_t> solidCells(const FdsMesh& mesh, double time);

/// What the eight cells round a node hold in FDS's average for .s3d files. The rest of the eight,
/// outside of the mesh across its edges and corners, count as zero.
struct NodeCells {
  std::uint8_t gas = 0;   ///< gas, of this mesh or of another one across a face
  std::uint8_t open = 0;  ///< across a face that is open (a vent OPEN or MIRROR): mostly a mirror
  std::uint8_t held = 0;  ///< solid, or across a wall: they keep the value of the first stored time
};

/// For each node of a mesh at a time [s]. `solid` is solidCells() of all meshes; those that do not
/// touch this one may be empty.
std::vector<NodeCells> cellsRoundNodes(const SmvIndex& index, int mesh, double time,
                                       std::span<const std::vector<std::uint8_t>> solid);

}  // namespace volute
