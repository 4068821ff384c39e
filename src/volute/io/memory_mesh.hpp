// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/split_cells.hpp"

namespace volute {

/// Cells in memory with fields over time: what MeshSource reads of a file, made by a program.
struct MemoryMesh {
  struct Field {
    std::string name;
    bool ofCells = false;                    ///< a value for each cell, else for each vertex
    std::vector<std::vector<float>> values;  ///< of each time
  };

  CellSoup cells;
  std::vector<double> times{0};  ///< [s], ascending
  std::vector<Field> fields;
  std::uint64_t ghosts = 0;  ///< cells that were marked as such, and left out

  /// kInvalidArgument, with the name of the mesh: no times or fields, times that do not ascend,
  /// fields of one name or of other numbers of values than there are times, vertices or cells.
  /// That cells are such, reading the mesh checks.
  [[nodiscard]] Status validate(const std::string& name) const;
};

}  // namespace volute
