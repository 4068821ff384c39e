// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/medium/medium.hpp"
#include "volute/render/surfaces.hpp"

// Pictures of a medium of which each rank holds a share (sort-last: Molnar et al. 1994). Ranks call
// these in the same order, for pictures of the same size. The pixels of a picture are cut into as
// many bands as there are ranks; each rank is sent what the others hold of its band, puts it
// together, and all get the whole, so no rank holds more than another. An error of a rank stays
// with the team: agree() tells of it.

namespace volute {

/// A stretch of a pixel's ray that one rank holds without a gap.
struct HeldRun {
  double begin = 0, end = 0;  ///< [m] from the ray's origin
  Radiance radiance;          ///< of it alone
};

/// The contiguous stretches of a ray's pieces, from front to back, each composited.
/// @param perMedium  the pieces of each medium; of several they may overlap and add up
std::vector<HeldRun> heldRuns(std::span<const std::vector<Piece>> perMedium);

/// Adds up the depths of all ranks, place by place, in the order of ranks. Collective.
void sumDepths(Team& team, std::span<float> depth);
void sumDepths(Team& team, std::span<double> depth);

/// Light and transmittance (RGBT, 4 values a pixel) of the runs of all ranks from front to back.
/// They do not overlap, but for rays in the plane between two pieces: of runs in the same place one
/// counts. Collective.
/// @param runs  gives those of a pixel; called for one pixel from several threads
void composeRuns(Team& team, const std::function<std::vector<HeldRun>(std::size_t)>& runs,
                 std::span<float> rgbt);

}  // namespace volute
