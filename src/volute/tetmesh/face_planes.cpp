// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/face_planes.hpp"

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kPlaneGrain = 4096;

}  // namespace

FacePlanes::FacePlanes(const TetMesh& mesh)
    : planes(mesh.faces().size()), sides(mesh.tets().size()) {
  parallelRanges(planes.size(), kPlaneGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const TetFace& face = mesh.faces()[f];
      const Vec3 v[3] = {mesh.vertices()[face.vertices[0]], mesh.vertices()[face.vertices[1]],
                         mesh.vertices()[face.vertices[2]]};
      Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
      const std::int32_t apex = mesh.tets()[face.first / 4][face.first % 4];
      if (normal.dot(v[0] - mesh.vertices()[apex]) < 0)
        normal = -normal;
      planes[f] = {normal, normal.dot(v[0])};
      sides[face.first / 4][face.first % 4] = static_cast<std::int32_t>(2 * f);
      if (face.second != TetMesh::kBoundary)
        sides[face.second / 4][face.second % 4] = static_cast<std::int32_t>(2 * f + 1);
    }
  });
}

}  // namespace volute
