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

/// What share of the eight cells round each node counts as gas in FDS's average for .s3d files:
/// cells that are gas; of those outside the mesh only the ones next to a face, which hold what is
/// on the other side of it (another mesh's cell, or a mirror of the own one); none across edges and
/// corners. `solid` is solidCells() of all meshes. 0..8 for each node.
std::vector<std::uint8_t> gasCellsAtNodes(const SmvIndex& index, int mesh,
                                          std::span<const std::vector<std::uint8_t>> solid);

}  // namespace volute
