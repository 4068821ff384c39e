// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/fds/smv_index.hpp"

namespace volute {

/// The largest room of a building at a time [s]: the box [m] over the largest rectangle of floor
/// that no obstruction stands on and that obstructions, or closed tops of meshes, cover everywhere,
/// from the floor to the lowest of what covers it. A room is 1.9 m high at least, or 0.6 of the
/// meshes' height where that is less, and has a fiftieth of the meshes' plan. Nothing where no
/// obstruction covers so much: then the meshes are seen from above. To within a 200th of the plan's
/// longer side, and never larger than it is, but for obstructions that cover a part of that.
std::optional<Box3> largestRoom(const SmvIndex& index, double time);

}  // namespace volute
