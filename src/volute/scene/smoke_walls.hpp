// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/image/image.hpp"
#include "volute/scene/smoke_layer.hpp"

namespace volute {

/// What opaque surfaces look like from a camera, without the media before them.
struct SurfaceView {
  std::vector<float> depth;  ///< of each pixel, along its ray; infinite where there is none
  Image color;               ///< linear RGB radiance, black where there is none
};

/// The boundary of a mesh as walls that reflect `color` of the light in all directions, seen from
/// their inside alone: from outside one looks into the building. Lamps' light comes through the
/// smoke, which so casts shadows (Staubli et al. 2005, section 4.3); what reaches a point of a wall
/// is between what reaches its triangle's corners.
[[nodiscard]] Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                              const SceneLights& lights, const Rgb& color);

}  // namespace volute
