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

/// Shapes of cells, vertices in VTK's order: the quads of a hexahedron are 0123 below and 4567
/// above; a wedge has triangles 012 and 345; a pyramid the quad 0123 and the tip 4.
enum class CellShape : std::uint8_t { kTet, kPyramid, kWedge, kHexahedron, kPolyhedron };

/// Cells as a file has them.
struct CellSoup {
  std::vector<Vec3> vertices;         ///< [m]
  std::vector<CellShape> shapes;      ///< one for each cell
  std::vector<std::int64_t> offsets;  ///< cell i is connectivity[offsets[i]] .. [offsets[i + 1]]
  /// Vertices; of a polyhedron: the number of faces, then for each its number of vertices and they.
  std::vector<std::int64_t> connectivity;

  std::size_t cells() const { return shapes.size(); }
};

/// Tets out of cells.
struct SplitCells {
  std::vector<Vec3> vertices;  ///< those of the soup, then centres of polyhedra and hexahedra
  std::vector<Tet> tets;
  std::vector<std::int32_t> cellOf;  ///< the cell of each tet
  /// For each added vertex: the soup's vertices that it is the mean of.
  std::vector<std::vector<std::int32_t>> means;
};

/// Splits cells into tets so that neighbours meet: a shared polygon is cut from its vertex of least
/// index on both sides. Wedges and hexahedra whose quads' cuts leave no split into their own
/// vertices, and polyhedra, get a vertex in their middle; pieces without volume are left out.
[[nodiscard]] Result<SplitCells> splitCells(const CellSoup& soup, std::string_view name);

/// A field on the soup's vertices, carried on to the added ones.
std::vector<float> withMeans(const SplitCells& split, std::vector<float> pointValues);

}  // namespace volute
