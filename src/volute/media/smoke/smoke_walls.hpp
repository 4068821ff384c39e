// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/medium_at.hpp"
#include "volute/media/smoke/smoke_layer.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// What share each corner of a triangle has in a point of it, 0 or more: linear functions there are
/// the sum of the corners' values times these.
Vec3 cornerShares(const std::array<std::int32_t, 3>& corners, std::span<const Vec3> points,
                  const Vec3& point);

/// Where a ray leaves a mesh for the first time; nothing: it meets none of it.
std::optional<WallHit> wallLeft(const TetLocator& locator, const Segment& ray);

/// The boundary of a mesh as walls that reflect `color` of the light in all directions, seen from
/// their inside alone: from outside one looks into the building. Lamps' light comes through the
/// smoke, which so casts shadows (Staubli et al. 2005, section 4.3). Where the corners of a
/// triangle see a lamp alike, within a hundredth of its light, what reaches a point is between
/// them; elsewhere each pixel looks for the lamp by itself, so that the edges of shadows are those
/// of what casts them. `blocks`: other opaque things. `only`: empty, or one for each pixel: those
/// that are asked for.
[[nodiscard]] Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                              const SceneLights& lights, const Rgb& color,
                                              const Blocks& blocks = {},
                                              std::span<const std::uint8_t> only = {});

}  // namespace volute
