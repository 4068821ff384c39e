// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/render/surfaces.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// Surfaces for a picture that must be quick: large triangles are divided, and the light that each
/// corner sends back is found once, shadows and smoke on its way included (lookAtSurfaces()); in
/// between it is linear. Each side has its own light, so that there are two triangles for one, the
/// front first.
/// @param most  how many triangles may come out, sides counted once; at least those that there are
ViewSurfaces surfaceCorners(const SurfaceScene& scene, std::size_t most = 20000);

}  // namespace volute
