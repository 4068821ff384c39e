// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
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

  bool operator==(const CellSoup&) const = default;
};

/// Vertices in the middle of faces and cells, where these could not be cut from their corners.
struct AddedVertices {
  std::vector<Vec3> places;             ///< [m]
  std::vector<std::size_t> offsets{0};  ///< vertex i is made of offsets[i] .. offsets[i + 1]
  std::vector<std::int32_t> from{};     ///< the soup's vertices that it is made of
  std::vector<double> shares{};         ///< of each of them; they sum to 1 for each vertex

  /// Values at the soup's vertices, followed by those at the added ones: the same shares of the
  /// values as of the places, so that a linear field stays exact, and never beyond them.
  std::vector<float> follow(std::vector<float> values) const;
};

/// Tets out of cells. Vertices are those of the soup, then the added ones.
struct SplitCells {
  std::vector<Tet> tets;
  std::vector<std::int32_t> cellOf;  ///< the cell of each tet
  AddedVertices added;

  /// The vertices of the tets.
  std::vector<Vec3> vertices(const CellSoup& soup) const;
};

/// Splits cells into tets so that neighbours meet. A face is cut the same way from both of its
/// sides: into a fan from its vertex of least index, from the next one where a triangle of that
/// fan would be flat (a vertex in the middle of an edge: what refinement leaves) or folded, else
/// from the mean of its corners. A cell is cut into the pyramids over the pieces of its faces from
/// its vertex of least index, from the next one where a tet of those would be flat or inverted,
/// else from the mean of its corners or another place that sees all its faces from within. Flat is
/// what has less than a hundredth of its fair share; where there is nothing better, 1e-9 of it.
///
/// Vertices on an edge that some faces of a polyhedron name and others leave out are put into all
/// faces that have the edge.
///
/// Fails, with `name` first, for cells without volume, cells that their faces do not close, and
/// those that are seen from no place inside.
[[nodiscard]] Result<SplitCells> splitCells(const CellSoup& soup, std::string_view name);

}  // namespace volute
