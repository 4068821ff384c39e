// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/medium_snapshot.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// Surfaces for a picture that must be quick: large triangles are divided, and the light that each
/// corner sends back is found once, shadows and smoke on its way included (lookAtSurfaces()); in
/// between it is linear. Where the light of a triangle's corners differs much, at the edges of
/// shadows and of cones of light, it is divided further, down to an eighth. Each side has its own
/// light, so that there are two triangles for one, the front first.
/// @param most  how many triangles may come out of the first division, sides counted once, at least
///     those that there are; and again as many of the second
GlSurfaces surfaceCorners(const SurfaceScene& scene, std::size_t most = 20000);

/// The walls of a medium that has some likewise, seen from inside alone:
/// MediumSnapshot::lookAtWalls(), but with the light at corners of pieces, between which it is
/// linear, as is the share of it that comes through the medium between the vertices of a face.
GlSurfaces wallCorners(const MediumSnapshot& medium, std::size_t most = 20000);

}  // namespace volute
