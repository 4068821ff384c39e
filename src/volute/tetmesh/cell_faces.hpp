// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/split_cells.hpp"

namespace volute {

/// Vertices of a face in turn.
using Polygon = std::vector<std::int64_t>;

/// The faces of a cell as its file has it, all outwards or all inwards but those of a polyhedron.
/// Collapsed edges (a vertex named twice in a row) are left out, and faces that have collapsed to
/// an edge. Empty when the list does not add up.
std::vector<Polygon> cellFaces(CellShape shape, std::span<const std::int64_t> cell);

/// Turns faces so that all point outwards or all inwards: two faces pass the edge between them in
/// opposite senses. Fails with half a sentence when they do not enclose one body.
[[nodiscard]] Status alignFaces(std::vector<Polygon>& faces);

}  // namespace volute
