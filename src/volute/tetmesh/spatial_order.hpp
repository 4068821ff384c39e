// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// An order of points that keeps neighbours near: along a Morton curve through their bounds. Entry
/// i is the point that comes at place i; ties by index.
std::vector<std::int32_t> spatialOrder(std::span<const Vec3> points);

/// Where each vertex and tet of a reordered mesh was before.
struct MeshOrder {
  std::vector<std::int32_t> vertexFrom, tetFrom;
};

/// Reorders vertices and tets in space, so that a walk from face to face stays in the caches:
/// generators of meshes number them as they please.
MeshOrder reorderInSpace(std::vector<Vec3>& vertices, std::vector<Tet>& tets);

}  // namespace volute
