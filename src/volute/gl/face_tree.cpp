// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/face_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace volute {
namespace {

constexpr std::size_t kLeaf = 4;  ///< faces at most

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

/// Rounded outwards by more than a float's rounding.
void setBox(FaceTree::Node& node, std::span<const Item> items) {
  Box3 box;
  for (const Item& item : items) {
    box.extend(item.box.min);
    box.extend(item.box.max);
  }
  const double margin = 1e-6 * (box.min.cwiseAbs().maxCoeff() + box.max.cwiseAbs().maxCoeff());
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis] = static_cast<float>(box.min[axis] - margin);
    node.high[axis] = static_cast<float>(box.max[axis] + margin);
  }
}

void split(FaceTree& tree, std::size_t at, std::span<Item> items) {
  setBox(tree.nodes[at], items);
  if (items.size() <= kLeaf) {
    tree.nodes[at].first = static_cast<std::int32_t>(tree.faces.size());
    tree.nodes[at].count = static_cast<std::int32_t>(items.size());
    for (const Item& item : items) tree.faces.push_back(item.face);
    return;
  }
  int axis = 0;
  const FaceTree::Node& node = tree.nodes[at];
  for (int i = 1; i < 3; ++i) {
    if (node.high[i] - node.low[i] > node.high[axis] - node.low[axis])
      axis = i;
  }
  const std::size_t half = items.size() / 2;
  std::ranges::nth_element(items, items.begin() + static_cast<std::ptrdiff_t>(half), {},
                           [&](const Item& item) { return item.box.centre()[axis]; });
  const std::size_t children = tree.nodes.size();
  tree.nodes[at].first = static_cast<std::int32_t>(children);
  tree.nodes.resize(children + 2);
  split(tree, children, items.first(half));
  split(tree, children + 1, items.subspan(half));
}

}  // namespace

FaceTree::FaceTree(const TetMesh& mesh, const Vec3& middle) : nodes(1) {
  std::vector<Item> items;
  for (const std::int32_t face : mesh.boundary())
    items.push_back(itemOf(mesh, mesh.faces()[face], middle));
  split(*this, 0, items);
}

}  // namespace volute
