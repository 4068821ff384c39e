// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/inner_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace volute {
namespace {

constexpr double kFileRounding = 1e-5;  ///< of the mesh's size, and of 1 m
constexpr double kFloatRounding = 0x1p-24;
constexpr double kOfCell = 0.02;     ///< what is rounded more than this has no cells left
constexpr double kMinCosine = 0.25;  ///< between a way inwards and the normals around a vertex

bool hasFloats(const TetMesh& mesh) {
  return std::ranges::all_of(mesh.vertices(), [](const Vec3& point) {
    return point.cast<float>().cast<double>() == point;
  });
}

struct BoundaryFace {
  std::array<std::int32_t, 3> vertices;
  Vec3 inwards;  ///< unit
};

std::vector<BoundaryFace> boundaryOf(const TetMesh& mesh) {
  const auto points = mesh.vertices();
  std::vector<BoundaryFace> faces;
  faces.reserve(mesh.boundary().size());
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[static_cast<std::size_t>(f)];
    const auto& [a, b, c] = face.vertices;
    Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    const Vec3& inner = points[mesh.tets()[face.first / 4][face.first % 4]];
    if (normal.dot(inner - points[a]) < 0)
      normal = -normal;
    if (const double length = normal.norm(); length > 0)
      faces.push_back({face.vertices, normal / length});
  }
  return faces;
}

}  // namespace

double wallRounding(const TetMesh& mesh) {
  const Box3& box = mesh.bounds();
  double rounding = kFileRounding * (1 + box.size().maxCoeff());
  if (hasFloats(mesh)) {
    const double largest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
    const double cell = std::cbrt(6 * box.size().prod() / static_cast<double>(mesh.tets().size()));
    rounding += std::min(kFloatRounding * largest, kOfCell * cell);
  }
  return rounding;
}

std::vector<Vec3> innerVertices(const TetMesh& mesh, double distance) {
  const auto points = mesh.vertices();
  const std::vector<BoundaryFace> faces = boundaryOf(mesh);
  // Means of normals by angle do not depend on how walls are cut into faces.
  std::vector<Vec3> ways(points.size(), Vec3::Zero());
  for (const BoundaryFace& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& corner = points[face.vertices[k]];
      const Vec3 a = points[face.vertices[(k + 1) % 3]] - corner;
      const Vec3 b = points[face.vertices[(k + 2) % 3]] - corner;
      ways[face.vertices[k]] += std::atan2(a.cross(b).norm(), a.dot(b)) * face.inwards;
    }
  }
  for (Vec3& way : ways) {
    const double length = way.norm();
    way = length > 1e-6 ? Vec3(way / length) : Vec3(Vec3::Zero());
  }
  std::vector<double> cosines(points.size(), 1);
  for (const BoundaryFace& face : faces) {
    for (const std::int32_t v : face.vertices)
      cosines[v] = std::min(cosines[v], ways[v].dot(face.inwards));
  }
  std::vector<Vec3> inner(points.begin(), points.end());
  for (std::size_t v = 0; v < inner.size(); ++v)
    inner[v] += distance / std::max(cosines[v], kMinCosine) * ways[v];
  return inner;
}

Vec3 innerPoint(const TetMesh& mesh, std::int32_t tet, const Vec3& point, double distance) {
  double steepest = 0;
  for (const Vec3& slope : mesh.slopes(tet)) steepest = std::max(steepest, slope.norm());
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t v : mesh.tets()[tet]) centre += 0.25 * mesh.vertices()[v];
  return point + std::min(0.5, 4 * distance * steepest) * (centre - point);
}

InnerSide::InnerSide(const TetMesh& mesh, bool surfaces) : vertices_(mesh.vertices()) {
  if (!surfaces)
    return;
  rounding_ = wallRounding(mesh);
  inner_ = innerVertices(mesh, lift());
  vertices_ = inner_;
}

}  // namespace volute
