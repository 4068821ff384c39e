// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/math/vec.hpp"

namespace volute {

/// A made-up fire in the small room of hallMesh(): a column over the seat, a layer that fills the
/// room and, once it is down to the lintel, flows through the door, rises and spreads below the
/// hall's ceiling, the curtain holding it up for a while. Soot density [g/m3] at each point, `time`
/// seconds after the fire began. Not a simulation.
std::vector<float> hallSmoke(std::span<const Vec3> points, double time, std::uint32_t seed);

}  // namespace volute
