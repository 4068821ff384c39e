// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/io/mesh.hpp"

namespace volute {

/// The corners of a face in turn [m].
using WallPolygon = std::vector<Vec3>;

/// Those of `walls` that are there twice, once each: cells lie on both sides. None that `open` has:
/// the same face is let through in part.
std::vector<WallPolygon> wallsWithin(std::span<const WallPolygon> walls,
                                     std::span<const WallPolygon> open);

/// Gives the cells on both sides of walls vertices of their own, so that nothing is averaged
/// through a wall; its free edges stay shared. Values of vertices, which may be null, are copied
/// with these. Returns the walls that faces of cells lie on, as triangles.
std::vector<WallCorners> splitAtWalls(std::span<const WallPolygon> walls, CellSoup& soup,
                                      std::vector<float>* values);

}  // namespace volute
