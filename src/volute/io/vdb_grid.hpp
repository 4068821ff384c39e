// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <openvdb/openvdb.h>

namespace volute {

/// An empty grid, made by OpenVDB's registry (after openvdb::initialize()). `Grid::create()` would
/// instantiate all virtual functions of the grid and its tree here: 6 s of a compiler's time for
/// each type.
template <class Grid>
typename Grid::Ptr emptyGrid(const typename Grid::ValueType& background) {
  auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
  grid->tree().root().setBackground(background, false);
  return grid;
}

}  // namespace volute
