// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// A made-up fire in the small room of hallMesh(): a column over the seat, a layer that fills the
/// room and, once it is down to the lintel, flows through the door, rises and spreads below the
/// hall's ceiling, the curtain holding it up for a while. Soot density [g/m3] at each vertex,
/// `time` seconds after the fire began. Not a simulation.
std::vector<float> hallSmoke(const TetMesh& hall, double time, std::uint32_t seed);

}  // namespace volute
