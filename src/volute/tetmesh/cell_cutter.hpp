// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <map>

#include "volute/tetmesh/cell_faces.hpp"
#include "volute/tetmesh/split_cells.hpp"

namespace volute {

/// Cuts one cell after the other into tets; see splitCells().
class CellCutter {
 public:
  CellCutter(const CellSoup& soup, SplitCells& out) : soup_(soup), out_(out) {}

  /// Adds the tets of a cell with these faces, aligned. Fails with half a sentence.
  [[nodiscard]] Status cut(std::int32_t cell, const std::vector<Polygon>& faces);

 private:
  using Corners = std::array<std::int64_t, 3>;

  Vec3 place(std::int64_t vertex) const;
  Status cutFace(const Polygon& face);
  std::int64_t middleOf(const Polygon& face);
  std::int64_t add(std::span<const std::int64_t> from, std::span<const double> shares);

  /// The least share of the volume of a tet from `tip` over the triangles without `vertex`, times
  /// their number; something less where it is not above `enough`.
  double minShare(const Vec3& tip, std::int64_t vertex, double volume, double enough) const;
  Vec3 placeInside(const Vec3& middle, double volume) const;

  const CellSoup& soup_;
  SplitCells& out_;
  std::map<Polygon, std::int64_t> middles_;  ///< of faces that are cut from there
  std::vector<Corners> triangles_;           ///< of the cell's faces
  std::vector<std::int64_t> corners_;        ///< of the cell, ascending
};

}  // namespace volute
