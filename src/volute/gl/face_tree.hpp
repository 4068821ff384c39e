// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "volute/gl/box_tree.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

/// A tree of boxes over a mesh's boundary faces, as glsl/smoke.glsl reads it. Places are floats
/// from `middle`.
struct FaceTree {
  using Node = BoxTree::Node;

  std::vector<Node> nodes;  ///< [0] is the root
  /// 2 * half-face, + 1 where a ray that enters by it has positive edge functions.
  std::vector<std::int32_t> faces;

  FaceTree(const TetMesh& mesh, const Vec3& middle);
};

}  // namespace volute
