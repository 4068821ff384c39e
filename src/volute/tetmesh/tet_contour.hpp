// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Triangles with a value at each vertex. Vertices are shared between triangles.
struct ContourSurface {
  std::vector<Vec3> vertices;                          ///< [m]
  std::vector<float> values;                           ///< one for each vertex
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< seen from where the field is less, in
                                                       ///< counter-clockwise order
};

/// The surface on which a field, linear in each tet, has the value `level`: exact, closed but for
/// the mesh's boundary. Its vertices carry `values`, another field, or nothing when that is empty.
/// Where the field is `level` on a whole vertex, edge or face the surface passes just above it.
ContourSurface contourSurface(const TetMesh& mesh, std::span<const float> field, double level,
                              std::span<const float> values = {});

/// A plane's cut through the mesh, with the field on it: the contour slices that Staubli et al.
/// 2005, figure 2, set beside the volume. The plane is normal . x = offset.
ContourSurface contourSlice(const TetMesh& mesh, const Vec3& normal, double offset,
                            std::span<const float> values);

}  // namespace volute
