// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

// Fields are one float for each vertex, linear in each tet.

namespace volute {

/// What is done about negative values, which concentrations cannot have.
enum class Negatives { kRefuse, kClamp, kKeep };

/// Refuses values that are not finite, and negative ones unless they are to be clamped to 0 or
/// kept. Returns how many were clamped.
[[nodiscard]] Result<std::size_t> checkField(std::span<float> values, Negatives negatives,
                                             std::string_view name);

/// What is conserved where values of cells become values at vertices: the values, or their
/// inverses.
enum class CellMean { kValues, kInverses };

/// Values at vertices from values of cells: the mean of the tets around a vertex by volume.
/// `cellOf` gives the cell of each tet; empty when cells are the tets. `weights` of the cells
/// multiply their volumes; empty: all are 1. A vertex where they are all 0 gets 0.
std::vector<float> cellToPoint(const TetMesh& mesh, std::span<const float> cellValues,
                               std::span<const std::int32_t> cellOf,
                               CellMean mean = CellMean::kValues,
                               std::span<const float> weights = {});

/// (1 - share) a + share b. Values between two snapshots, share in [0, 1].
void interpolateFields(std::span<const float> a, std::span<const float> b, double share,
                       std::span<float> out);

}  // namespace volute
