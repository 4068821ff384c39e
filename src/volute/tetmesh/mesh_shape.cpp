// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/mesh_shape.hpp"

#include <algorithm>

namespace volute {
namespace {

int countParts(const TetMesh& mesh) {
  const auto opposites = mesh.opposites();
  std::vector<bool> seen(mesh.tets().size(), 0);
  std::vector<std::int32_t> todo;
  int parts = 0;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first])
      continue;
    ++parts;
    seen[first] = true;
    todo.push_back(static_cast<std::int32_t>(first));
    while (!todo.empty()) {
      const std::int32_t tet = todo.back();
      todo.pop_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t other = opposites[static_cast<std::size_t>(4 * tet + k)];
        if (other == TetMesh::kBoundary || seen[static_cast<std::size_t>(other / 4)])
          continue;
        seen[static_cast<std::size_t>(other / 4)] = true;
        todo.push_back(other / 4);
      }
    }
  }
  return parts;
}

/// An edge of a boundary face, and the face's third vertex.
struct RimEdge {
  std::int32_t low, high, across, face;

  auto key() const { return std::pair(low, high); }
};

/// Of one part whose boundary bends inwards at no edge.
bool isConvex(const TetMesh& mesh) {
  constexpr double kDent = 1e-6;  // of the mesh's size; what float coordinates leave
  std::vector<RimEdge> edges;
  for (const std::int32_t f : mesh.boundary()) {
    const auto& v = mesh.faces()[static_cast<std::size_t>(f)].vertices;
    for (int k = 0; k < 3; ++k) edges.push_back({v[k == 0], v[k == 2 ? 1 : 2], v[k], f});
  }
  std::ranges::sort(edges, {}, &RimEdge::key);
  const auto at = [&](std::int32_t v) { return mesh.vertices()[static_cast<std::size_t>(v)]; };
  const double most = kDent * mesh.bounds().size().norm();
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    if (i + 1 >= edges.size() || edges[i].key() != edges[i + 1].key() ||
        (i + 2 < edges.size() && edges[i].key() == edges[i + 2].key()))
      return false;  // surfaces that touch
    if (edges[i].across != edges[i + 1].across && at(edges[i].across) == at(edges[i + 1].across))
      return false;  // the edge of a thin wall
    const TetFace& face = mesh.faces()[static_cast<std::size_t>(edges[i].face)];
    const Vec3 corner = at(face.vertices[0]);
    Vec3 normal = (at(face.vertices[1]) - corner).cross(at(face.vertices[2]) - corner).normalized();
    const Tet& tet = mesh.tets()[static_cast<std::size_t>(face.first / 4)];
    if (normal.dot(at(tet[static_cast<std::size_t>(face.first % 4)]) - corner) > 0)
      normal = -normal;
    if (normal.dot(at(edges[i + 1].across) - corner) > most)
      return false;
  }
  return true;
}

}  // namespace

MeshShape shapeOf(const TetMesh& mesh) {
  MeshShape shape;
  for (std::size_t t = 0; t < mesh.tets().size(); ++t)
    shape.volume += mesh.volume(static_cast<std::int32_t>(t));
  shape.parts = countParts(mesh);
  shape.convex = shape.parts == 1 && isConvex(mesh);
  return shape;
}

}  // namespace volute
