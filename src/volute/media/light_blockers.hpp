// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

/// How far a way begins from its point and ends before its lamp, either of which may be on a
/// surface, to the rounding of its own coordinates [m].
double surfaceLift(const Vec3& point);

/// What stands between lamps and a medium; empty where there is no geometry. Where ways begin
/// later, nothing is in the way before that.
Blocks blocksOf(const TriangleScene& geometry);

/// Shadows of geometry as intervals of segments, exactly.
ShadowsOn shadowsOf(const TriangleScene& geometry);

/// Stands for the triangles where computed light is kept.
std::string keyOf(const TriangleScene& geometry);

}  // namespace volute
