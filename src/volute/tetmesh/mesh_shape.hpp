// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// What a mesh looks like as a whole.
struct MeshShape {
  double volume = 0;    ///< [m3]
  int parts = 0;        ///< that do not hang together by faces
  bool convex = false;  ///< but for dents of a millionth of its size
};

/// Takes a walk over the tets and a sort of the boundary's edges.
MeshShape shapeOf(const TetMesh& mesh);

}  // namespace volute
