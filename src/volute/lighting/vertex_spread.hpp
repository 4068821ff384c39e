// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// What stands at a vertex for a lamp's irradiance around it.
struct VertexIrradiance {
  std::int32_t vertex = 0;
  Rgb value = Rgb::Zero();
};

/// A lamp smaller than the cells around it is stronger at a vertex than anywhere in its cells, or
/// weaker. Here are values, by vertex, that are right in the mean of the cells where they are
/// linear between vertices; elsewhere those of Lamp::irradiance() are near to them. Empty for a
/// lamp outside of the mesh, and for one that is as large as its cell.
std::vector<VertexIrradiance> spreadIrradiance(const TetLocator& locator, const Lamp& lamp);

}  // namespace volute
