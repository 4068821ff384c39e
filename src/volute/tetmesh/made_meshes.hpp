// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

// Synthetic meshes for tests, benchmarks and examples.

namespace volute {

/// A box cut into tets, six to a cell; inner vertices moved by up to `jitter` of a cell at random,
/// less where a tet would turn inside out.
std::shared_ptr<const TetMesh> boxMesh(const Box3& box, const std::array<int, 3>& cells,
                                       double jitter, std::uint32_t seed);

/// A hall of 28 x 12 x 6 m with columns and a curtain below the ceiling, that is, holes where rays
/// leave and re-enter the mesh; cells of about `cell` metres.
std::shared_ptr<const TetMesh> hallMesh(double cell, std::uint32_t seed);

/// A plume that rises from a fire and spreads below the ceiling of the mesh's bounds, as soot
/// density [g/m3], zero far from it; `time` [s] moves its eddies.
std::vector<float> plume(const TetMesh& mesh, double time, std::uint32_t seed);

}  // namespace volute
