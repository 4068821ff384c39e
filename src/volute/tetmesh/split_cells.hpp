// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// Shapes of cells, vertices in VTK's order: a hexahedron has the quads 0123 and 4567, a wedge the
/// triangles 012 and 345, a pyramid the quad 0123 and the tip 4.
enum class CellShape : std::uint8_t { kTet, kPyramid, kWedge, kHexahedron, kPolyhedron };

/// Cells as a file has them.
struct CellSoup {
  std::vector<Vec3> vertices;         ///< [m]
  std::vector<CellShape> shapes;      ///< one for each cell
  std::vector<std::int64_t> offsets;  ///< cell i is connectivity[offsets[i]] .. [offsets[i + 1]]
  /// Vertices; of a polyhedron: the number of faces, then for each its number of vertices and they.
  std::vector<std::int64_t> connectivity;
};

/// Tets out of cells, on the same vertices.
struct SplitCells {
  std::vector<Tet> tets;
  std::vector<std::int32_t> cellOf;  ///< the cell of each tet
};

/// Splits convex cells into tets so that neighbours meet: each face is cut into a fan from its
/// vertex of least index, on both of its sides, and each cell into the pyramids from its own such
/// vertex over the pieces of the faces that do not have it.
[[nodiscard]] Result<SplitCells> splitCells(const CellSoup& soup, std::string_view name);

}  // namespace volute
