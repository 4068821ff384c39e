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
#include "volute/media/medium_snapshot.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
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
/// smoke, which so casts shadows (Staubli et al. 2005, section 4.3), within 2e-3 of the
/// light without smoke; shadows of walls, and of other opaque things, `blocks`, have exact edges.
/// `only`: empty, or one for each pixel: those that are asked for. `known`: null, or what earlier
/// pictures of the same smoke and lamps found out.
[[nodiscard]] Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                              const SceneLights& lights, const Rgb& color,
                                              const Blocks& blocks = {},
                                              std::span<const std::uint8_t> only = {},
                                              WallLight* known = nullptr);

}  // namespace volute
