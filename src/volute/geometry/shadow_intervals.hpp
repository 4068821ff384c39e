// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/geometry/sun_tree.hpp"
#include "volute/geometry/triangle_tree.hpp"

namespace volute {

/// What TriangleScene::shadows says. A segment and a light span a plane. In it a point is
///   x = origin + a direction + c w,   w = the direction to a far light, or light - origin;
/// a triangle cuts the plane along a line, and the part of that line on the light's side (c > 0,
/// before a near light c < 1) keeps the light from the segment's points s = a, for a near light
/// s = a / (1 - c). A segment within 1e-7 rad of the light's direction is taken to lead to it.
void shadowsOn(const Segment& segment, const LightPoint& light, const TriangleTree& tree,
               std::vector<Interval>& dark);

/// The same of a far light for which there is a tree: the same intervals from a few triangles.
/// `along` is asked where the segment leads to the light, and serves as TriangleScene does.
void shadowsOn(const Segment& segment, const LightPoint& light, const SunTree& tree,
               const TriangleScene& along, std::vector<Interval>& dark);

}  // namespace volute
