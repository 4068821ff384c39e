// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/viewer/view_scene.hpp"

namespace volute {

/// A place on an opaque surface.
struct WallPlace {
  Vec3 position = Vec3::Zero();  ///< [m]
  Vec3 normal = Vec3::UnitX();   ///< unit, towards the side that was looked at
};

/// What a ray meets first: a surface of the scene, a sign, or the boundary of a mesh of smoke from
/// its inside, shown as a wall or not.
std::optional<WallPlace> pickWall(const ViewScene& scene, const Segment& ray);

}  // namespace volute
