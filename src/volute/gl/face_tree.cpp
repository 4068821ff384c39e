// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/face_tree.hpp"

namespace volute {
namespace {

struct Item {
  Box3 box;
  std::int32_t face = 0;
};

/// The boundary's half-face with the sign that its edges have for rays that enter.
Item itemOf(const TetMesh& mesh, const TetFace& face, const Vec3& middle) {
  Item item;
  std::array<Vec3, 3> corner;
  for (int i = 0; i < 3; ++i) {
    corner[i] = mesh.vertices()[face.vertices[i]] - middle;
    item.box.extend(corner[i]);
  }
  const Vec3 across = mesh.vertices()[mesh.tets()[face.first / 4][face.first % 4]] - middle;
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  item.face = 2 * face.first + (normal.dot(across - corner[0]) > 0 ? 1 : 0);
  return item;
}

}  // namespace

FaceTree::FaceTree(const TetMesh& mesh, const Vec3& middle) {
  std::vector<Box3> boxes;
  std::vector<std::int32_t> marks;
  for (const std::int32_t face : mesh.boundary()) {
    const Item item = itemOf(mesh, mesh.faces()[face], middle);
    boxes.push_back(item.box);
    marks.push_back(item.face);
  }
  BoxTree tree(boxes);
  nodes = std::move(tree.nodes);
  for (const std::int32_t item : tree.items) faces.push_back(marks[item]);
}

}  // namespace volute
