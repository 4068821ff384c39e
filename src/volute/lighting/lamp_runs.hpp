// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// A stretch of a way to a lamp inside one piece of a mesh.
struct LampRun {
  double begin = 0, end = 0;  ///< [m] from the way's origin
  double depth = 0;
};

/// Appends those of a way in a mesh, from front to back; what touches within `near` [m] is one.
/// `extinction` [1/m], one for each vertex.
void appendLampRuns(const TetLocator& locator, std::span<const float> extinction,
                    const Segment& way, double near, std::vector<LampRun>& runs);

/// lampShareReference() of a mesh in pieces, from the runs of all of them in any order: e^-depth,
/// or 0 where the way leaves the mesh and enters it again. Of runs in the same place, as those of a
/// way in the plane between two pieces, one counts.
/// @param end  where the lamp is along the way, if it is inside; else infinite
/// @param near  a gap that is none [m]
double lampShareOf(std::span<LampRun> runs, double end, double near);

}  // namespace volute
