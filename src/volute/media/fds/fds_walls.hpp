// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// Walls of an FDS case that are made of triangles (GEOM) and stand still: closed bodies, in the
/// colours of their surfaces. What moves is named in `remarks`.
[[nodiscard]] Result<TriangleMesh> fdsWalls(const SmvIndex& index, std::vector<Remark>& remarks);

}  // namespace volute
